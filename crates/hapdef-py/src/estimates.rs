//! What frames tell, as arrays.

use hapdef::touch::{Contact, Quality, Touch, Uncertainty};
use hapdef_live::Phase;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::array::{one, two};

/// One contact.
#[pyclass(frozen, module = "hapdef", name = "Contact")]
#[derive(Clone)]
pub struct PyContact {
    contact: Contact,
}

/// Contacts of many frames: one entry a contact, frame by frame, beside one entry a frame.
#[pyclass(frozen, get_all, module = "hapdef", name = "Estimates")]
pub struct PyEstimates {
    /// Frame of each contact `[n_contacts]`.
    frame: Py<PyArray1<i64>>,
    /// Position of each contact, m, `[n_contacts, 3]`.
    position_m: Py<PyArray2<f64>>,
    /// Normal force of each contact, N, `[n_contacts]`.
    force_n: Py<PyArray1<f64>>,
    /// Standard deviation of its position, m, `[n_contacts]`; NaN where the estimator can't tell.
    position_sd_m: Py<PyArray1<f64>>,
    /// Standard deviation of its force, N, `[n_contacts]`; NaN where the estimator can't tell.
    force_sd_n: Py<PyArray1<f64>>,
    /// Contacts of each frame `[n_frames]`.
    count: Py<PyArray1<i64>>,
    /// Whether the frame decides for these contacts `[n_frames]`.
    is_identified: Py<PyArray1<bool>>,
    /// χ² of the residual of each frame `[n_frames]`; NaN where the estimator can't tell.
    chi2: Py<PyArray1<f64>>,
    /// The probability of a χ² as large `[n_frames]`; NaN where the estimator can't tell.
    p_value: Py<PyArray1<f64>>,
}

#[pymethods]
impl PyContact {
    /// Where, m, `[3]`.
    #[getter]
    fn position_m(&self, py: Python<'_>) -> Py<PyArray1<f64>> {
        one(py, self.contact.position_m.coords.as_slice().to_vec())
    }

    /// Its normal force, N.
    #[getter]
    fn force_n(&self) -> f64 {
        self.contact.force_n
    }

    /// Direction of the force on the limb, unit length, `[3]`, where the estimator knows the skin.
    #[getter]
    fn direction(&self, py: Python<'_>) -> Option<Py<PyArray1<f64>>> {
        let direction = self.contact.direction?;
        Some(one(py, direction.as_slice().to_vec()))
    }

    /// Its radius, m, where it is found to be wider than the map's tip.
    #[getter]
    fn radius_m(&self) -> Option<f64> {
        self.contact.radius.map(|radius| radius.radius_m)
    }

    /// Its name, never given twice, where contacts are followed.
    #[getter]
    fn id(&self) -> Option<u64> {
        self.contact.id
    }

    /// 'born', 'held' or 'sliding', where contacts are followed.
    #[getter]
    fn phase(&self) -> Option<&'static str> {
        self.contact.phase.map(Phase::word)
    }

    /// Standard deviation of its position, m, where that is known.
    #[getter]
    fn position_sd_m(&self) -> Option<f64> {
        Some(self.contact.uncertainty?.position_sd_m())
    }

    /// Standard deviation of its force, N, where that is known.
    #[getter]
    fn force_sd_n(&self) -> Option<f64> {
        Some(self.contact.uncertainty?.force_sd_n())
    }

    /// Covariance of its position in space, m², `[3, 3]`, where that is known.
    #[getter]
    fn covariance_m2(&self, py: Python<'_>) -> PyResult<Option<Py<PyArray2<f64>>>> {
        let uncertainty = self.contact.uncertainty;
        let matrix =
            |u: Uncertainty| two(py, u.position_covariance_m2().as_slice().to_vec(), [3, 3]);
        uncertainty.map(matrix).transpose()
    }

    fn __repr__(&self) -> String {
        let [x, y, z] = (self.contact.position_m.coords * 1e3).into();
        format!("Contact({:.2} N at ({x:.2}, {y:.2}, {z:.2}) mm)", self.contact.force_n)
    }
}

#[pymethods]
impl PyEstimates {
    /// Number of frames.
    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        self.count.bind(py).len()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let n_contacts = self.frame.bind(py).len()?;
        Ok(format!("Estimates({} frames, {n_contacts} contacts)", self.__len__(py)?))
    }
}

impl PyContact {
    /// Wraps a contact.
    pub(crate) fn new(contact: Contact) -> Self {
        Self { contact }
    }
}

impl PyEstimates {
    /// Puts the frames into arrays.
    pub(crate) fn new(py: Python<'_>, frames: &[Touch]) -> PyResult<Self> {
        let counts = frames.iter().map(|touch| touch.contacts.len());
        let frame = counts.clone().enumerate();
        let frame = frame.flat_map(|(i, n)| std::iter::repeat_n(i as i64, n)).collect();
        let contacts = || frames.iter().flat_map(|touch| &touch.contacts);
        let positions = contacts().flat_map(|c| <[f64; 3]>::from(c.position_m.coords));
        let positions: Vec<f64> = positions.collect();
        let shape = [positions.len() / 3, 3];
        let of = |value: fn(&Contact) -> f64| one(py, contacts().map(value).collect());
        let quality = |value: fn(&Quality) -> f64| {
            let values = frames.iter().map(|t| t.quality.as_ref().map_or(f64::NAN, value));
            one(py, values.collect())
        };
        let identified = frames.iter().map(|t| t.quality.is_none_or(|q| q.is_identified()));
        Ok(Self {
            frame: one(py, frame),
            position_m: two(py, positions, shape)?,
            force_n: of(|c| c.force_n),
            position_sd_m: of(|c| c.uncertainty.map_or(f64::NAN, |u| u.position_sd_m())),
            force_sd_n: of(|c| c.uncertainty.map_or(f64::NAN, |u| u.force_sd_n())),
            count: one(py, counts.map(|n| n as i64).collect()),
            is_identified: one(py, identified.collect()),
            chi2: quality(|q| q.chi2),
            p_value: quality(|q| q.p_value),
        })
    }
}
