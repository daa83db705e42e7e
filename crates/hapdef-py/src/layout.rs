//! A layout of gauges and what it can tell.

use hapdef::touch::ScoredLayout;
use nalgebra::{Point3, Vector3};
use numpy::PyArray2;
use pyo3::prelude::*;

use crate::array::{positions, vectors};

/// Gauges that a method chose, with their Cramér–Rao bounds.
#[pyclass(frozen, module = "hapdef", name = "Layout")]
pub struct PyLayout {
    layout: ScoredLayout,
}

#[pymethods]
impl PyLayout {
    /// The method.
    #[getter]
    fn name(&self) -> &str {
        &self.layout.name
    }

    /// Centres on the wall, m, `[n_gauges, 3]`; empty for the median of random layouts.
    #[getter]
    fn positions_m(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        let gauges = self.layout.gauges.iter();
        let list: Vec<Point3<f64>> = gauges.map(|gauge| gauge.position_m).collect();
        positions(py, &list)
    }

    /// Measuring directions, unit length, `[n_gauges, 3]`.
    #[getter]
    fn axes(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        let gauges = self.layout.gauges.iter();
        let list: Vec<Vector3<f64>> = gauges.map(|gauge| gauge.axis).collect();
        vectors(py, &list)
    }

    /// Mean over the skin of the bound on one contact's position, m.
    #[getter]
    fn single_mean_m(&self) -> f64 {
        self.layout.score.single_mean_m
    }

    /// Its 95th percentile, m.
    #[getter]
    fn single_p95_m(&self) -> f64 {
        self.layout.score.single_p95_m
    }

    /// Median over drawn pairs of the bound on one of two contacts' position, m.
    #[getter]
    fn pair_median_m(&self) -> f64 {
        self.layout.score.pair_median_m
    }

    /// Its 95th percentile, m.
    #[getter]
    fn pair_p95_m(&self) -> f64 {
        self.layout.score.pair_p95_m
    }

    fn __repr__(&self) -> String {
        format!(
            "Layout({:?}, {} gauges, one contact {:.2} mm, two {:.2} mm)",
            self.layout.name,
            self.layout.gauges.len(),
            self.single_mean_m() * 1e3,
            self.pair_median_m() * 1e3
        )
    }
}

impl PyLayout {
    /// Wraps a layout.
    pub(crate) fn new(layout: ScoredLayout) -> Self {
        Self { layout }
    }
}
