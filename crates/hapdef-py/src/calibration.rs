//! A response corrected by presses.

use std::path::PathBuf;
use std::sync::Arc;

use hapdef::OpenScene;
use hapdef::touch::{Calibration, PressQuality, Superposition, touchable_skin};
use hapdef_inverse::{CalibrationInfo, Press, Skin};
use nalgebra::Point3;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::array::{one, positions, two};
use crate::error::{Fault, to_python};
use crate::estimator::PyEstimator;
use crate::work::work;

/// Presses of known place and force.
pub(crate) struct PressTable {
    pub positions_m: Vec<[f64; 3]>,
    pub forces_n: Vec<f64>,
    /// Tared readings `[n, n_gauges]`, µε.
    pub readings_ue: Vec<f64>,
    pub quality: PressQuality,
    /// Farthest a press may lie from the skin, m.
    pub off_skin_m: f64,
    /// Sites at which the error is reported.
    pub n_sites: usize,
}

/// A corrected response and what it rests on.
#[pyclass(frozen, module = "hapdef", name = "Calibration")]
pub struct PyCalibration {
    scene: OpenScene,
    calibration: Arc<Calibration>,
    info: CalibrationInfo,
}

#[pymethods]
impl PyCalibration {
    /// Presses given.
    #[getter]
    fn n_presses(&self) -> usize {
        self.calibration.n_presses
    }

    /// Presses used; the others contradict these.
    #[getter]
    fn n_used(&self) -> usize {
        self.info.n_used
    }

    /// Rows of the presses that were left out.
    #[getter]
    fn rejected(&self, py: Python<'_>) -> Py<PyArray1<u64>> {
        let rejected = self.info.rejected.iter();
        one(py, rejected.map(|press| press.press as u64).collect())
    }

    /// Relative error of the map at presses not used for it, their noise included.
    #[getter]
    fn relative_error(&self) -> f64 {
        self.calibration.relative_error
    }

    /// The same before.
    #[getter]
    fn relative_error_before(&self) -> f64 {
        self.calibration.relative_error_before
    }

    /// Number of presses and relative error with so many, `[n, 2]`.
    #[getter]
    fn curve(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        let curve = &self.info.curve;
        let point = |p: &hapdef_inverse::CurvePoint| [p.n_presses as f64, p.relative_error];
        two(py, curve.iter().flat_map(point).collect(), [curve.len(), 2])
    }

    /// Places where the next presses help most, best first, m, `[n, 3]`.
    #[getter]
    fn next_positions_m(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        let next = self.info.next.iter();
        positions(py, &next.map(|press| press.position_m).collect::<Vec<_>>())
    }

    /// Writes the file that a scene names as `estimator.calibration`.
    fn write(&self, path: PathBuf) -> PyResult<()> {
        self.calibration.write(&path).map_err(to_python)
    }

    /// What finds contacts on the corrected map, frame by frame, with the scene's other settings.
    fn estimator(&self, py: Python<'_>) -> PyResult<PyEstimator> {
        let calibration = Arc::clone(&self.calibration);
        let estimator = work(py, &self.scene, move |open| {
            let scene = open.scene();
            calibration.estimator(scene, &scene.estimator.superposition(), open.limb())
        })?;
        Ok(PyEstimator::new(Box::new(Superposition::new(estimator))))
    }

    fn __repr__(&self) -> String {
        format!(
            "Calibration({} of {} presses, error {:.2} %, before {:.1} %)",
            self.info.n_used,
            self.calibration.n_presses,
            self.calibration.relative_error * 100.0,
            self.calibration.relative_error_before * 100.0
        )
    }
}

impl PyCalibration {
    /// Corrects the response of a scene's gauges by a table.
    pub(crate) fn fit(py: Python<'_>, scene: OpenScene, table: PressTable) -> PyResult<Self> {
        let (calibration, info) = work(py, &scene, move |scene| {
            let limb = scene.limb();
            let presses = table.presses(&touchable_skin(limb)?, limb.gauges.len())?;
            Calibration::fit(scene.run(), limb, &presses, &table.quality, table.n_sites)
        })?;
        Ok(Self { scene, calibration: Arc::new(calibration), info })
    }
}

impl PressTable {
    fn presses(&self, skin: &Skin, n_gauges: usize) -> Result<Vec<Press>, Fault> {
        let readings = self.readings_ue.chunks_exact(n_gauges);
        let rows = self.positions_m.iter().zip(&self.forces_n).zip(readings);
        let press = |((place, force_n), readings): ((&[f64; 3], &f64), &[f64])| {
            let (place, readings) = (Point3::from(*place), readings.to_vec());
            Press::at_position(skin, &place, self.off_skin_m, *force_n, readings)
        };
        Ok(rows.map(press).collect::<Result<_, _>>()?)
    }
}
