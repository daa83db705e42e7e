//! The simulated hardware: a perturbed limb behind gauge electronics.

use std::sync::Arc;

use hapdef::scene::Scene;
use hapdef_rig::live::LiveLimb;
use hapdef_rig::{Electronics, ElectronicsParams};
use nalgebra::Point3;
use numpy::{PyArray2, PyArray3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::array::{Numbers, Table, numbers, three, triples, two};
use crate::error::raised;

/// The limb that stands in for hardware: another mesh, other stiffness, gauges off their place. What
/// it says is simulated.
#[pyclass(frozen, module = "hapdef", name = "Rig")]
pub struct PyRig {
    limb: Arc<LiveLimb>,
    electronics: ElectronicsParams,
    /// The strongest press of the scene, N.
    most_n: f64,
}

#[pymethods]
impl PyRig {
    /// Number of gauges.
    #[getter]
    fn n_gauges(&self) -> usize {
        self.limb.n_gauges()
    }

    /// Readings for a newton along x, y and z at each surface node, µε/N,
    /// `[n_surface_nodes, n_gauges, 3]`.
    #[getter]
    fn nodal_ue_per_n(&self, py: Python<'_>) -> PyResult<Py<PyArray3<f64>>> {
        let columns = self.limb.columns_ue_per_n();
        let n_nodes = self.limb.surface().nodes.len();
        let numbers = columns.iter().flat_map(|v| [v.x, v.y, v.z]).collect();
        three(py, numbers, [n_nodes, self.limb.n_gauges(), 3])
    }

    /// Presses the limb: row i are the tared readings, µε, for force i along the skin's normal at the
    /// point nearest to position i; `[n, n_gauges]`. Strains themselves without a `seed`, else what
    /// the scene's electronics make of them. Strains of several contacts add up.
    #[pyo3(signature = (positions_m, forces_n, *, seed = None))]
    fn press(
        &self,
        py: Python<'_>,
        positions_m: Table<'_>,
        forces_n: Numbers<'_>,
        seed: Option<u64>,
    ) -> PyResult<Py<PyArray2<f64>>> {
        let places = triples("positions_m", &positions_m)?;
        let forces_n = numbers("forces_n", &forces_n, places.len())?;
        let n_gauges = self.limb.n_gauges();
        let mut readings = vec![0.0; places.len() * n_gauges];
        let frames = readings.chunks_exact_mut(n_gauges);
        for (frame, (place, force_n)) in frames.zip(places.iter().zip(&forces_n)) {
            let (point, _) = self.limb.nearest(&Point3::from(*place)).ok_or_else(|| {
                PyValueError::new_err("positions_m: expected places near the skin")
            })?;
            let force = self.limb.inward(&point) * *force_n;
            self.limb.add_strain_ue(&point, &force, frame);
        }
        if let Some(seed) = seed {
            self.measure(&mut readings, seed)?;
        }
        two(py, readings, [places.len(), n_gauges])
    }
}

impl PyRig {
    /// The scene's electronics behind a limb.
    pub(crate) fn new(limb: Arc<LiveLimb>, scene: &Scene) -> Self {
        Self {
            limb,
            electronics: scene.rig.electronics.params(),
            most_n: scene.contact.force_range_n[1],
        }
    }

    fn measure(&self, readings: &mut [f64], seed: u64) -> PyResult<()> {
        let params = ElectronicsParams {
            seed: self.electronics.seed.wrapping_add(seed),
            ..self.electronics
        };
        let largest = self.limb.largest_ue(self.most_n);
        let mut electronics = Electronics::new(params, &largest).map_err(raised)?;
        for frame in readings.chunks_exact_mut(self.limb.n_gauges()) {
            electronics.measure(frame);
        }
        Ok(())
    }
}
