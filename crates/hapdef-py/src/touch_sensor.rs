//! A simulated skin for simulators of robots.

use std::sync::{Mutex, PoisonError};

use hapdef::{TouchSensor, TouchSensorParams};
use hapdef_rig::live::LimbLoads;
use nalgebra::{Point3, Vector3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::array::{Numbers, Table, numbers, triples};
use crate::error::to_python;
use crate::live_frame::PyLiveFrame;
use crate::scene::PyScene;
use crate::work::work;

/// What presses and loads the limb goes in step by step; gauge readings and contacts come out.
#[pyclass(frozen, module = "hapdef", name = "TouchSensor")]
pub struct PyTouchSensor {
    sensor: Mutex<TouchSensor>,
}

#[pymethods]
impl PyTouchSensor {
    /// The simulated rig of a scene, with the live estimator behind it.
    #[new]
    #[pyo3(signature = (scene, *, rate_hz = 1000.0, tare_s = 1.0))]
    fn new(py: Python<'_>, scene: &PyScene, rate_hz: f64, tare_s: f64) -> PyResult<Self> {
        let params = TouchSensorParams { rate_hz, tare_s };
        let sensor = work(py, scene.open(), move |scene| TouchSensor::new(scene, &params))?;
        Ok(Self { sensor: Mutex::new(sensor) })
    }

    /// The next frame. Row i of `forces_n` `[n, 3]` is a force on the limb, N, at the point of its surface that is
    /// nearest to row i of `positions_m`, m; what pulls is left out. The rest loads the limb as a whole, as far as the
    /// scene's `loads` have it. All is in the limb's frame.
    #[pyo3(signature = (positions_m = None, forces_n = None, *, specific_force_m_s2 = None,
        angular_rate_rad_s = None, angular_acceleration_rad_s2 = None, flange_force_n = None,
        flange_moment_nm = None, warmer_k = 0.0))]
    #[expect(clippy::too_many_arguments, reason = "keywords of Python")]
    fn step(
        &self,
        py: Python<'_>,
        positions_m: Option<Table<'_>>,
        forces_n: Option<Table<'_>>,
        specific_force_m_s2: Option<Numbers<'_>>,
        angular_rate_rad_s: Option<Numbers<'_>>,
        angular_acceleration_rad_s2: Option<Numbers<'_>>,
        flange_force_n: Option<Numbers<'_>>,
        flange_moment_nm: Option<Numbers<'_>>,
        warmer_k: f64,
    ) -> PyResult<PyLiveFrame> {
        let rows = |name, table: Option<Table<'_>>| {
            table.map_or_else(|| Ok(Vec::new()), |table| triples(name, &table))
        };
        let places = rows("positions_m", positions_m)?;
        let forces_n = rows("forces_n", forces_n)?;
        if places.len() != forces_n.len() {
            let (n, m) = (places.len(), forces_n.len());
            let text = format!("forces_n: expected {n} rows, one for each position, found {m}");
            return Err(PyValueError::new_err(text));
        }
        let vector = |name, list: Option<Numbers<'_>>| -> PyResult<Vector3<f64>> {
            let list = list.map(|list| numbers(name, &list, 3)).transpose()?;
            Ok(list.map_or_else(Vector3::zeros, |list| Vector3::from_column_slice(&list)))
        };
        let loads = LimbLoads {
            specific_force_m_s2: vector("specific_force_m_s2", specific_force_m_s2)?,
            angular_rate_rad_s: vector("angular_rate_rad_s", angular_rate_rad_s)?,
            angular_acceleration_rad_s2: vector(
                "angular_acceleration_rad_s2",
                angular_acceleration_rad_s2,
            )?,
            flange_force_n: vector("flange_force_n", flange_force_n)?,
            flange_moment_nm: vector("flange_moment_nm", flange_moment_nm)?,
            warmer_k,
        };
        let pairs = places.into_iter().zip(forces_n);
        let forces: Vec<_> = pairs.map(|(x, f)| (Point3::from(x), Vector3::from(f))).collect();
        let step = || {
            let mut sensor = self.sensor.lock().unwrap_or_else(PoisonError::into_inner);
            sensor.step(&forces, loads)
        };
        Ok(PyLiveFrame::new(py.detach(step).map_err(to_python)?))
    }
}
