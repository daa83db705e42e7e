//! A response map: what every gauge reads for a newton anywhere on the skin.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use hapdef::touch::{LimitsReport, LimitsRequest, limits};
use hapdef_inverse::{LimitParams, OtherLoads, ResponseMap};
use nalgebra::Point3;
use numpy::{PyArray1, PyArray2, PyArray3};
use pyo3::prelude::*;

use crate::array::{Numbers, Table, numbers, one, three, triples, two};
use crate::error::raised;
use crate::work::interruptible;

/// Draws of contacts for each count when it is asked how many a layout carries.
const N_DRAWS: usize = 200;

/// Gauge readings per newton, smooth over the skin.
#[pyclass(frozen, module = "hapdef", name = "Response")]
pub struct PyResponse {
    map: Arc<ResponseMap>,
}

/// Cramér–Rao bounds over the skin.
#[pyclass(frozen, module = "hapdef", name = "Bounds")]
pub struct PyBounds {
    report: LimitsReport,
}

#[pymethods]
impl PyResponse {
    /// Number of gauges.
    #[getter]
    fn n_gauges(&self) -> usize {
        self.map.n_gauges()
    }

    /// Readings for a newton along x, y and z at each surface node, µε/N,
    /// `[n_surface_nodes, n_gauges, 3]`.
    #[getter]
    fn nodal_ue_per_n(&self, py: Python<'_>) -> PyResult<Py<PyArray3<f64>>> {
        let nodal = self.map.nodal();
        let n_nodes = self.map.skin().n_nodes();
        let of_nodes = nodal.iter().take(n_nodes * self.map.n_gauges());
        let numbers = of_nodes.flat_map(|v| [v.x, v.y, v.z]).collect();
        three(py, numbers, [n_nodes, self.map.n_gauges(), 3])
    }

    /// Readings of single presses against the skin's normal, µε, `[n, n_gauges]`: row i for the
    /// force i at the point of the skin nearest to position i. Those of several contacts add up.
    fn readings_ue(
        &self,
        py: Python<'_>,
        positions_m: Table<'_>,
        forces_n: Numbers<'_>,
    ) -> PyResult<Py<PyArray2<f64>>> {
        let places = triples("positions_m", &positions_m)?;
        let forces_n = numbers("forces_n", &forces_n, places.len())?;
        let mut readings = Vec::with_capacity(places.len() * self.map.n_gauges());
        for (place, force_n) in places.iter().zip(&forces_n) {
            let (point, _) = self.map.skin().nearest(&Point3::from(*place)).map_err(raised)?;
            readings.extend(self.map.normal(&point).iter().map(|unit| unit * force_n));
        }
        two(py, readings, [places.len(), self.map.n_gauges()])
    }

    /// Cramér–Rao bounds at every surface node, which no unbiased estimate beats.
    #[pyo3(signature = (*, noise_ue = 1.0, force_n = 10.0, n_sites = 400, n_partners = 1, threads = 1))]
    fn bounds(
        &self,
        py: Python<'_>,
        noise_ue: f64,
        force_n: f64,
        n_sites: usize,
        n_partners: usize,
        threads: usize,
    ) -> PyResult<PyBounds> {
        let request = LimitsRequest {
            noise_ue,
            n_sites,
            n_partners,
            carried: LimitParams { force_n, n_draws: N_DRAWS, ..LimitParams::default() },
        };
        let map = ResponseMap::clone(&self.map);
        let stop = Arc::new(AtomicBool::new(false));
        let report = interruptible(py, threads.max(1), &stop, move || {
            limits(map, OtherLoads::default(), &request)
        })?;
        Ok(PyBounds { report })
    }
}

impl PyResponse {
    /// Wraps a map.
    pub(crate) fn new(map: ResponseMap) -> Self {
        Self { map: Arc::new(map) }
    }
}

#[pymethods]
impl PyBounds {
    /// Bound of one contact's position at each surface node, m, `[n_surface_nodes]`; infinite where
    /// the readings don't determine it.
    #[getter]
    fn single_m(&self, py: Python<'_>) -> Py<PyArray1<f64>> {
        one(py, self.report.single_m.clone())
    }

    /// Bound of its force there, N.
    #[getter]
    fn single_n(&self, py: Python<'_>) -> Py<PyArray1<f64>> {
        one(py, self.report.single_n.clone())
    }

    /// Median bound of its position while a second contact of the same force is somewhere else, m.
    #[getter]
    fn pair_m(&self, py: Python<'_>) -> Py<PyArray1<f64>> {
        one(py, self.report.pair_m.clone())
    }

    /// Surface nodes at which no contact can be detected.
    #[getter]
    fn blind_nodes(&self, py: Python<'_>) -> Py<PyArray1<u64>> {
        let nodes = self.report.blind_nodes.iter();
        one(py, nodes.map(|node| *node as u64).collect())
    }

    /// The most contacts at a time that the layout carries.
    #[getter]
    fn n_carried(&self) -> usize {
        let carried = self.report.carried.iter().filter(|row| row.is_carried);
        carried.map(|row| row.n_contacts).max().unwrap_or(0)
    }
}
