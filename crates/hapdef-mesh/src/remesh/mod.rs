//! Isotropic remeshing to a target edge length: Botsch and Kobbelt, A remeshing approach to
//! multiresolution modeling, Symposium on Geometry Processing 2004, section 4.

mod distance;
mod relax;
mod sweep;
mod work;

pub use distance::{SurfaceDistance, surface_distance};

use self::relax::{Origin, relax};
use self::sweep::{collapse_short, flip_edges, split_long};
use self::work::{Kind, Work};
use crate::surface::find_defects::check_manifold;
use crate::surface::topology::sorted_half_edges;
use crate::{MeshError, SurfaceFault, SurfaceMesh};

/// How a surface is remeshed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RemeshParams {
    /// The edge length wanted, m; edges between 4/5 and 4/3 of it are left alone.
    pub target_edge_m: f64,
    /// Rounds of split, collapse, flip and smoothing.
    pub n_rounds: usize,
    /// Edges whose triangles differ in direction by more than this stay, rad; open edges always do.
    pub feature_angle_rad: f64,
    /// Refuse a result farther from the given surface than this, m.
    pub max_distance_m: f64,
    /// Refuse a result whose volume differs by more than this, relative; closed surfaces only.
    pub max_volume_change: f64,
    /// Refuse an edge length that asks for more triangles than this.
    pub max_triangles: usize,
}

impl RemeshParams {
    /// Ten rounds, features above 40°, and a result within a quarter of an edge length and 2 % of
    /// the volume, two million triangles at most.
    #[must_use]
    pub fn new(target_edge_m: f64) -> Self {
        Self {
            target_edge_m,
            n_rounds: 10,
            feature_angle_rad: 40.0_f64.to_radians(),
            max_distance_m: 0.25 * target_edge_m,
            max_volume_change: 0.02,
            max_triangles: 2_000_000,
        }
    }
}

/// What [`remesh`] did.
#[derive(Clone, Debug, PartialEq)]
pub struct RemeshInfo {
    /// Edges split, collapsed and flipped in all rounds.
    pub n_operations: [usize; 3],
    /// Creases and corners of the given surface: edges, and vertices where creases meet, end or
    /// bend.
    pub n_features: [usize; 2],
    /// Crease vertices and corners that gave way to another one nearer than 2/15 of the target,
    /// though not along their crease.
    pub n_merged_features: usize,
    /// Shortest edge, 5 %, median, 95 % and longest edge of the result, m.
    pub edge_quantiles_m: [f64; 5],
    /// Share of edges between 4/5 and 4/3 of the target.
    pub on_target_share: f64,
    /// The enclosed volume before and after, m³; `None` for an open surface.
    pub volume_m3: Option<[f64; 2]>,
    /// The area before and after, m².
    pub area_m2: [f64; 2],
    /// Largest distance sampled between the given surface (first) and the result (second).
    pub distance: SurfaceDistance,
}

