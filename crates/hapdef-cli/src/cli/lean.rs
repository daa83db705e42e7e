//! Memory that solving a scene frees, given back before what is left is locked.

use anyhow::Result;

/// How long the allocator keeps what was freed, ms; its own 1000 were longer than it takes from solving to locking,
/// and 142 MB stayed locked for good. It reads this when a program starts.
#[cfg(target_os = "linux")]
const KEPT: (&str, &str) = ("MIMALLOC_PURGE_DELAY", "10");

/// Starts this program anew in its own place with an allocator that keeps nothing for long, unless it has one or was told
/// otherwise.
#[cfg(target_os = "linux")]
pub(crate) fn start_lean() -> Result<()> {
    use std::os::unix::process::CommandExt;

    use anyhow::Context;

    if std::env::var_os(KEPT.0).is_some() {
        return Ok(());
    }
    let program = std::env::current_exe().context("--realtime: where this program is")?;
    let mut command = std::process::Command::new(program);
    // it returns only where it fails
    let error = command.args(std::env::args_os().skip(1)).env(KEPT.0, KEPT.1).exec();
    Err(error).context("--realtime: starting this program anew, to give back memory")
}

/// Real-time priority is Linux's alone.
#[cfg(not(target_os = "linux"))]
pub(crate) fn start_lean() -> Result<()> {
    Ok(())
}
