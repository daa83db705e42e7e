//! Parts of a limb made stiffer, as derivatives of its response.

use hapdef_mesh::{FeNodeId, GaugeId, farthest_nodes};
use hapdef_sim::{GaugeResponse, LinearFunctional, NodalLoad, ShellKind, SimError};
use hapdef_sim::{shell_stiffness, stiffness};
use nalgebra::{Point3, Vector3};

use super::model::{LimbModel, ModelGauge};
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::wall_shell::WallShell;

/// Width of a stiffness mode, m.
const MODE_WIDTH_M: f64 = 0.025;

/// Elements whose stiffness changes by less than this share don't count.
const LEAST_WEIGHT: f64 = 1e-4;

/// ∂/∂s of the adjoint fields K⁻¹ c for stiffness 1 + s b(x): −K⁻¹ K_b K⁻¹ c, one solve for each of
/// `n_modes` bumps b and gauge; each `[n_surface, n_gauges]`, µε/N.
pub(super) fn stiffness_modes(
    model: &LimbModel<'_>,
    gauges: &[ModelGauge],
    n_modes: usize,
) -> Result<Vec<Vec<Vector3<f64>>>, HapdefError> {
    if n_modes == 0 {
        return Ok(Vec::new());
    }
    let limb = model.limb;
    let there: Vec<&LinearFunctional> = gauges.iter().flatten().collect();
    let (response, _) = model.model.response(&there)?;
    let forces = ElementForces::of(model, &response)?;
    let centres = farthest_nodes(&limb.mesh, &limb.skin.nodes, n_modes);
    let loads: Vec<NodalLoad> = centres
        .iter()
        .flat_map(|centre| {
            let weights = forces.bump(&limb.mesh.position(*centre));
            (0..there.len()).map(move |gauge| (gauge, weights.clone()))
        })
        .map(|(gauge, weights)| forces.weighted(gauge, &weights))
        .collect();
    let (solved, _) = model.displacements(&loads, &limb.skin.nodes)?;
    let mode = |k: usize| {
        let mut rows = Vec::with_capacity(limb.skin.nodes.len() * gauges.len());
        for node in 0..limb.skin.nodes.len() {
            let mut load = k * there.len()..(k + 1) * there.len();
            rows.extend(gauges.iter().map(|gauge| {
                let load = gauge.as_ref().and_then(|_| load.next());
                load.map_or_else(Vector3::zeros, |load| solved.displacement(load, node) * 1e6)
            }));
        }
        rows
    };
    Ok((0..centres.len()).map(mode).collect())
}

/// K_e λ of every element of a model, for each gauge's adjoint field λ.
struct ElementForces {
    /// `[n_elements][n_nodes of one]`.
    nodes: Vec<Vec<FeNodeId>>,
    /// Means of the corners `[n_elements]`, m.
    centres: Vec<Point3<f64>>,
    n_nodes: usize,
    /// `[n_gauges][n_elements × n_nodes of one]`; moments of shells alone.
    forces: Vec<Vec<Vector3<f64>>>,
    moments: Vec<Vec<Vector3<f64>>>,
}

impl ElementForces {
    fn of(model: &LimbModel<'_>, response: &GaugeResponse) -> Result<Self, HapdefError> {
        match model.shell {
            Some(shell) => Self::of_shell(model.limb, shell, response),
            None => Self::of_solid(model.limb, response),
        }
    }

    fn of_solid(limb: &Limb, response: &GaugeResponse) -> Result<Self, HapdefError> {
        let mesh = &limb.mesh;
        let mut forces = vec![Vec::new(); response.n_gauges()];
        for (e, element) in mesh.elements().iter().enumerate() {
            let nodes = element.map(|node| mesh.position(node));
            let k = stiffness(&nodes, &limb.material).map_err(|at| SimError::ElementInverted {
                element: e,
                parent: at.parent,
                det_j_m3: at.det_j_m3,
            })?;
            for (gauge, forces) in forces.iter_mut().enumerate() {
                let field = response.field(GaugeId::from_index(gauge));
                let lambda = element.map(|node| field[node.index()]);
                let row = |i: usize| (0..30).map(|j| k[i][j] * lambda[j / 3][j % 3]).sum::<f64>();
                forces.extend((0..10).map(|i| Vector3::from_fn(|c, _| row(3 * i + c))));
            }
        }
        Ok(Self {
            nodes: mesh.elements().iter().map(|element| element.to_vec()).collect(),
            centres: mesh
                .elements()
                .iter()
                .map(|element| mean(element[..4].iter().map(|node| mesh.position(*node))))
                .collect(),
            n_nodes: mesh.nodes().len(),
            forces,
            moments: Vec::new(),
        })
    }

