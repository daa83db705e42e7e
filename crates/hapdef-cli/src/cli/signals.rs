//! Ending on Ctrl-C and on SIGTERM.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::Result;

/// A flag that the first SIGINT, SIGTERM or SIGHUP sets; the second ends the program at once.
pub(super) fn stop_flag() -> Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    hapdef_cli::stop_on_signals(Arc::clone(&stop))?;
    Ok(stop)
}
