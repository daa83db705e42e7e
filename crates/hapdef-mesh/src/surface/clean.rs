//! What a caller may ask to be done to a surface before it is used: nothing happens unasked, and
//! everything is counted.

use super::defects::SurfaceDefects;
use crate::surface::quality::is_flat;
use crate::surface::topology::{bodies, repeats};
use crate::{MeshError, SurfaceFault, SurfaceMesh};

/// Which bodies (sets of triangles connected across edges) are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BodyChoice {
    /// All of them.
    All,
    /// The one with the largest area; of equals the first.
    LargestArea,
    /// One by number, counted from 0 in order of their first triangle.
    Number(usize),
}

/// What [`clean_surface`] does; by default nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CleanParams {
    /// Join vertices no farther apart than this, m ([`SurfaceMesh::weld`]).
    pub weld_tolerance_m: Option<f64>,
    /// Drop triangles without area.
    pub drop_degenerate: bool,
    /// Drop triangles with the corners of an earlier one.
    pub drop_doubled: bool,
    /// Turn triangles over until neighbours agree ([`SurfaceMesh::oriented`]).
    pub orient: bool,
    /// Keep these bodies.
    pub body: BodyChoice,
}

impl Default for CleanParams {
    fn default() -> Self {
        Self {
            weld_tolerance_m: None,
            drop_degenerate: false,
            drop_doubled: false,
            orient: false,
            body: BodyChoice::All,
        }
    }
}

/// What [`clean_surface`] did, with the defects before and after.
#[derive(Clone, Debug, PartialEq)]
pub struct CleanInfo {
    /// The surface as given.
    pub before: SurfaceDefects,
    /// The surface as returned.
    pub after: SurfaceDefects,
    /// Vertices joined with an earlier one.
    pub n_welded_vertices: usize,
    /// Triangles that lost a corner by welding, dropped.
    pub n_collapsed_triangles: usize,
    /// Triangles without area, dropped.
    pub n_degenerate_dropped: usize,
    /// Repeated triangles, dropped.
    pub n_doubled_dropped: usize,
    /// Triangles turned over.
    pub n_turned: usize,
    /// Signed volume of every body before one was chosen, m³, by number.
    pub body_volumes_m3: Vec<f64>,
    /// Area of every body before one was chosen, m², by number.
    pub body_areas_m2: Vec<f64>,
    /// Triangles of bodies that were not chosen.
    pub n_other_body_triangles: usize,
}

/// The surface with what `params` asks for done to it, in the order: weld, drop degenerate, drop
/// doubled, orient, choose a body, drop vertices that no triangle uses. Compare [`CleanInfo::before`] with
/// [`CleanInfo::after`]: volume, area and open edges say whether the result still is the part.
///
/// # Errors
/// A bad tolerance, a body that is not there, or no triangle left.
pub fn clean_surface(
    mesh: &SurfaceMesh,
    params: &CleanParams,
) -> Result<(SurfaceMesh, CleanInfo), MeshError> {
    let before = SurfaceDefects::of(mesh);
    let (mut n_welded_vertices, mut n_collapsed_triangles) = (0, 0);
    let mut surface = mesh.clone();
    if let Some(tolerance_m) = params.weld_tolerance_m {
        let (welded, info) = surface.weld(tolerance_m)?;
        n_welded_vertices = info.n_merged_vertices;
        n_collapsed_triangles = info.n_collapsed_triangles + info.n_repeated_corner_triangles;
        surface = welded;
    }
    let mut triangles = surface.triangles().to_vec();
    let n_degenerate_dropped =
        if params.drop_degenerate { drop_degenerate(&surface, &mut triangles) } else { 0 };
    let n_doubled_dropped = if params.drop_doubled { drop_doubled(&mut triangles) } else { 0 };
    let surface = SurfaceMesh::new(surface.vertices().to_vec(), triangles)?;
    let (surface, n_turned) = if params.orient { surface.oriented() } else { (surface, 0) };
    let bodies = bodies(surface.triangles());
    let parts: Vec<SurfaceMesh> =
        bodies.iter().map(|body| part(&surface, body)).collect::<Result<_, _>>()?;
    let areas: Vec<f64> = parts.iter().map(SurfaceMesh::area_m2).collect();
    let body_volumes_m3 = parts.iter().map(SurfaceMesh::signed_volume_m3).collect();
    let kept = chosen(params.body, &surface, &parts, &areas)?;
    let info = CleanInfo {
        before,
        after: SurfaceDefects::of(&kept),
        n_welded_vertices,
        n_collapsed_triangles,
        n_degenerate_dropped,
        n_doubled_dropped,
        n_turned,
        body_volumes_m3,
        body_areas_m2: areas,
        n_other_body_triangles: surface.triangles().len() - kept.triangles().len(),
    };
    Ok((kept, info))
}

/// The triangles listed, with the vertices they use in their old order.
pub(crate) fn part(mesh: &SurfaceMesh, triangles: &[usize]) -> Result<SurfaceMesh, MeshError> {
    let mut used = vec![false; mesh.vertices().len()];
    for corner in triangles.iter().flat_map(|&t| mesh.triangles()[t]) {
        used[corner as usize] = true;
    }
    let mut new_vertex = vec![0; used.len()];
    let mut vertices = Vec::new();
    for (old, _) in used.iter().enumerate().filter(|(_, used)| **used) {
        new_vertex[old] = vertices.len() as u32;
        vertices.push(mesh.vertices()[old]);
    }
    let renamed = |&t: &usize| mesh.triangles()[t].map(|v| new_vertex[v as usize]);
    SurfaceMesh::new(vertices, triangles.iter().map(renamed).collect())
}

fn chosen(
    choice: BodyChoice,
    surface: &SurfaceMesh,
    parts: &[SurfaceMesh],
    areas: &[f64],
) -> Result<SurfaceMesh, MeshError> {
    let number = match choice {
        BodyChoice::All => {
            let all: Vec<usize> = (0..surface.triangles().len()).collect();
            return part(surface, &all);
        }
        BodyChoice::LargestArea => {
            let largest = areas.iter().copied().fold(0.0, f64::max);
            areas.iter().position(|a| *a == largest).unwrap_or(0)
        }
        BodyChoice::Number(number) => number,
    };
    let n_bodies = parts.len();
    let fault = SurfaceFault::NoSuchBody { body: number, n_bodies };
    Ok(parts.get(number).cloned().ok_or(fault)?)
}

fn drop_degenerate(surface: &SurfaceMesh, triangles: &mut Vec<[u32; 3]>) -> usize {
    let n_before = triangles.len();
    let mut triangle = 0;
    triangles.retain(|corners| {
        triangle += 1;
        !repeats(corners) && !is_flat(surface, triangle - 1)
    });
    n_before - triangles.len()
}

fn drop_doubled(triangles: &mut Vec<[u32; 3]>) -> usize {
    let n_before = triangles.len();
    let mut seen = std::collections::BTreeSet::new();
    triangles.retain(|corners| {
        let mut key = *corners;
        key.sort_unstable();
        seen.insert(key)
    });
    n_before - triangles.len()
}
