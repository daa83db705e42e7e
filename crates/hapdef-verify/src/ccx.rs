//! The program `ccx` (CalculiX), where it is installed.

use std::process::Command;
use std::time::Instant;

use hapdef_mesh::{LabelledDisplacements, SolidDeck, read_displacements, write_inp};
use hapdef_report::ReportError;

use crate::VerifyError;

/// Wall seconds of one run of `ccx` on `deck`, and the displacements of the node set `EVERY` where the
/// deck has it.
pub(crate) fn ccx(
    deck: &SolidDeck,
    n_threads: usize,
) -> Result<(f64, LabelledDisplacements), VerifyError> {
    let folder = tempfile::tempdir().map_err(not_run("no temporary folder"))?;
    let path = folder.path().join("deck.inp");
    write_inp(&path, deck)?;
    if deck.node_sets.contains_key("EVERY") {
        // the deck asks for a binary field file; seven printed digits are easier to read
        let text = std::fs::read_to_string(&path).map_err(ReportError::io("reading", &path))?;
        let text = text.replace("*NODE FILE\nU\n", "*NODE PRINT, NSET=EVERY\nU\n");
        std::fs::write(&path, text).map_err(ReportError::io("writing", &path))?;
    }
    let mut command = Command::new("ccx");
    command.current_dir(&folder).args(["-i", "deck"]);
    command.env("OMP_NUM_THREADS", n_threads.to_string());
    let started = Instant::now();
    let output = command.output().map_err(not_run("ccx"))?;
    let took_s = started.elapsed().as_secs_f64();
    let said = String::from_utf8_lossy(&output.stdout);
    if !output.status.success() || !said.contains("Job finished") {
        let last = said.lines().rev().take(3).collect::<Vec<_>>().join(" / ");
        return Err(VerifyError::setup("ccx", "a result", last));
    }
    let result = folder.path().join("deck.dat");
    let printed = if result.exists() { read_displacements(&result)? } else { Vec::new() };
    Ok((took_s, printed))
}

/// What a program prints.
pub(crate) fn output(command: &mut Command) -> Result<String, VerifyError> {
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command.output().map_err(not_run(&name))?;
    if !output.status.success() {
        let text = String::from_utf8_lossy(&output.stderr);
        let line = text.lines().next().unwrap_or("it failed").to_owned();
        return Err(VerifyError::not_run(format!("{name}: {line}")));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// What the system refused, as a reason not to run.
pub(crate) fn not_run(what: &str) -> impl Fn(std::io::Error) -> VerifyError + '_ {
    move |error| VerifyError::not_run(format!("{what}: {error}"))
}
