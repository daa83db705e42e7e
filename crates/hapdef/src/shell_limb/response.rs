//! The shell model of a limb and what its gauges read.

use hapdef_mesh::{FeNodeId, GaugeId, SkinSide, SurfaceMesh};
use hapdef_sim::{
    ElasticModel, GaugeResponse, GaugeSite, ShellGaugeStrain, ShellMesh, ShellMeshParams,
    ShellParams, SolveInfo,
};
use nalgebra::Vector3;

use super::ShellLimbParams;
use super::info::{GaugeInfo, ModelInfo, ShellLimbInfo, quartiles};
use super::mount::clamped;
use super::sites::place_gauges;
use super::stopwatch::Stopwatch;
use super::wall::Wall;
use crate::error::HapdefError;

/// A limb as a shell, with gauges on the inner side of its wall.
#[derive(Debug)]
pub struct ShellLimb {
    /// What was asked.
    pub params: ShellLimbParams,
    /// The remeshed skin, m; vertex `i` is node `i` of [`Self::mesh`].
    pub skin: SurfaceMesh,
    /// Where the skin lies in the wall.
    pub side: SkinSide,
    /// The middle of the wall.
    pub mesh: ShellMesh,
    /// Outward unit normals `[n_nodes]`.
    pub normals: Vec<Vector3<f64>>,
    /// Nodes held fast.
    pub clamped: Vec<FeNodeId>,
    /// The factored model.
    pub elastic_model: ElasticModel,
    /// Where the gauges are glued, in channel order.
    pub sites: Vec<GaugeSite>,
    /// The gauges.
    pub gauges: Vec<ShellGaugeStrain>,
    /// What they read for a force at any node.
    pub response: GaugeResponse,
    /// What was found and made.
    pub info: ShellLimbInfo,
}

/// The shell model of the limb whose surface is `given`, m, and the readings of its gauges.
///
/// # Errors
/// [`HapdefError::Mesh`] for a surface that is no shell, with the cause and the volume;
/// [`HapdefError::WallFolds`]; [`HapdefError::TooFewGaugeSites`]; [`HapdefError::Sim`].
pub fn shell_limb(given: &SurfaceMesh, params: &ShellLimbParams) -> Result<ShellLimb, HapdefError> {
    let mut watch = Stopwatch::new();
    let wall = Wall::new(given, params, &mut watch)?;
    let (clamped, mount) = clamped(&wall.skin, &params.mount)?;
    let mesh = shell_mesh(&wall)?;
    let normals = wall.shell.directors().to_vec();
    let long_axis = Vector3::ith(wall.skin.bounding_box().size_m().imax(), 1.0);
    let placed = place_gauges(&mesh, &normals, &clamped, &long_axis, params)?;
    watch.lap("gauges");
    let shell_params = ShellParams {
        kind: params.kind,
        n_threads: params.n_threads,
        ..ShellParams::new(params.material, clamped.clone())
    };
    let elastic_model = ElasticModel::build_shell(&mesh, &shell_params)?;
    watch.lap("factor");
    let (response, solve) = elastic_model.response(&placed.gauges)?;
    watch.lap("gauge response");
    let info = ShellLimbInfo {
        wall: wall.info,
        mount,
        model: model_info(&mesh, &elastic_model, &solve),
        gauges: Vec::new(),
        n_sites_passed_over: placed.n_passed_over,
        median_best_ue_per_n: 0.0,
        stages: watch.stages,
    };
    let mut limb = ShellLimb {
        params: params.clone(),
        skin: wall.skin,
        side: wall.side,
        mesh,
        normals,
        clamped,
        elastic_model,
        sites: placed.sites,
        gauges: placed.gauges,
        response,
        info,
    };
    limb.tell_readings();
    Ok(limb)
}

impl ShellLimb {
    /// What every gauge reads for a newton inward on every node `[n_nodes, n_gauges]`, µε/N.
    #[must_use]
    pub fn readings_ue_per_n(&self) -> Vec<f64> {
        let nodes = 0..self.normals.len();
        nodes
            .flat_map(|node| (0..self.gauges.len()).map(move |gauge| self.reading(gauge, node)))
            .collect()
    }

    /// The strongest reading of any gauge for a newton on each node, magnitude `[n_nodes]`, µε/N.
    #[must_use]
    pub fn best_ue_per_n(&self) -> Vec<f64> {
        let readings = self.readings_ue_per_n();
        let of_node = |row: &[f64]| row.iter().fold(0.0_f64, |best, r| best.max(r.abs()));
        readings.chunks(self.gauges.len()).map(of_node).collect()
    }

    fn reading(&self, gauge: usize, node: usize) -> f64 {
        let field = self.response.field(GaugeId::from_index(gauge));
        -field[node].dot(&self.normals[node]) * 1e6
    }

    fn tell_readings(&mut self) {
        self.info.gauges = (0..self.gauges.len()).map(|g| self.gauge_info(g)).collect();
        let mut is_free = vec![true; self.normals.len()];
        for node in &self.clamped {
            is_free[node.index()] = false;
        }
        let best = self.best_ue_per_n().into_iter().zip(is_free);
        let free = best.filter_map(|(best, is_free)| is_free.then_some(best));
        self.info.median_best_ue_per_n = quartiles(free)[2];
    }

    fn gauge_info(&self, gauge: usize) -> GaugeInfo {
        let reading = |node| self.reading(gauge, node);
        let stronger = |a: usize, b: usize| {
            if reading(b).abs() > reading(a).abs() { b } else { a }
        };
        let strongest = (0..self.normals.len()).fold(0, stronger);
        GaugeInfo {
            position_m: self.sites[gauge].position.coords.into(),
            axis: self.gauges[gauge].axis().into(),
            lost_share: self.gauges[gauge].lost_share(),
            strongest_node: strongest,
            strongest_position_m: self.mesh.nodes()[strongest].coords.into(),
            strongest_ue_per_n: reading(strongest),
        }
    }
}

fn shell_mesh(wall: &Wall) -> Result<ShellMesh, HapdefError> {
    let triangles = wall.shell.triangles().iter();
    let triangles = triangles.map(|t| t.map(|v| FeNodeId::from_index(v as usize)));
    Ok(ShellMesh::with_params(
        wall.shell.nodes().to_vec(),
        triangles.collect(),
        wall.shell.thickness_m().to_vec(),
        &ShellMeshParams::default(),
    )?)
}

fn model_info(mesh: &ShellMesh, model: &ElasticModel, solve: &SolveInfo) -> ModelInfo {
    ModelInfo {
        n_nodes: mesh.nodes().len(),
        n_triangles: mesh.triangles().len(),
        n_equations: model.info().n_equations,
        nnz_l: model.info().nnz_l,
        worst_relative_residual: solve.worst_relative_residual,
        worst_backward_error: solve.worst_backward_error,
    }
}
