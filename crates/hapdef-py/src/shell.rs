//! A limb of which there is only a surface, as a shell.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use hapdef::scene::MaterialSpec;
use hapdef::shell_limb::{ShellLimb, ShellLimbParams, WallChoice};
use hapdef_mesh::LengthUnit;
use numpy::PyArray2;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::array::{positions, two, vectors};
use crate::error::to_python;
use crate::response::PyResponse;
use crate::work::interruptible;

/// A shell with gauges on the inner side of its wall.
#[pyclass(frozen, module = "hapdef", name = "Shell")]
pub struct PyShell {
    limb: ShellLimb,
}

#[pymethods]
impl PyShell {
    /// Reads a glTF surface and solves its shell: the surface is the outside of the wall.
    #[new]
    #[pyo3(signature = (path, *, wall_m, unit = "m", n_gauges = 10, edge_m = None, youngs_modulus_pa = 1.7e9, poissons_ratio = 0.394, threads = 1))]
    #[expect(clippy::too_many_arguments, reason = "named in Python")]
    fn new(
        py: Python<'_>,
        path: PathBuf,
        wall_m: f64,
        unit: &str,
        n_gauges: usize,
        edge_m: Option<f64>,
        youngs_modulus_pa: f64,
        poissons_ratio: f64,
        threads: usize,
    ) -> PyResult<Self> {
        if !(wall_m > 0.0 && wall_m.is_finite()) {
            return Err(PyValueError::new_err(format!(
                "wall_m: expected a thickness above 0 in metres, found {wall_m}"
            )));
        }
        let (unit, threads) = (unit_of(unit)?, threads.max(1));
        let material = MaterialSpec { youngs_modulus_pa, poissons_ratio, ..MaterialSpec::PA2200 };
        let params = ShellLimbParams {
            n_gauges,
            edge_m,
            material,
            n_threads: threads,
            ..ShellLimbParams::new(WallChoice::Constant(wall_m))
        };
        let stop = Arc::new(AtomicBool::new(false));
        let read = move || ShellLimb::read(&path, unit, &params);
        Ok(Self { limb: interruptible(py, threads, &stop, read)? })
    }

    /// Nodes of the skin, m, `[n_nodes, 3]`: corners of its triangles and middles of their sides.
    #[getter]
    fn nodes_m(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        positions(py, &self.limb.limb.surface_points())
    }

    /// Its triangles `[n_triangles, 3]`, four to each face of the skin.
    #[getter]
    fn triangles(&self, py: Python<'_>) -> PyResult<Py<PyArray2<u32>>> {
        let limb = &self.limb.limb;
        let surface = limb.skin.surface(&limb.mesh).map_err(|error| to_python(error.into()))?;
        let n = surface.triangles().len();
        two(py, surface.triangles().as_flattened().to_vec(), [n, 3])
    }

    /// Outward unit normals `[n_nodes, 3]`.
    #[getter]
    fn normals(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        vectors(py, &self.limb.limb.skin.normals)
    }

    /// Centres of the gauges on the inner side of the wall, m, `[n_gauges, 3]`.
    #[getter]
    fn gauge_positions_m(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        let sites = self.limb.limb.sites.iter();
        positions(py, &sites.map(|site| site.position).collect::<Vec<_>>())
    }

    /// Half of the free nodes have a gauge that reads at least this for a newton, µε/N.
    #[getter]
    fn median_best_ue_per_n(&self) -> f64 {
        self.limb.info.median_best_ue_per_n
    }

    /// What every gauge reads for a newton anywhere on the skin.
    fn response(&self) -> PyResult<PyResponse> {
        Ok(PyResponse::new(self.limb.response().map_err(to_python)?))
    }

    fn __repr__(&self) -> String {
        let limb = &self.limb.limb;
        format!("Shell({} nodes, {} gauges)", limb.n_surface_nodes(), limb.sites.len())
    }
}

fn unit_of(name: &str) -> PyResult<LengthUnit> {
    match name {
        "m" => Ok(LengthUnit::Metre),
        "mm" => Ok(LengthUnit::Millimetre),
        "cm" => Ok(LengthUnit::Centimetre),
        "in" => Ok(LengthUnit::Inch),
        _ => Err(PyValueError::new_err(format!(
            "unit: expected 'm', 'mm', 'cm' or 'in', found {name:?}"
        ))),
    }
}
