//! Live contacts as an iterator.

use std::sync::mpsc::RecvTimeoutError;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use hapdef::touch::{EstimatorKind, SearchPlace};
use hapdef::{Contacts, OpenScene, RigPlay, SourceArg};
use hapdef_live::LiveFrame;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::error::{HapdefError, to_python};
use crate::live_frame::PyLiveFrame;
use crate::work::work;

/// How often Python is asked whether someone pressed Ctrl-C.
const LOOK: Duration = Duration::from_millis(50);

/// What is to be played or read.
pub(crate) struct LiveRequest {
    pub kind: EstimatorKind,
    /// What is played where no source is named.
    pub play: RigPlay,
    pub tare_s: f64,
    /// The topic that is read of a recording of another program.
    pub topic: Option<String>,
}

/// A running stream of frames; an iterator that ends with its source. Leaving a `with` block, or
/// `close()`, ends it.
#[pyclass(frozen, module = "hapdef", name = "Live")]
pub struct PyLive {
    running: Mutex<Option<Contacts>>,
    source: String,
}

#[pymethods]
impl PyLive {
    /// Name of the source.
    #[getter]
    fn source(&self) -> &str {
        &self.source
    }

    /// Takes a new tare of the next frames, which must be untouched.
    fn tare(&self) {
        self.with(|running| running.live().control().tare());
    }

    /// Why the last tare was refused or does not hold, and what to do; `None` if it holds. As of at most a
    /// second ago.
    #[getter]
    fn tare_fault(&self) -> Option<String> {
        let health = self.with(|running| running.live().health())?;
        health.tare_fault.as_ref().map(|fault| fault.to_string())
    }

    /// Counts since the start: frames, lost, dropped, refused, and the 99th percentile of the
    /// computing time in µs; `None` when it is closed.
    fn health<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, pyo3::types::PyDict>>> {
        let Some(health) = self.with(|running| running.live().health()) else {
            return Ok(None);
        };
        let dict = pyo3::types::PyDict::new(py);
        dict.set_item("n_frames", health.n_frames)?;
        dict.set_item("n_lost", health.n_lost)?;
        dict.set_item("n_dropped", health.n_dropped)?;
        dict.set_item("n_refused", health.n_refused)?;
        dict.set_item("compute_p99_us", health.total.compute.p99_us)?;
        Ok(Some(dict))
    }

    /// Ends it.
    fn close(&self, py: Python<'_>) {
        let running = self.running().take();
        py.detach(|| drop(running));
    }

    fn __iter__(slf: Bound<'_, Self>) -> Bound<'_, Self> {
        slf
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<PyLiveFrame>> {
        loop {
            match py.detach(|| self.next()) {
                Some(Ok(frame)) => return Ok(Some(PyLiveFrame::new(frame))),
                Some(Err(RecvTimeoutError::Timeout)) => py.check_signals()?,
                Some(Err(RecvTimeoutError::Disconnected)) => return self.end().map(|()| None),
                None => return Ok(None),
            }
        }
    }

    fn __enter__(slf: Bound<'_, Self>) -> Bound<'_, Self> {
        slf
    }

    #[pyo3(signature = (*_raised))]
    fn __exit__(&self, py: Python<'_>, _raised: &Bound<'_, pyo3::types::PyTuple>) {
        self.close(py);
    }
}

impl PyLive {
    /// Starts a stream from `source`, or from the scene's simulated rig.
    pub(crate) fn start(
        py: Python<'_>,
        scene: &OpenScene,
        source: Option<&str>,
        request: LiveRequest,
    ) -> PyResult<Self> {
        let LiveRequest { kind, play, tare_s, topic } = request;
        let arg = source.map(|text| source_arg(text, topic.as_deref())).transpose()?;
        let (mut source, estimator) = work(py, scene, move |scene| {
            let source = match arg {
                Some(arg) => scene.source(&arg)?,
                None => scene.rig_source(&play)?,
            };
            Ok((source, scene.estimator(Some(kind), SearchPlace::Here)?))
        })?;
        source.params.tare_s = tare_s;
        let name = source.name();
        let contacts = source.boxed_contacts(estimator).map_err(to_python)?;
        Ok(Self { running: Mutex::new(Some(contacts)), source: name })
    }

    fn running(&self) -> std::sync::MutexGuard<'_, Option<Contacts>> {
        self.running.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn with<T>(&self, work: impl FnOnce(&Contacts) -> T) -> Option<T> {
        self.running().as_ref().map(work)
    }

    /// How the source ended.
    ///
    /// # Errors
    /// `HapdefError` where frames came that could not be used, as `hapdef live` ends with.
    fn end(&self) -> PyResult<()> {
        let Some(health) = self.with(|running| running.live().health()) else {
            return Ok(());
        };
        match &health.device_fault {
            Some(fault) => {
                let text = format!("{}: {fault}", health.source_name);
                Err(HapdefError::new_err(text))
            }
            None => Ok(()),
        }
    }

    /// The next frame; `None` if it is closed.
    fn next(&self) -> Option<Result<LiveFrame, RecvTimeoutError>> {
        self.with(|running| running.next_within(LOOK))
    }
}

fn source_arg(text: &str, topic: Option<&str>) -> PyResult<SourceArg> {
    let named: Result<SourceArg, _> = text.parse();
    let named = named.and_then(|arg| match topic {
        Some(topic) => arg.of_topic(topic),
        None => Ok(arg),
    });
    named.map_err(|e| PyValueError::new_err(format!("source: {e}")))
}
