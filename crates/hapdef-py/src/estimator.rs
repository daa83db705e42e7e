//! Contacts from arrays of frames.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use hapdef::touch::{EstimatorKind, Touch, TouchEstimator};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::array::{Table, rows};
use crate::error::raised;
use crate::estimates::PyEstimates;

/// How long frames are worked on before Python is asked whether someone pressed Ctrl-C.
const LOOK: Duration = Duration::from_millis(50);

/// Finds contacts; used by one thread at a time.
#[pyclass(frozen, module = "hapdef", name = "Estimator")]
pub struct PyEstimator {
    estimator: Mutex<Box<dyn TouchEstimator>>,
    name: &'static str,
    n_gauges: usize,
}

#[pymethods]
impl PyEstimator {
    /// 'superposition', 'tracking' or 'hapdefx'.
    #[getter]
    fn name(&self) -> &'static str {
        self.name
    }

    /// Number of gauges.
    #[getter]
    fn n_gauges(&self) -> usize {
        self.n_gauges
    }

    /// Contacts behind frames of tared readings, µε, `[n_frames, n_gauges]`, in order: what follows
    /// contacts goes on from the frames of the call before.
    fn estimate(&self, py: Python<'_>, readings_ue: Table<'_>) -> PyResult<PyEstimates> {
        let readings = rows("readings_ue", &readings_ue, self.n_gauges)?;
        let frames: Vec<&[f64]> = readings.chunks_exact(self.n_gauges).collect();
        let mut touches = Vec::with_capacity(frames.len());
        while touches.len() < frames.len() {
            py.detach(|| self.some(&frames, &mut touches)).map_err(raised)?;
            py.check_signals()?;
        }
        PyEstimates::new(py, &touches)
    }

    /// Forgets what earlier frames said: a stream begins anew.
    fn start_over(&self, py: Python<'_>) {
        py.detach(|| self.locked(|estimator| estimator.start_over()));
    }

    fn __repr__(&self) -> String {
        format!("Estimator({:?}, {} gauges)", self.name, self.n_gauges)
    }
}

impl PyEstimator {
    /// Wraps an estimator.
    pub(crate) fn new(estimator: Box<dyn TouchEstimator>) -> Self {
        Self {
            name: estimator.name(),
            n_gauges: estimator.n_gauges(),
            estimator: Mutex::new(estimator),
        }
    }

    fn locked<T>(&self, work: impl FnOnce(&mut dyn TouchEstimator) -> T) -> T {
        // What a frame leaves behind when it panics is cleared by the next one.
        let mut estimator = self.estimator.lock().unwrap_or_else(PoisonError::into_inner);
        work(estimator.as_mut())
    }

    /// Works on frames for a while, from the first that is not done.
    fn some(
        &self,
        frames: &[&[f64]],
        touches: &mut Vec<Touch>,
    ) -> Result<(), hapdef_live::LiveError> {
        let start = Instant::now();
        self.locked(|estimator| {
            for frame in &frames[touches.len()..] {
                let mut touch = Touch::default();
                estimator.estimate(frame, &mut touch)?;
                touches.push(touch);
                if start.elapsed() > LOOK {
                    break;
                }
            }
            Ok(())
        })
    }
}

/// What finds contacts, by name.
///
/// # Errors
/// `ValueError` for another name.
pub(crate) fn kind_of(name: &str) -> PyResult<EstimatorKind> {
    name.parse().map_err(|e| PyValueError::new_err(format!("kind: {e}")))
}
