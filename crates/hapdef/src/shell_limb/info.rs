//! What was found and made on the way from a surface to gauge readings.

use hapdef_bench::stats;
use hapdef_mesh::SurfaceDefects;
use serde::Serialize;

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
    /// Time of each stage, s, in order.
    pub stages: Vec<StageTime>,
}

/// Counts, defects and volume of a surface.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SurfaceCounts {
    /// Vertices.
    pub n_vertices: usize,
    /// Triangles.
    pub n_triangles: usize,
    /// Edges with one triangle.
    pub n_open_edges: usize,
    /// Edges with more than two triangles.
    pub n_non_manifold_edges: usize,
    /// Edges whose triangles disagree on the outside.
    pub n_misoriented_edges: usize,
    /// Vertices where separate fans of triangles touch.
    pub n_non_manifold_vertices: usize,
    /// Triangles without area.
    pub n_degenerate_triangles: usize,
    /// Triangles with the corners of an earlier one.
    pub n_doubled_triangles: usize,
    /// Whether the surface is closed, so that its volume is one.
    pub is_closed: bool,
    /// Area, m².
    pub area_m2: f64,
    /// ⅓ ∮ x·n dA, m³: the enclosed volume of a closed surface, a number to compare otherwise.
    pub volume_m3: f64,
}

/// The way from the surface to the wall.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WallInfo {
    /// The surface as read.
    pub given: SurfaceCounts,
    /// After what was asked to be cleaned.
    pub cleaned: SurfaceCounts,
    /// Vertices joined with an earlier one.
    pub n_welded_vertices: usize,
    /// Triangles dropped: collapsed by welding, without area, doubled, of other bodies.
    pub n_dropped_triangles: [usize; 4],
    /// Triangles turned over.
    pub n_turned_triangles: usize,
    /// Volume of every body before one was chosen, m³.
    pub body_volumes_m3: Vec<f64>,
    /// What was measured, where the wall is measured.
    pub measured: Option<MeasuredWall>,
    /// The remeshed skin.
    pub remeshed: SurfaceCounts,
    /// The edge length wanted, m.
    pub target_edge_m: f64,
    /// Longer edge lengths that were tried first, where none was asked for.
    pub edges_refused: Vec<EdgeRefused>,
    /// Shortest, 5 %, median, 95 % and longest edge reached, m.
    pub edge_quantiles_m: [f64; 5],
    /// Largest sampled distance between the skin before and after remeshing, m.
    pub distance_m: f64,
    /// Area of the skin before remeshing, m².
    pub area_before_remesh_m2: f64,
    /// Relative change of the volume by remeshing; 0 for an open surface.
    pub volume_change: f64,
    /// Where the skin lies in the wall: `outer`, `middle` or `inner`.
    pub side: &'static str,
    /// Smallest, quartile, median, quartile and largest thickness at the nodes, m.
    pub thickness_quantiles_m: [f64; 5],
    /// Area times thickness of the middle surface, m³.
    pub wall_volume_m3: f64,
}

/// An edge length that doesn't do.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EdgeRefused {
    /// The edge length, m.
    pub edge_m: f64,
    /// Why it doesn't.
    pub cause: String,
}

/// How far a solid is a shell. Shares are of the outer skin's area.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MeasuredWall {
    /// Share that is no shell: the sum of the following.
    pub not_shell_share: f64,
    /// Share whose far side is outer skin too.
    pub solid_core_share: f64,
    /// Share without a parallel wall.
    pub no_wall_share: f64,
    /// Share with too thick a wall.
    pub too_thick_share: f64,
    /// Share apart from the largest piece.
    pub island_share: f64,
    /// The solid's volume, m³.
    pub solid_volume_m3: f64,
    /// The shell's volume, m³.
    pub shell_volume_m3: f64,
}

/// The held end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MountInfo {
    /// `x`, `y` or `z`.
    pub axis: char,
    /// `low` or `high`.
    pub end: &'static str,
    /// How far from the end nodes are clamped, m.
    pub length_m: f64,
    /// Clamped nodes.
    pub n_clamped: usize,
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
    /// ‖K x − f‖∞ / ‖f‖∞, the worst gauge's.
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
    /// Share of its footprint that misses the wall.
    pub lost_share: f64,
    /// The node whose newton it reads most of.
    pub strongest_node: usize,
    /// Where that node is, m.
    pub strongest_position_m: [f64; 3],
    /// What it reads for it, µε/N.
    pub strongest_ue_per_n: f64,
}

/// Time of a stage.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StageTime {
    /// Name.
    pub stage: &'static str,
    /// Seconds.
    pub elapsed_s: f64,
}

impl SurfaceCounts {
    pub(super) fn new(n_vertices: usize, n_triangles: usize, defects: &SurfaceDefects) -> Self {
        Self {
            n_vertices,
            n_triangles,
            n_open_edges: defects.open_edges.n,
            n_non_manifold_edges: defects.non_manifold_edges.n,
            n_misoriented_edges: defects.misoriented_edges.n,
            n_non_manifold_vertices: defects.non_manifold_vertices.n,
            n_degenerate_triangles: defects.degenerate_triangles.n,
            n_doubled_triangles: defects.doubled_triangles.n,
            is_closed: defects.is_closed(),
            area_m2: defects.area_m2,
            volume_m3: defects.volume_m3,
        }
    }
}

/// 0, 25, 50, 75 and 100 % of the values are at most this, nearest ranks; zeros without values.
pub(super) fn quartiles(values: impl IntoIterator<Item = f64>) -> [f64; 5] {
    let rising = stats::sorted(values);
    [0.0, 0.25, 0.5, 0.75, 1.0].map(|q| or_zero(stats::quantile(&rising, q), &rising))
}

/// The share `q` of the values is at most this, nearest rank; 0 without values.
pub(super) fn quantile(values: impl IntoIterator<Item = f64>, q: f64) -> f64 {
    let rising = stats::sorted(values);
    or_zero(stats::quantile(&rising, q), &rising)
}

fn or_zero(quantile: f64, rising: &[f64]) -> f64 {
    if rising.is_empty() { 0.0 } else { quantile }
}
