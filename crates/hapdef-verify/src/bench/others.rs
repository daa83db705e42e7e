//! Other programs on the same problem, where they are installed: CHOLMOD and CalculiX.

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use hapdef_mesh::{SolidDeck, write_inp};

use super::system::System;
use crate::VerifyError;

/// CHOLMOD's times, processor seconds on one thread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cholmod {
    pub(crate) nnz_l: f64,
    pub(crate) analyse_s: f64,
    pub(crate) factor_s: f64,
    pub(crate) solve_s: f64,
    pub(crate) relative_residual: f64,
}

const SOURCE: &str = include_str!("cholmod.c");

/// Right-hand sides per CHOLMOD call; of 16, 64 and 256 the fastest here.
const BLOCK: &str = "64";

/// Compiles and runs CHOLMOD on `system` with METIS and with AMD, with one thread for the BLAS.
///
/// # Errors
/// [`VerifyError::NotRun`] with the reason where compiler, CHOLMOD or an optimised BLAS are missing.
pub(crate) fn cholmod(system: &System) -> Result<[(&'static str, Cholmod); 2], VerifyError> {
    let folder = tempfile::tempdir().map_err(not_run("no temporary folder"))?;
    let (source, program) = (folder.path().join("cholmod.c"), folder.path().join("cholmod"));
    std::fs::write(&source, SOURCE).map_err(not_run("writing cholmod.c"))?;
    let mut compiler = Command::new("cc");
    compiler.arg("-O2").arg("-I/usr/include/suitesparse");
    compiler.arg(&source).arg("-o").arg(&program);
    output(compiler.args(["-lcholmod", "-lm"]))?;
    check_blas(&program)?;
    let data = folder.path().join("system.bin");
    system.write(&data).map_err(not_run("writing the system"))?;
    let run = |ordering| -> Result<Cholmod, VerifyError> {
        let mut command = Command::new(&program);
        command.arg(&data).args([ordering, BLOCK]);
        for threads in ["OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"] {
            command.env(threads, "1");
        }
        parse(&output(&mut command)?)
    };
    Ok([("METIS", run("METIS")?), ("AMD", run("AMD")?)])
}

/// With the reference BLAS the comparison would be with the wrong library.
fn check_blas(program: &Path) -> Result<(), VerifyError> {
    let libraries = output(Command::new("ldd").arg(program))?;
    let blas = libraries
        .lines()
        .find_map(|line| {
            let path = line.split_once("libblas")?.1.split_once("=> ")?.1;
            std::fs::canonicalize(path.split_whitespace().next()?).ok()
        })
        .unwrap_or_default();
    if blas.starts_with("/usr/lib") && blas.to_string_lossy().contains("/blas/libblas") {
        let reason = "CHOLMOD's BLAS is the reference one; install libopenblas-dev";
        return Err(VerifyError::not_run(reason));
    }
    Ok(())
}

fn parse(text: &str) -> Result<Cholmod, VerifyError> {
    let numbers: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    match numbers[..] {
        [nnz_l, analyse_s, factor_s, solve_s, relative_residual] => {
            Ok(Cholmod { nnz_l, analyse_s, factor_s, solve_s, relative_residual })
        }
        _ => Err(VerifyError::not_run(format!("CHOLMOD printed {text:?}"))),
    }
}

/// Wall seconds of one CalculiX run of `deck` with all cores.
///
/// # Errors
/// [`VerifyError::NotRun`] where there is no `ccx` or it fails.
pub(crate) fn calculix(deck: &SolidDeck) -> Result<f64, VerifyError> {
    let folder = tempfile::tempdir().map_err(not_run("no temporary folder"))?;
    write_inp(&folder.path().join("job.inp"), deck)?;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let mut command = Command::new("ccx");
    command.current_dir(&folder).args(["-i", "job"]);
    command.env("OMP_NUM_THREADS", cores.to_string());
    let started = Instant::now();
    let printed = output(&mut command)?;
    let took_s = started.elapsed().as_secs_f64();
    if printed.contains("Job finished") {
        Ok(took_s)
    } else {
        let last = printed.lines().last().unwrap_or_default().to_owned();
        Err(VerifyError::not_run(format!("ccx did not finish: {last}")))
    }
}

fn output(command: &mut Command) -> Result<String, VerifyError> {
    let name = command.get_program().to_string_lossy().into_owned();
    let output =
        command.output().map_err(|error| VerifyError::not_run(format!("{name}: {error}")))?;
    if !output.status.success() {
        let text = String::from_utf8_lossy(&output.stderr);
        let line = text.lines().next().unwrap_or("it failed").to_owned();
        return Err(VerifyError::not_run(format!("{name}: {line}")));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

fn not_run(what: &'static str) -> impl Fn(std::io::Error) -> VerifyError {
    move |error| VerifyError::not_run(format!("{what}: {error}"))
}
