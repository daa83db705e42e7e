//! `hapdef export`: recordings as text.

use std::io::{BufWriter, Write};
use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use hapdef_cli::{JsonLines, StandardOutput, shown};
use hapdef_daq::record::{DamageInfo, Recording, export_csv, export_json_lines};

use super::files::new_file;

#[derive(Args)]
#[command(after_help = "Example:\n  hapdef export press.mcap --csv -o press.csv\n\n\
    The table has a line a reading, as sent: counts, or the device's unit where it sends f32. The \
    JSON lines have everything that is in the recording.")]
pub(crate) struct ExportArgs {
    /// The recording: finished, partial or damaged.
    file: PathBuf,
    #[command(flatten)]
    form: Form,
    /// Where to, a new file; standard output if nothing is named.
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
}

#[derive(Args)]
#[group(required = true, multiple = false)]
struct Form {
    /// The readings as a table.
    #[arg(long)]
    csv: bool,
    /// Every record as a line of JSON.
    #[arg(long)]
    jsonl: bool,
}

pub(crate) fn run(args: &ExportArgs) -> Result<()> {
    let mut recording = Recording::open(&args.file)?.with_first_chunk()?;
    let mut out: Box<dyn Write> = match &args.out {
        Some(path) => Box::new(new_file(path, "-o")?),
        None => Box::new(StandardOutput),
    };
    let mut buffered = BufWriter::with_capacity(1 << 16, &mut out);
    let (n, what) = if args.form.csv {
        (export_csv(&mut recording, &mut buffered)?, "readings")
    } else {
        (export_json_lines(&mut recording, &mut JsonLines(&mut buffered))?, "records")
    };
    buffered.flush()?;
    eprintln!("{}: {n} {what}", shown(&args.file));
    tell_damage(recording.damage());
    Ok(())
}

/// What could not be read of a recording, once it was read to its end.
pub(super) fn tell_damage(damage: DamageInfo) {
    if damage.n_damaged > 0 {
        eprintln!(
            "{} damaged stretches, {} bytes, were left out: hapdef recover says what is lost",
            damage.n_damaged, damage.n_damaged_bytes
        );
    }
}
