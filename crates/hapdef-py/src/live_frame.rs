//! A frame of a stream.

use std::collections::BTreeMap;

use hapdef::RawFrame;
use hapdef_live::{LiveFrame, UnknownReason, WhyNot};
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::array::{Numbers, one};
use crate::error::HapdefError;
use crate::estimates::PyContact;
use crate::wrench::{PyWrench, point};

/// One frame: readings and contacts.
#[pyclass(frozen, module = "hapdef", name = "LiveFrame")]
pub struct PyLiveFrame {
    frame: LiveFrame,
}

/// Whether a frame decides for its contacts.
#[pyclass(frozen, get_all, module = "hapdef", name = "Quality")]
pub struct PyQuality {
    /// It does.
    is_identified: bool,
    /// Why not, a word; None if it does.
    why_not: Option<&'static str>,
    /// χ² of the residual.
    chi2: f64,
    /// Its degrees of freedom.
    n_dof: usize,
    /// The probability of a χ² as large.
    p_value: f64,
    /// Other explanations that are nearly as good.
    n_alternatives: usize,
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

    /// 'taring', 'untouched', 'touched' or 'unknown'.
    #[getter]
    fn phase(&self) -> &'static str {
        self.frame.phase.word()
    }

    /// Why the phase is unknown, a word; None if it is not.
    #[getter]
    fn why_unknown(&self) -> Option<&'static str> {
        self.frame.phase.why_unknown().map(UnknownReason::word)
    }

    /// The contacts are not this frame's but the last ones that were explained, or the frame itself is old.
    #[getter]
    fn is_stale(&self) -> bool {
        self.frame.is_stale
    }

    /// The smallest force, N, that would show wherever it pressed, where that is known; infinite where none
    /// would.
    #[getter]
    fn smallest_seen_n(&self) -> Option<f64> {
        self.frame.smallest_seen_n
    }

    /// Whether the frame decides for its contacts, where the estimator can tell.
    #[getter]
    fn quality(&self) -> Option<PyQuality> {
        self.frame.touch.quality.map(|quality| PyQuality {
            is_identified: quality.is_identified(),
            why_not: quality.why_not().map(WhyNot::word),
            chi2: quality.chi2,
            n_dof: quality.n_dof,
            p_value: quality.p_value,
            n_alternatives: quality.n_alternatives,
        })
    }

    /// The contacts where a controller may act on them, also that there are none; raises HapdefError with
    /// the reason while taring and where the phase is unknown.
    fn known_contacts(&self) -> PyResult<Vec<PyContact>> {
        let known = self.frame.known_contacts();
        let known = known.map_err(|phase| HapdefError::new_err(phase.to_string()))?;
        Ok(known.iter().map(|contact| PyContact::new(*contact)).collect())
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

    /// What else the device measures of how the whole limb is loaded, by name, as it came.
    #[getter]
    fn signals(&self) -> BTreeMap<String, f64> {
        let signals = self.frame.signals.iter();
        signals.map(|(signal, value)| (signal.to_string(), *value)).collect()
    }

    /// The contacts, the oldest first where they are followed, else the strongest.
    #[getter]
    fn contacts(&self) -> Vec<PyContact> {
        let contacts = self.frame.touch.contacts.iter();
        contacts.map(|contact| PyContact::new(*contact)).collect()
    }

    /// The net wrench of the contacts about a point of the limb's frame, m, `[3]`, its origin if not given; None where
    /// a contact's direction is not known. Ask `known_contacts` whether a controller may act on it.
    #[pyo3(signature = (about_m = None))]
    fn wrench(&self, about_m: Option<Numbers<'_>>) -> PyResult<Option<PyWrench>> {
        let about_m = about_m.map(|about_m| point(&about_m)).transpose()?;
        Ok(self.frame.wrench(about_m.unwrap_or_default()).map(PyWrench::new))
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

    /// Its readings and signals as they came.
    pub(crate) fn raw(&self) -> RawFrame {
        let LiveFrame { raw_ue, signals, .. } = &self.frame;
        RawFrame { readings_ue: raw_ue.clone(), signals: signals.clone() }
    }
}