/// The surface with triangles of nearly one size: edges longer than 4/3 of the target are split,
/// shorter ones than 4/5 collapsed, edges flipped towards six neighbours a vertex, and vertices
/// smoothed within the surface and put back onto it, for a number of rounds.
///
/// Sharp edges and rims stay where they are, their ends and bends too; vertices move along them
/// only. Of two closer than 2/15 of the target one goes ([`RemeshInfo::n_merged_features`]). No
/// operation turns a face by more than 45°, slivers apart, or changes what is connected to what.
/// The same input gives the same result, bit for bit. Edges between features closer than the
/// target stay short ([`RemeshInfo::on_target_share`]).
///
/// # Errors
/// [`MeshError::Surface`]: a surface that is no oriented manifold, or has degenerate or doubled
/// triangles; a parameter out of its range; too many triangles; a result that strays farther than
/// allowed in distance or volume.
pub fn remesh(
    mesh: &SurfaceMesh,
    params: &RemeshParams,
) -> Result<(SurfaceMesh, RemeshInfo), MeshError> {
    params.check(mesh)?;
    let is_closed = check_manifold(mesh)?.is_closed();
    let (shortest_m, longest_m) = (0.8 * params.target_edge_m, params.target_edge_m / 0.75);
    let mut work = Work::new(mesh, params.feature_angle_rad);
    let n_corners = work.kinds.iter().filter(|k| **k == Kind::Corner).count();
    let n_features = [work.creases.len(), n_corners];
    let origin = Origin::new(mesh, &work);
    let mut n_operations = [0; 3];
    for _ in 0..params.n_rounds {
        // Slivers go before their long edges are split, which would multiply them.
        n_operations[1] += collapse_short(&mut work, shortest_m, longest_m);
        n_operations[0] += split_long(&mut work, longest_m);
        n_operations[1] += collapse_short(&mut work, shortest_m, longest_m);
        n_operations[2] += flip_edges(&mut work);
        relax(&mut work, &origin);
    }
    let result = work.surface()?;
    let lengths = edge_lengths_m(&result);
    let on_target =
        lengths.partition_point(|l| *l <= longest_m) - lengths.partition_point(|l| *l < shortest_m);
    let info = RemeshInfo {
        n_operations,
        n_features,
        n_merged_features: work.n_merged_features,
        edge_quantiles_m: [0.0, 0.05, 0.5, 0.95, 1.0]
            .map(|q| lengths[(q * (lengths.len() - 1) as f64).round() as usize]),
        on_target_share: on_target as f64 / lengths.len() as f64,
        volume_m3: is_closed.then(|| [mesh.signed_volume_m3(), result.signed_volume_m3()]),
        area_m2: [mesh.area_m2(), result.area_m2()],
        distance: surface_distance(mesh, &result, 0.5 * params.target_edge_m),
    };
    params.check_result(&info)?;
    Ok((result, info))
}

impl RemeshInfo {
    /// The relative change of the volume; 0 for an open surface.
    #[must_use]
    pub fn volume_change(&self) -> f64 {
        self.volume_m3.map_or(0.0, |[before, after]| after / before - 1.0)
    }
}

impl RemeshParams {
    fn check(&self, mesh: &SurfaceMesh) -> Result<(), SurfaceFault> {
        let positive = |x: f64| x > 0.0 && x.is_finite();
        let (edge, angle) = (self.target_edge_m, self.feature_angle_rad);
        let angle_ok = angle > 0.0 && angle <= std::f64::consts::PI;
        let checks = [
            ("target_edge_m", edge, "above 0 and finite", positive(edge)),
            ("n_rounds", self.n_rounds as f64, "at least 1", self.n_rounds > 0),
            ("feature_angle_rad", angle, "above 0 and at most π", angle_ok),
            ("max_distance_m", self.max_distance_m, "at least 0", self.max_distance_m >= 0.0),
            (
                "max_volume_change",
                self.max_volume_change,
                "at least 0",
                self.max_volume_change >= 0.0,
            ),
        ];
        if let Some((name, found, wanted, _)) = checks.into_iter().find(|check| !check.3) {
            return Err(SurfaceFault::Parameter { name, found, wanted });
        }
        let area_m2 = mesh.area_m2();
        let n_triangles = (area_m2 / (3.0_f64.sqrt() / 4.0 * edge * edge)) as usize;
        if n_triangles > self.max_triangles {
            return Err(SurfaceFault::TooManyTriangles {
                target_edge_m: edge,
                area_m2,
                n_triangles,
                max_triangles: self.max_triangles,
            });
        }
        Ok(())
    }

    fn check_result(&self, info: &RemeshInfo) -> Result<(), SurfaceFault> {
        let (distance_m, volume_change) = (info.distance.largest_m(), info.volume_change());
        if distance_m <= self.max_distance_m && volume_change.abs() <= self.max_volume_change {
            return Ok(());
        }
        Err(SurfaceFault::RemeshStrays {
            distance_m,
            max_distance_m: self.max_distance_m,
            volume_change,
            max_volume_change: self.max_volume_change,
        })
    }
}

/// Lengths of all edges, ascending, m.
fn edge_lengths_m(mesh: &SurfaceMesh) -> Vec<f64> {
    let mut lengths: Vec<f64> = sorted_half_edges(mesh.triangles())
        .chunk_by(|a, b| a.ends() == b.ends())
        .map(|uses| {
            let [a, b] = [uses[0].low, uses[0].high].map(|v| mesh.vertices()[v as usize]);
            (b - a).norm()
        })
        .collect();
    lengths.sort_by(f64::total_cmp);
    lengths
}
