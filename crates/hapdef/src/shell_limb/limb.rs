//! The shell of a limb's wall and what its gauges read.

use std::path::Path;
use std::time::Instant;

use hapdef_bench::stats::{median, quantile, sorted};
use hapdef_inverse::{ResponseMap, ResponseParams};
use hapdef_mesh::{GltfParams, LengthUnit, read_surface};
use nalgebra::Vector3;
use serde::Serialize;

use super::spread::spread_gauges;
use super::{MountInfo, ShellLimbParams};
use crate::error::HapdefError;
use crate::limb::{Limb, place_gauges, site};
use crate::new_limb::{Skin, is_fold};
use crate::scene::{Scene, WallSide, default_name};
use crate::skin_solid::SkinSolid;
use crate::solid::Solid;
use crate::touch::{LimbModel, touchable_skin};
use crate::wall_shell::WallShell;

/// A limb as a shell, with gauges on the inner side of its wall.
pub struct ShellLimb {
    /// What was asked.
    pub params: ShellLimbParams,
    /// The surface file.
    pub file: String,
    /// Hash of its bytes (BLAKE3).
    pub file_hash: String,
    /// The scene that it is, of the skin in memory.
    pub scene: Scene,
    /// The skin with its wall, as shell and as solid.
    pub limb: Limb,
    /// What was found and made.
    pub info: ShellLimbInfo,
    /// The skin of the scene.
    pub(super) skin: Skin,
    /// The gauges' adjoint fields `[n_surface, n_gauges]`, µε/N.
    fields: Vec<Vector3<f64>>,
}

/// Everything that `hapdef shell` says about a limb.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ShellLimbInfo {
    /// From the surface to the wall.
    pub wall: WallInfo,
    /// Where the limb is held.
    pub mount: MountInfo,
    /// The equations and their solutions.
    pub model: ModelInfo,
    /// Gauges in channel order.
    pub gauges: Vec<GaugeInfo>,
    /// Sites that were passed over because a gauge's footprint doesn't lie on the wall there.
    pub n_sites_passed_over: usize,
    /// Half of the free nodes have a gauge that reads at least this for a newton, µε/N.
    pub median_best_ue_per_n: f64,
    /// Seconds.
    pub elapsed_s: f64,
}

/// The way from the surface to the wall.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WallInfo {
    /// How the skin was made, a sentence each.
    pub made: Vec<String>,
    /// Edges of the skin, m.
    pub target_edge_m: f64,
    /// Where the skin lies in the wall.
    pub side: WallSide,
    /// Smallest, quartile, median, quartile and largest thickness at the nodes, m.
    pub thickness_quantiles_m: [f64; 5],
    /// The errors expected of shell and solid.
    pub expected: String,
    /// Why a solid is to be taken whatever is expected of it.
    pub too_thick: Option<String>,
}

/// Size of the model and how well it was solved.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ModelInfo {
    /// Nodes.
    pub n_nodes: usize,
    /// Triangles.
    pub n_triangles: usize,
    /// Equations.
    pub n_equations: usize,
    /// Non-zeros of the Cholesky factor.
    pub nnz_l: usize,
    /// ‖K x − f‖ / ‖f‖, the worst gauge's.
    pub worst_relative_residual: f64,
    /// Normwise backward error, the worst gauge's.
    pub worst_backward_error: f64,
}

/// A gauge.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GaugeInfo {
    /// Where it is glued: on the inner side of the wall, m.
    pub position_m: [f64; 3],
    /// The direction it measures.
    pub axis: [f64; 3],
    /// The node whose newton it reads most of.
    pub strongest_node: usize,
    /// Where that node is, m.
    pub strongest_position_m: [f64; 3],
    /// What it reads for it, µε/N.
    pub strongest_ue_per_n: f64,
}

