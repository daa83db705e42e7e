//! CHOLMOD on the same problem, where it is installed.

use std::path::Path;
use std::process::Command;

use super::system::System;
use crate::VerifyError;
use crate::ccx::{not_run, output};

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
    let run = |ordering: &str| -> Result<Cholmod, VerifyError> {
        let mut command = Command::new(&program);
        command.arg(&data).args([ordering, BLOCK]);
        for threads in ["OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"] {
            command.env(threads, "1");
        }
        parse(&output(&mut command)?)
    };
    Ok([("metis", run("METIS")?), ("amd", run("AMD")?)])
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
