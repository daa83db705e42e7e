//! The shell in a closed, double-walled solid: its outer skin and the wall behind it.

use super::pieces::{largest_piece, split_pinched};
use super::walls::{WallKind, Walls};
use super::{ShellSurface, SkinSide, SolidShellParams};
use crate::skin::rays::FaceRays;
use crate::surface::clean::part;
use crate::surface::find_defects::{check_closed, check_size};
use crate::surface::self_intersection::check_uncrossed;
use crate::surface::topology::bodies;
use crate::{MeshError, SurfaceFault, SurfaceMesh};

/// The outer skin of a solid where it is a shell.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidShell {
    /// The skin: the largest connected piece of shell.
    pub skin: SurfaceMesh,
    /// The wall's thickness at every vertex of the skin, m.
    pub thickness_m: Vec<f64>,
    /// For each triangle of the skin the solid's, ascending.
    pub solid_triangle: Vec<usize>,
    /// What each triangle of the solid is.
    pub kinds: Vec<WallKind>,
    /// The wall's thickness behind each triangle of the solid, m; 0 where there is none.
    pub triangle_thickness_m: Vec<f64>,
    /// Areas, shares and volumes.
    pub info: SolidShellInfo,
}

/// What was found on the way from a solid to its shell. Shares are of the outer skin's area.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidShellInfo {
    /// Area of everything that sees the outside, m².
    pub outer_area_m2: f64,
    /// Triangles that see the outside.
    pub n_outer_triangles: usize,
    /// Share that is no shell: the sum of the following four.
    pub not_shell_share: f64,
    /// Share of [`WallKind::SolidCore`].
    pub solid_core_share: f64,
    /// Share of [`WallKind::NoWall`].
    pub no_wall_share: f64,
    /// Share of [`WallKind::TooThick`].
    pub too_thick_share: f64,
    /// Share of [`WallKind::Island`].
    pub island_share: f64,
    /// Vertices where two fans of the skin touched, given to each fan.
    pub n_split_vertices: usize,
    /// Cavities that are surfaces of their own.
    pub n_cavities: usize,
    /// 0, 25, 50, 75 and 100 % of the skin's area have at most this thickness, m.
    pub thickness_quantiles_m: [f64; 5],
    /// The solid's volume, m³.
    pub solid_volume_m3: f64,
    /// Area times thickness of the skin at mid-wall, m³.
    pub shell_volume_m3: f64,
}

/// Finds the outer skin of `solid` and its wall, and refuses what is not a shell.
///
/// A triangle is outer skin if most rays from it within a cone about its normal leave the solid
/// ([`SolidShellParams::outer`]), or clearly more than from the surface behind it. The thickness is
/// measured inward from points near a triangle's corners and at its middle: the median, over a
/// narrow cone of rays, of the distance to the first surface parallel to the skin, times the cosine
/// of the ray's angle, in the manner of the shape diameter
/// function (Shapira, Shamir and Cohen-Or, The Visual Computer 24, 2008). Ribs count to the wall.
/// The inner side of a solid ring counts as inside where the ring's far side hides it.
///
/// # Errors
/// [`MeshError::Surface`]: open, non-manifold, misoriented, degenerate or doubled; several solids;
/// a volume no solid has; a size no limb has; a surface that goes through itself; no outer skin; not a shell over too large a share;
/// a shell whose volume is not the solid's. The measured shell is still to be had with
/// [`measure_solid`].
pub fn shell_from_solid(
    solid: &SurfaceMesh,
    params: &SolidShellParams,
) -> Result<SolidShell, MeshError> {
    let found = measure_solid(solid, params)?;
    let info = &found.info;
    if info.not_shell_share > params.max_not_shell_share {
        return Err(not_a_shell(info, params).into());
    }
    let difference = (info.shell_volume_m3 / info.solid_volume_m3 - 1.0).abs();
    if difference > params.max_volume_difference {
        return Err(SurfaceFault::ShellVolume {
            shell_volume_m3: info.shell_volume_m3,
            solid_volume_m3: info.solid_volume_m3,
            difference,
            allowed_difference: params.max_volume_difference,
        }
        .into());
    }
    Ok(found)
}

/// As [`shell_from_solid`], but takes any share and any volume: for the picture and the figures of
/// a solid that is refused.
///
/// # Errors
/// Those of [`shell_from_solid`] except [`SurfaceFault::NotAShell`], if there is any shell at all,
/// and [`SurfaceFault::ShellVolume`].
pub fn measure_solid(
    solid: &SurfaceMesh,
    params: &SolidShellParams,
) -> Result<SolidShell, MeshError> {
    params.check()?;
    let solid_volume_m3 = check_closed(solid)?.volume_m3;
    if !params.any_size {
        check_size(solid)?;
    }
    let n_cavities = check_one_solid(solid)?;
    let advice = "what is inside is not defined there: unite the parts where the solid was drawn, or \
                  take its outer skin with a given thickness";
    check_uncrossed(solid, "the solid", advice)?;
    let mut walls = Walls::of(solid, params);
    if walls.kinds.iter().all(|kind| *kind == WallKind::Inside) {
        let n_triangles = solid.triangles().len();
        return Err(SurfaceFault::NoOuterSkin { n_triangles }.into());
    }
    let solid_triangle = largest_piece(solid, &mut walls.kinds);
    let mut info = info_of(solid, &walls, &solid_triangle);
    info.solid_volume_m3 = solid_volume_m3;
    info.n_cavities = n_cavities;
    if solid_triangle.is_empty() {
        return Err(not_a_shell(&info, params).into());
    }
    let (skin, n_split_vertices) = split_pinched(&part(solid, &solid_triangle)?)?;
    let thickness_m = node_thickness(&skin, &solid_triangle, &walls);
    info.n_split_vertices = n_split_vertices;
    info.shell_volume_m3 = wall_volume_m3(&skin, &thickness_m);
    Ok(SolidShell {
        skin,
        thickness_m,
        solid_triangle,
        kinds: walls.kinds,
        triangle_thickness_m: walls.thickness_m,
        info,
    })
}

