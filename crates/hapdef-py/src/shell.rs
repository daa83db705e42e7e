//! A limb of which there is only a surface, as a shell.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use hapdef::shell_limb::{ShellLimb, ShellLimbParams, WallChoice, shell_limb};
use hapdef_inverse::{ResponseMap, ResponseParams, Skin, SkinFaces, SkinParams};
use hapdef_mesh::{GaugeId, GltfParams, LengthUnit, read_gltf};
use hapdef_sim::IsotropicMaterial;
use nalgebra::Vector3;
use numpy::PyArray2;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::array::{positions, two, vectors};
use crate::error::{Fault, to_python};
use crate::response::PyResponse;
use crate::work::interruptible;

/// Density of PA2200, kg/m³; statics don't depend on it.
const DENSITY_KG_M3: f64 = 930.0;

/// A shell with gauges on the inner side of its wall.
#[pyclass(frozen, module = "hapdef", name = "Shell")]
pub struct PyShell {
    limb: ShellLimb,
}

/// What a shell is made of.
struct ShellRequest {
    path: PathBuf,
    unit: LengthUnit,
    params: ShellLimbParams,
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
        let material = IsotropicMaterial::new(youngs_modulus_pa, poissons_ratio, DENSITY_KG_M3)
            .map_err(|error| to_python(error.into()))?;
        if !(wall_m > 0.0 && wall_m.is_finite()) {
            return Err(PyValueError::new_err(format!(
                "wall_m: expected a thickness above 0 in metres, found {wall_m}"
            )));
        }
        let request = ShellRequest {
            path,
            unit: unit_of(unit)?,
            params: ShellLimbParams {
                n_gauges,
                edge_m,
                n_threads: threads.max(1),
                ..ShellLimbParams::new(WallChoice::Constant(wall_m), material)
            },
        };
        let stop = Arc::new(AtomicBool::new(false));
        let limb = interruptible(py, threads.max(1), &stop, move || request.solve())?;
        Ok(Self { limb })
    }

    /// Nodes of the remeshed skin, m, `[n_nodes, 3]`.
    #[getter]
    fn nodes_m(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        positions(py, self.limb.skin.vertices())
    }

    /// Its triangles `[n_triangles, 3]`.
    #[getter]
    fn triangles(&self, py: Python<'_>) -> PyResult<Py<PyArray2<u32>>> {
        let triangles = self.limb.skin.triangles().to_vec();
        let n = triangles.len();
        two(py, triangles.into_flattened(), [n, 3])
    }

    /// Outward unit normals `[n_nodes, 3]`.
    #[getter]
    fn normals(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        vectors(py, &self.limb.normals)
    }

    /// Centres of the gauges on the inner side of the wall, m, `[n_gauges, 3]`.
    #[getter]
    fn gauge_positions_m(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        let sites = self.limb.sites.iter();
        positions(py, &sites.map(|site| site.position).collect::<Vec<_>>())
    }

    /// Half of the free nodes have a gauge that reads at least this for a newton, µε/N.
    #[getter]
    fn median_best_ue_per_n(&self) -> f64 {
        self.limb.info.median_best_ue_per_n
    }

    /// What every gauge reads for a newton anywhere on the skin.
    fn response(&self) -> PyResult<PyResponse> {
        let map = response_of(&self.limb).map_err(to_python)?;
        Ok(PyResponse::new(map))
    }

    fn __repr__(&self) -> String {
        format!(
            "Shell({} nodes, {} gauges)",
            self.limb.skin.vertices().len(),
            self.limb.gauges.len()
        )
    }
}

impl ShellRequest {
    fn solve(&self) -> Result<ShellLimb, Fault> {
        let params = GltfParams { unit: self.unit, ..GltfParams::default() };
        let surface = read_gltf(&self.path, &params)?;
        shell_limb(&surface.mesh, &self.params)
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

/// The gauges' adjoint fields on the skin, µε/N.
fn response_of(limb: &ShellLimb) -> Result<ResponseMap, Fault> {
    let n_gauges = limb.gauges.len();
    let nodes = limb.skin.vertices();
    let field = |gauge| limb.response.field(GaugeId::from_index(gauge));
    let at = |node: usize| (0..n_gauges).map(move |gauge| field(gauge)[node] * 1e6);
    let adjoint: Vec<Vector3<f64>> = (0..nodes.len()).flat_map(at).collect();
    let skin = Skin::new(
        nodes.to_vec(),
        SkinFaces::Linear(limb.skin.triangles()),
        Some(&limb.normals),
        &SkinParams::default(),
    )?;
    let params = ResponseParams::default();
    Ok(ResponseMap::from_nodal(skin, n_gauges, &adjoint, &params)?)
}