impl ShellLimb {
    /// The shell of the limb whose surface is in the file `path`, and the readings of its gauges.
    ///
    /// # Errors
    /// [`HapdefError::Mesh`] for a surface that takes no wall, with the cause;
    /// [`HapdefError::WallFolds`]; [`HapdefError::TooFewGaugeSites`]; [`HapdefError::Sim`].
    pub fn read(
        path: &Path,
        unit: LengthUnit,
        params: &ShellLimbParams,
    ) -> Result<Self, HapdefError> {
        let started = Instant::now();
        let given = read_surface(path, &GltfParams { unit, ..GltfParams::default() })?.mesh;
        let skin = Skin::of(&given, &params.skin()).map_err(advise_on_folds)?;
        let (mut scene, mount) = params.scene(&skin)?;
        scene.name = default_name(path);
        let file_hash = file_hash(path)?;
        let solid = SkinSolid::of(&skin.surface, &skin.wall_m, params.skin().side)?;
        let solid = Solid::of_skin(&scene, solid, file_hash.clone())?;
        let mut limb = Limb::of(&scene, Path::new(""), solid)?;
        limb.shell.iter_mut().for_each(|shell| shell.kind = params.kind);
        let long_axis = Vector3::ith(skin.surface.bounding_box().size_m().imax(), 1.0);
        let n_passed_over = spread_gauges(&mut scene, &limb, long_axis, params.n_gauges)?;
        limb.sites = scene.gauges.sites.iter().map(|entry| site(entry, &scene)).collect();
        (limb.gauges, limb.patches) =
            place_gauges(&scene, &limb.sites, &limb.mesh, &limb.boundary)?;
        let model = LimbModel::build(&limb, params.n_threads)?;
        let (fields, solved) = model.fields(&model.gauges(&limb.sites, &limb.gauges)?)?;
        let rising = sorted(skin.wall_m.iter().copied());
        let held = |shell: &WallShell| shell.under_all(&limb.clamped).len();
        let info = ShellLimbInfo {
            wall: WallInfo {
                made: skin.said.clone(),
                target_edge_m: skin.edge_m,
                side: params.side(),
                thickness_quantiles_m: [0.0, 0.25, 0.5, 0.75, 1.0].map(|q| quantile(&rising, q)),
                expected: limb.wall.iter().map(ToString::to_string).collect(),
                too_thick: limb.wall.as_ref().and_then(|wall| wall.measures.too_thick()),
            },
            mount: MountInfo { n_clamped: limb.shell.as_ref().map_or(0, held), ..mount },
            model: ModelInfo {
                n_nodes: model.model.info().n_fe_nodes,
                n_triangles: limb.shell.as_ref().map_or(0, WallShell::n_triangles),
                n_equations: model.model.info().n_equations,
                nnz_l: model.model.info().nnz_l,
                worst_relative_residual: solved.worst_relative_residual,
                worst_backward_error: solved.worst_backward_error,
            },
            gauges: Vec::new(),
            n_sites_passed_over: n_passed_over,
            median_best_ue_per_n: 0.0,
            elapsed_s: started.elapsed().as_secs_f64(),
        };
        let file = path.display().to_string();
        let mut made =
            Self { params: params.clone(), file, file_hash, scene, limb, info, skin, fields };
        made.tell_readings();
        Ok(made)
    }

    /// What every gauge reads for a newton anywhere on the skin.
    ///
    /// # Errors
    /// [`HapdefError::Inverse`].
    pub fn response(&self) -> Result<ResponseMap, HapdefError> {
        let (skin, n_gauges) = (touchable_skin(&self.limb)?, self.limb.sites.len());
        Ok(ResponseMap::from_nodal(skin, n_gauges, &self.fields, &ResponseParams::default())?)
    }

    /// What every gauge reads for a newton inward on every node `[n_nodes, n_gauges]`, µε/N.
    #[must_use]
    pub fn readings_ue_per_n(&self) -> Vec<f64> {
        let rows = self.fields.chunks(self.limb.sites.len()).zip(&self.limb.directions);
        rows.flat_map(|(row, inward)| row.iter().map(|field| field.dot(inward))).collect()
    }

    /// The strongest reading of any gauge for a newton on each node, magnitude `[n_nodes]`, µε/N.
    #[must_use]
    pub fn best_ue_per_n(&self) -> Vec<f64> {
        let best = |row: &[f64]| row.iter().fold(0.0_f64, |best, r| best.max(r.abs()));
        self.readings_ue_per_n().chunks(self.limb.sites.len()).map(best).collect()
    }

    fn tell_readings(&mut self) {
        let (limb, readings) = (&self.limb, self.readings_ue_per_n());
        let n_gauges = limb.sites.len();
        let gauge = |g: usize| {
            let reading = |node: usize| readings[node * n_gauges + g];
            let stronger =
                |a: usize, b: usize| if reading(b).abs() > reading(a).abs() { b } else { a };
            let strongest = (0..limb.n_surface_nodes()).fold(0, stronger);
            GaugeInfo {
                position_m: limb.sites[g].position.coords.into(),
                axis: limb.gauges[g].axis().into(),
                strongest_node: strongest,
                strongest_position_m: limb.mesh.position(limb.skin.nodes[strongest]).coords.into(),
                strongest_ue_per_n: reading(strongest),
            }
        };
        self.info.gauges = (0..n_gauges).map(gauge).collect();
        let best = self.best_ue_per_n().into_iter().zip(&limb.skin.nodes);
        let free = best.filter(|(_, node)| limb.clamped.binary_search(node).is_err());
        self.info.median_best_ue_per_n = median(free.map(|(best, _)| best));
    }
}

/// Hash of a file's bytes (BLAKE3).
///
/// # Errors
/// [`HapdefError::File`].
pub(super) fn file_hash(path: &Path) -> Result<String, HapdefError> {
    let bytes = std::fs::read(path).map_err(HapdefError::file(path))?;
    Ok(blake3::hash(&bytes).to_hex().to_string())
}

/// A wall that doesn't fit may do on both sides of the skin.
fn advise_on_folds(error: HapdefError) -> HapdefError {
    match error {
        HapdefError::Mesh(folds) if is_fold(&folds) => HapdefError::WallFolds(folds),
        other => other,
    }
}