impl SolidShell {
    /// The shell: the skin moved inward to mid-wall.
    ///
    /// # Errors
    /// [`SurfaceFault::OffsetFolds`] where the wall is too thick for the skin's curvature.
    pub fn shell(&self) -> Result<ShellSurface, MeshError> {
        ShellSurface::from_skin(&self.skin, &self.thickness_m, SkinSide::Outer)
    }
}

fn not_a_shell(info: &SolidShellInfo, params: &SolidShellParams) -> SurfaceFault {
    SurfaceFault::NotAShell {
        share: info.not_shell_share,
        allowed_share: params.max_not_shell_share,
        solid_core_share: info.solid_core_share,
        no_wall_share: info.no_wall_share,
        too_thick_share: info.too_thick_share,
        island_share: info.island_share,
        max_thickness_ratio: params.max_thickness_ratio,
        volume_m3: info.solid_volume_m3,
    }
}

/// One body that faces outward, all others inside it and facing inward; the number of those.
fn check_one_solid(solid: &SurfaceMesh) -> Result<usize, MeshError> {
    let parts: Vec<SurfaceMesh> =
        bodies(solid.triangles()).iter().map(|body| part(solid, body)).collect::<Result<_, _>>()?;
    let volumes_m3: Vec<f64> = parts.iter().map(SurfaceMesh::signed_volume_m3).collect();
    let outward: Vec<usize> = (0..parts.len()).filter(|&i| volumes_m3[i] > 0.0).collect();
    let [outer] = outward[..] else {
        return Err(SurfaceFault::Bodies { volumes_m3 }.into());
    };
    let rays = FaceRays::of_surface(&parts[outer]);
    let aside = nalgebra::Vector3::new(0.267, 0.535, 0.802);
    for body in (0..parts.len()).filter(|&i| i != outer) {
        let n_crossed = rays.hits(&parts[body].vertices()[0], &aside, usize::MAX).len();
        if n_crossed.is_multiple_of(2) {
            let volume_m3 = volumes_m3[body];
            return Err(SurfaceFault::CavityOutside { body, volume_m3 }.into());
        }
    }
    Ok(parts.len() - 1)
}

fn info_of(solid: &SurfaceMesh, walls: &Walls, skin: &[usize]) -> SolidShellInfo {
    let area = |wanted: WallKind| -> f64 {
        let of_kind = walls.kinds.iter().enumerate().filter(|(_, kind)| **kind == wanted);
        of_kind.fold(0.0, |sum, (t, _)| sum + solid.area_normal_m2(t).norm())
    };
    let inside = area(WallKind::Inside);
    let outer_area_m2 = solid.area_m2() - inside;
    let share = |kind| area(kind) / outer_area_m2;
    let [core, no_wall, thick, island] =
        [WallKind::SolidCore, WallKind::NoWall, WallKind::TooThick, WallKind::Island].map(share);
    SolidShellInfo {
        outer_area_m2,
        n_outer_triangles: walls.kinds.iter().filter(|k| **k != WallKind::Inside).count(),
        not_shell_share: core + no_wall + thick + island,
        solid_core_share: core,
        no_wall_share: no_wall,
        too_thick_share: thick,
        island_share: island,
        n_split_vertices: 0,
        n_cavities: 0,
        thickness_quantiles_m: quantiles(solid, walls, skin),
        solid_volume_m3: 0.0,
        shell_volume_m3: 0.0,
    }
}

/// Area-weighted quantiles of the thickness over the triangles of the skin.
fn quantiles(solid: &SurfaceMesh, walls: &Walls, skin: &[usize]) -> [f64; 5] {
    let mut rows: Vec<(f64, f64)> =
        skin.iter().map(|&t| (walls.thickness_m[t], solid.area_normal_m2(t).norm())).collect();
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = rows.iter().map(|row| row.1).sum();
    [0.0, 0.25, 0.5, 0.75, 1.0].map(|q| {
        let mut below = 0.0;
        let at = rows.iter().find(|row| {
            below += row.1;
            below >= q * total
        });
        at.or(rows.last()).map_or(0.0, |row| row.0)
    })
}

/// The mean of what was measured near a vertex in its triangles, weighted by their area.
fn node_thickness(skin: &SurfaceMesh, solid_triangle: &[usize], walls: &Walls) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); skin.vertices().len()];
    for (triangle, corners) in skin.triangles().iter().enumerate() {
        let area = skin.area_normal_m2(triangle).norm();
        for (&v, thickness_m) in corners.iter().zip(walls.corners_m[solid_triangle[triangle]]) {
            let sum = &mut sums[v as usize];
            *sum = (sum.0 + area * thickness_m, sum.1 + area);
        }
    }
    sums.into_iter().map(|(sum, area)| sum / area).collect()
}

/// Σ thickness × area half-way between the skin and the skin moved inward by the thickness.
fn wall_volume_m3(skin: &SurfaceMesh, thickness_m: &[f64]) -> f64 {
    let normals = skin.vertex_normals();
    let middle = |v: u32| {
        let v = v as usize;
        skin.vertices()[v] - normals[v] * (0.5 * thickness_m[v])
    };
    let of_triangle = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(middle);
        let sum: f64 = corners.iter().map(|&v| thickness_m[v as usize]).sum();
        0.5 * (b - a).cross(&(c - a)).norm() * sum / 3.0
    };
    skin.triangles().iter().map(of_triangle).sum()
}
