//! The grid's cells as ten-node tetrahedra.

use std::collections::BTreeMap;

use nalgebra::Point3;

use super::ShinParams;
use super::grid::{Cell, Grid};
use crate::{FeNodeId, MeshError, TET10_EDGES, Tet10Mesh, Tri6Face};

/// A corner node: its column and its level below the outer surface.
type Corner = (usize, usize);

/// The limb's mesh and the parts of it that have a name.
pub(super) struct Built {
    pub(super) mesh: Tet10Mesh,
    pub(super) skin_faces: Vec<Tri6Face>,
    pub(super) mount: Vec<FeNodeId>,
}

pub(super) fn build(params: &ShinParams, grid: &Grid) -> Result<Built, MeshError> {
    let layer_m = params.rib_depth_m / params.n_rib_layers as f64;
    let below = (0..=params.n_rib_layers).map(|layer| params.wall_m + layer_m * layer as f64);
    let depths_m: Vec<f64> = [0.0].into_iter().chain(below).collect();
    let tets = tetrahedra(params, grid, &depths_m);
    let corners: BTreeMap<Corner, usize> = numbered(tets.iter().flatten().copied(), 0);
    let edges = tets.iter().flat_map(|tet| TET10_EDGES.map(|[a, b]| sorted(tet[a], tet[b])));
    let mids: BTreeMap<(Corner, Corner), usize> = numbered(edges, corners.len());

    let mut nodes = Vec::with_capacity(corners.len() + mids.len());
    nodes.extend(corners.keys().map(|corner| corner_point(params, grid, &depths_m, *corner)));
    nodes.extend(mids.keys().map(|edge| mid_point(params, grid, &depths_m, *edge)));
    let elements = tets
        .iter()
        .map(|tet| {
            std::array::from_fn(|i| match i {
                0..4 => FeNodeId::from_index(corners[&tet[i]]),
                _ => {
                    let [a, b] = TET10_EDGES[i - 4];
                    FeNodeId::from_index(mids[&sorted(tet[a], tet[b])])
                }
            })
        })
        .collect();
    let mesh = Tet10Mesh::new(nodes, elements)?;
    let by_id: Vec<Corner> = corners.into_keys().collect();
    let skin_faces = faces_where(&mesh, &by_id, |face| is_skin(grid, face));
    let mount_faces = faces_where(&mesh, &by_id, |face| is_mount(grid, face));
    let mount = crate::solid::boundary::nodes_of(&mount_faces);
    Ok(Built { mesh, skin_faces, mount })
}

/// All tetrahedra by corners, with positive volume.
fn tetrahedra(params: &ShinParams, grid: &Grid, depths_m: &[f64]) -> Vec<[Corner; 4]> {
    let mut tets = Vec::new();
    for j in 0..grid.n_along {
        for i in 0..grid.n_around {
            let n_layers = match grid.cell(i, j) {
                Cell::Hole(_) => 0,
                Cell::Panel => 1,
                Cell::Rib | Cell::EndRing => depths_m.len() - 1,
            };
            for layer in 0..n_layers {
                for triangle in grid.triangles(i, j) {
                    tets.extend(prism(triangle, layer, params.other_diagonals));
                }
            }
        }
    }
    for tet in &mut tets {
        let [a, b, c, d] = tet.map(|corner| corner_point(params, grid, depths_m, corner));
        if (b - a).cross(&(c - a)).dot(&(d - a)) < 0.0 {
            tet.swap(1, 2);
        }
    }
    tets
}

/// The prism over three columns between level `layer` and the next as three tetrahedra. Every
/// side's diagonal runs from the column with the smaller number above to the other below, so that
/// neighbours agree (Dompierre, Labbé, Vallet and Camarero, 8th International Meshing Roundtable,
/// 1999); from the larger number if `other_diagonals`.
fn prism(mut columns: [usize; 3], layer: usize, other_diagonals: bool) -> [[Corner; 4]; 3] {
    columns.sort_unstable();
    if other_diagonals {
        columns.reverse();
    }
    let [p, q, r] = columns;
    let (above, below) = (layer, layer + 1);
    [
        [(p, above), (q, above), (r, above), (r, below)],
        [(p, above), (q, above), (q, below), (r, below)],
        [(p, above), (p, below), (q, below), (r, below)],
    ]
}

fn corner_point(params: &ShinParams, grid: &Grid, depths_m: &[f64], corner: Corner) -> Point3<f64> {
    let place = grid.place(corner.0);
    params.outline.point(place.theta, place.y_m, depths_m[corner.1])
}

fn mid_point(
    params: &ShinParams,
    grid: &Grid,
    depths_m: &[f64],
    (a, b): (Corner, Corner),
) -> Point3<f64> {
    let place = if a.0 == b.0 { grid.place(a.0) } else { grid.between(a.0, b.0) };
    let depth_m = 0.5 * (depths_m[a.1] + depths_m[b.1]);
    params.outline.point(place.theta, place.y_m, depth_m)
}

fn numbered<K: Ord>(keys: impl Iterator<Item = K>, first: usize) -> BTreeMap<K, usize> {
    let mut numbers: BTreeMap<K, usize> = keys.map(|key| (key, 0)).collect();
    for (number, place) in (first..).zip(numbers.values_mut()) {
        *place = number;
    }
    numbers
}

fn sorted(a: Corner, b: Corner) -> (Corner, Corner) {
    if a < b { (a, b) } else { (b, a) }
}

fn faces_where(
    mesh: &Tet10Mesh,
    by_id: &[Corner],
    wanted: impl Fn([Corner; 3]) -> bool,
) -> Vec<Tri6Face> {
    let corners = |face: &Tri6Face| [0, 1, 2].map(|k| by_id[face.nodes[k].index()]);
    mesh.boundary().faces.into_iter().filter(|face| wanted(corners(face))).collect()
}

/// On the outer surface, between the end rings.
fn is_skin(grid: &Grid, face: [Corner; 3]) -> bool {
    face.iter().all(|(column, level)| {
        let row = column / grid.n_around;
        *level == 0 && 0 < row && row < grid.n_along
    })
}

/// On the lower end, in the first layer inside the wall.
fn is_mount(grid: &Grid, face: [Corner; 3]) -> bool {
    face.iter().all(|(column, level)| {
        let row = column / grid.n_around;
        row == 0 && (1..=2).contains(level)
    })
}
