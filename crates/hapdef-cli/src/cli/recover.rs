//! `hapdef recover`: a whole file from a damaged or unfinished one.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use clap::Args;
use hapdef_cli::{check_printed, print_json, shown};
use hapdef_daq::DaqError;
use hapdef_daq::record::{RecoverInfo, recover};
use serde_json::{Value, json};

/// Exit code for a file of which nothing can be read.
const NOTHING_READABLE: u8 = 3;

#[derive(Args)]
#[command(after_help = "Exit codes: 0 nothing was lost, 1 something was lost and the rest saved, \
    2 the command can't be done, 3 nothing in the file can be read.\n\n\
    Example:\n  hapdef recover press.partial.mcap -o press.mcap")]
pub(crate) struct RecoverArgs {
    /// The recording, damaged or unfinished.
    file: PathBuf,
    /// The new file; FILE.recovered.mcap if none is named.
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Print what was saved and lost as JSON.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &RecoverArgs) -> Result<()> {
    let out = args.out.clone().unwrap_or_else(|| beside(&args.file));
    if out.exists() {
        bail!("{}: is there already; choose another name with -o", shown(&out));
    }
    let code = match recover(&args.file, &out) {
        Ok(info) => {
            report(args, &out, &info)?;
            info.exit_code()
        }
        Err(error @ DaqError::NothingToRecover { .. }) => {
            eprintln!("error: {error}");
            NOTHING_READABLE
        }
        Err(error) => return Err(error.into()),
    };
    check_printed()?;
    match code {
        0 => Ok(()),
        code => std::process::exit(code.into()),
    }
}

/// `press.partial.mcap` becomes `press.recovered.mcap` beside it.
fn beside(file: &Path) -> PathBuf {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let stem = stem.strip_suffix(".partial").unwrap_or(&stem);
    file.with_file_name(format!("{stem}.recovered.mcap"))
}

fn report(args: &RecoverArgs, out: &Path, info: &RecoverInfo) -> Result<()> {
    if args.json {
        return Ok(print_json(&as_json(out, info), false)?);
    }
    println!("{}: {info}", shown(out));
    Ok(())
}

fn as_json(out: &Path, info: &RecoverInfo) -> Value {
    json!({
        "out": out,
        "exit_code": info.exit_code(),
        "n_records": info.n_records,
        "n_frames": info.n_frames,
        "n_missing": info.n_missing,
        "n_gaps": info.n_gaps,
        "n_uncounted": info.n_uncounted,
        "n_undefined": info.n_undefined,
        "span_ns": info.span_ns,
        "n_chunks": info.damage.n_chunks,
        "n_damaged": info.damage.n_damaged,
        "n_damaged_bytes": info.damage.n_damaged_bytes,
        "is_finished": info.damage.is_finished,
        "n_bytes": info.damage.n_bytes,
    })
}
