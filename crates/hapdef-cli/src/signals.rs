//! Ctrl-C and its like.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::PrepareError;

/// Exit code of a program that a second Ctrl-C ends at once.
const INTERRUPTED: i32 = 130;

/// Sets `stop` on the first SIGINT, SIGTERM or SIGHUP and ends the process at once on the second.
///
/// # Errors
/// [`PrepareError::Signal`] when the process has a handler already.
pub fn stop_on_signals(stop: Arc<AtomicBool>) -> Result<(), PrepareError> {
    ctrlc::set_handler(move || {
        if stop.swap(true, Ordering::Relaxed) {
            std::process::exit(INTERRUPTED);
        }
    })
    .map_err(PrepareError::Signal)
}