    fn of_shell(
        limb: &Limb,
        shell: &WallShell,
        response: &GaugeResponse,
    ) -> Result<Self, HapdefError> {
        let mesh = &shell.mesh;
        let mut forces = vec![Vec::new(); response.n_gauges()];
        let mut moments = forces.clone();
        for (element, nodes) in mesh.triangles().iter().enumerate() {
            let (corners, thickness_m) = (mesh.corners(element), mesh.corner_thickness_m(element));
            let directors = Some(&mesh.directors()[element]);
            let kind = ShellKind::default();
            let k = shell_stiffness(kind, &corners, directors, &thickness_m, &limb.material)
                .map_err(|problem| SimError::ShellElement { element, problem })?;
            for gauge in 0..response.n_gauges() {
                let id = GaugeId::from_index(gauge);
                let (moved, turned) = (response.field(id), response.moment_field(id));
                let lambda = nodes.map(|node| [moved[node.index()], turned[node.index()]]);
                let row = |i: usize| -> f64 {
                    (0..18).map(|j| k[i][j] * lambda[j / 6][j % 6 / 3][j % 3]).sum()
                };
                let part = |first: usize| Vector3::from_fn(|c, _| row(first + c));
                forces[gauge].extend((0..3).map(|i| part(6 * i)));
                moments[gauge].extend((0..3).map(|i| part(6 * i + 3)));
            }
        }
        let n = mesh.triangles().len();
        Ok(Self {
            nodes: mesh.triangles().iter().map(|nodes| nodes.to_vec()).collect(),
            centres: (0..n).map(|element| mean(mesh.corners(element).into_iter())).collect(),
            n_nodes: mesh.nodes().len(),
            forces,
            moments,
        })
    }

    /// A Gaussian of the elements' distance from `centre` `[n_elements]`.
    fn bump(&self, centre: &Point3<f64>) -> Vec<f64> {
        let weight =
            |x: &Point3<f64>| (-0.5 * (x - centre).norm_squared() / MODE_WIDTH_M.powi(2)).exp();
        self.centres.iter().map(weight).collect()
    }

    /// −Σ w K_e λ of a gauge as a load.
    fn weighted(&self, gauge: usize, weights: &[f64]) -> NodalLoad {
        let moments = self.moments.get(gauge).map(|moments| self.summed(moments, weights));
        NodalLoad {
            forces_n: self.summed(&self.forces[gauge], weights),
            moments_nm: moments.unwrap_or_default(),
        }
    }

    fn summed(&self, parts: &[Vector3<f64>], weights: &[f64]) -> Vec<(FeNodeId, Vector3<f64>)> {
        let mut sums = vec![Vector3::zeros(); self.n_nodes];
        let mut first = 0;
        for (nodes, weight) in self.nodes.iter().zip(weights) {
            if *weight >= LEAST_WEIGHT {
                for (node, part) in nodes.iter().zip(&parts[first..]) {
                    sums[node.index()] -= part * *weight;
                }
            }
            first += nodes.len();
        }
        let loaded = sums.into_iter().enumerate();
        let loaded = loaded.filter(|(_, sum)| sum.norm_squared() > 0.0);
        loaded.map(|(node, sum)| (FeNodeId::from_index(node), sum)).collect()
    }
}

fn mean(corners: impl ExactSizeIterator<Item = Point3<f64>>) -> Point3<f64> {
    let n = corners.len() as f64;
    Point3::from(corners.map(|x| x.coords).sum::<Vector3<f64>>() / n)
}
