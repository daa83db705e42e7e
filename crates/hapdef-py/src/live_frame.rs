//! A frame of a stream.

use hapdef_live::LiveFrame;
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::array::one;
use crate::estimates::PyContact;

/// One frame: readings and contacts.
#[pyclass(frozen, module = "hapdef", name = "LiveFrame")]
pub struct PyLiveFrame {
    frame: LiveFrame,
}

#[pymethods]
impl PyLiveFrame {
    /// Number of its packet.
    #[getter]
    fn seq(&self) -> u32 {
        self.frame.seq
    }

    /// Device time of the sample instant, s.
    #[getter]
    fn t_s(&self) -> f64 {
        self.frame.t_device_us as f64 * 1e-6
    }

    /// Packets missing directly before it: lost, dropped, or not shown because the program was slow.
    #[getter]
    fn n_missing_before(&self) -> u32 {
        let frame = &self.frame;
        let missing = frame.n_lost_before.saturating_add(frame.n_dropped_before);
        missing.saturating_add(frame.n_skipped_before)
    }

    /// 'taring', 'untouched' or 'touched'.
    #[getter]
    fn phase(&self) -> &'static str {
        self.frame.phase.word()
    }

    /// Readings as they came, µε, `[n_gauges]`.
    #[getter]
    fn raw_ue(&self, py: Python<'_>) -> Py<PyArray1<f64>> {
        one(py, self.frame.raw_ue.clone())
    }

    /// Readings less tare and drift, µε, `[n_gauges]`.
    #[getter]
    fn tared_ue(&self, py: Python<'_>) -> Py<PyArray1<f64>> {
        one(py, self.frame.tared_ue.clone())
    }

    /// The contacts, the oldest first where they are followed, else the strongest.
    #[getter]
    fn contacts(&self) -> Vec<PyContact> {
        let contacts = self.frame.touch.contacts.iter();
        contacts.map(|contact| PyContact::new(*contact)).collect()
    }

    /// Names of contacts that were let go in this frame.
    #[getter]
    fn released(&self) -> Vec<u64> {
        self.frame.touch.released.clone()
    }

    fn __repr__(&self) -> String {
        format!(
            "LiveFrame({:.3} s, {}, {} contacts)",
            self.t_s(),
            self.phase(),
            self.frame.touch.contacts.len()
        )
    }
}

impl PyLiveFrame {
    /// Wraps a frame.
    pub(crate) fn new(frame: LiveFrame) -> Self {
        Self { frame }
    }
}
