//! Long work: without the interpreter's lock, on as many threads as were asked for, ended by Ctrl-C.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::thread::Builder;
use std::time::Duration;

use hapdef::OpenScene;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::ThreadPoolBuilder;

use crate::error::{Fault, to_python};

/// How often Python is asked whether someone pressed Ctrl-C.
const LOOK: Duration = Duration::from_millis(50);

/// How long work that was stopped may take to leave a checkpoint; beyond that it ends by itself.
const PATIENCE: Duration = Duration::from_secs(5);

/// Stack of a worker thread.
const STACK_BYTES: usize = 8 << 20;

/// Does `work` on a scene, without the interpreter's lock, until it is done or Ctrl-C.
pub(crate) fn work<T: Send + 'static>(
    py: Python<'_>,
    scene: &OpenScene,
    work: impl FnOnce(&OpenScene) -> Result<T, Fault> + Send + 'static,
) -> PyResult<T> {
    let scene = scene.apart();
    let (threads, stop) = (scene.run().threads, Arc::clone(&scene.run().stop));
    interruptible(py, threads, &stop, move || work(&scene))
}

/// Does `work` on `threads` threads of its own. On Ctrl-C `stop` is set, which stages look at, and
/// `KeyboardInterrupt` is raised; what has no place to stop comes to its end in the background.
///
/// # Errors
/// What `work` returns; what a signal's handler raises.
pub(crate) fn interruptible<T: Send + 'static>(
    py: Python<'_>,
    threads: usize,
    stop: &Arc<AtomicBool>,
    work: impl FnOnce() -> Result<T, Fault> + Send + 'static,
) -> PyResult<T> {
    let (sender, mut receiver) = sync_channel(1);
    let pool = ThreadPoolBuilder::new()
        .num_threads(threads)
        .stack_size(STACK_BYTES)
        .build()
        .map_err(|error| to_python(Fault::Threads(error)))?;
    let compute = move || {
        // Nobody waits any more if the work was given up.
        let _ = sender.send(pool.install(work));
    };
    let thread = Builder::new().name("hapdef".to_owned());
    thread
        .spawn(compute)
        .map_err(|error| PyRuntimeError::new_err(format!("starting a thread: {error}")))?;
    loop {
        let result;
        (receiver, result) = py.detach(move || {
            let result = receiver.recv_timeout(LOOK);
            (receiver, result)
        });
        match result {
            Ok(done) => return done.map_err(to_python),
            Err(RecvTimeoutError::Disconnected) => return Err(panicked()),
            Err(RecvTimeoutError::Timeout) => {}
        }
        if let Err(signal) = py.check_signals() {
            stop.store(true, Ordering::Relaxed);
            // Its result is not wanted any more.
            let _ = py.detach(move || receiver.recv_timeout(PATIENCE));
            return Err(signal);
        }
    }
}

fn panicked() -> PyErr {
    PyRuntimeError::new_err(
        "a worker thread of hapdef panicked, which is a fault of hapdef: please report it with the \
         text on standard error",
    )
}
