//! Places for gauges: spread over a wall, clear of its edges.

use nalgebra::Point3;

use crate::solid::boundary::nodes_of;
use crate::{FeNodeId, PointIndex, Tet10Mesh, Tri6Face};

/// The nodes of `wall_faces` that lie at least `clearance_m` from the wall's edges, ascending.
///
/// Edges are where only one of the faces is: rims of holes, and the feet of ribs that are not part
/// of the wall. Distances are straight lines to the nodes on those edges.
#[must_use]
pub fn clear_nodes(mesh: &Tet10Mesh, wall_faces: &[Tri6Face], clearance_m: f64) -> Vec<FeNodeId> {
    let rim: Vec<Point3<f64>> =
        edge_nodes(wall_faces).into_iter().map(|node| mesh.position(node)).collect();
    let rim = PointIndex::new(&rim);
    nodes_of(wall_faces)
        .into_iter()
        .filter(|node| rim.nearest(&mesh.position(*node)).is_none_or(|(_, d)| d >= clearance_m))
        .collect()
}

/// `n` of `candidates`, each as far as possible from those before it; fewer if there are fewer.
/// The first is the candidate farthest from the mean of all; ties go to the smaller id
/// (Gonzalez, Theoretical Computer Science 38, 1985).
#[must_use]
pub fn farthest_nodes(mesh: &Tet10Mesh, candidates: &[FeNodeId], n: usize) -> Vec<FeNodeId> {
    let mean = candidates.iter().fold(nalgebra::Vector3::zeros(), |sum, node| {
        sum + mesh.position(*node).coords / candidates.len() as f64
    });
    let distance_from = |from: &Point3<f64>| -> Vec<f64> {
        candidates.iter().map(|node| (mesh.position(*node) - from).norm()).collect()
    };
    let mut chosen = Vec::with_capacity(n);
    let mut nearest = distance_from(&Point3::from(mean));
    while chosen.len() < n.min(candidates.len()) {
        let mut best = 0;
        for (i, distance) in nearest.iter().enumerate() {
            if *distance > nearest[best] {
                best = i;
            }
        }
        let first = chosen.is_empty();
        chosen.push(candidates[best]);
        let from_new = distance_from(&mesh.position(candidates[best]));
        for (kept, new) in nearest.iter_mut().zip(from_new) {
            *kept = if first { new } else { kept.min(new) };
        }
    }
    chosen
}

/// The nodes on edges that belong to one face only, mid-side nodes included, ascending.
fn edge_nodes(faces: &[Tri6Face]) -> Vec<FeNodeId> {
    let mut edges: Vec<(FeNodeId, [FeNodeId; 2])> = faces
        .iter()
        .flat_map(|face| [[0, 1, 3], [1, 2, 4], [2, 0, 5]].map(|e| e.map(|i| face.nodes[i])))
        .map(|[a, b, mid]| (mid, [a, b]))
        .collect();
    edges.sort_unstable_by_key(|edge| edge.0);
    let single = edges.chunk_by(|a, b| a.0 == b.0).filter(|group| group.len() == 1);
    let mut nodes: Vec<FeNodeId> =
        single.flat_map(|group| [group[0].0, group[0].1[0], group[0].1[1]]).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}
