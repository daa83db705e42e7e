//! The wall made locally thicker or thinner by moving what lies below the skin.

use hapdef_mesh::{FeNodeId, MeshError, PointIndex, SkinRegion, Tet10Mesh, is_folded};
use nalgebra::Point3;

use crate::field::SmoothField;
use crate::params::VariationParams;

/// A mesh of varied thickness.
pub(crate) struct Varied {
    /// The mesh.
    pub(crate) mesh: Tet10Mesh,
    /// Nodes that kept their place because an element at them would have turned inside out.
    pub(crate) n_held_nodes: usize,
}

/// Moves every node below the skin along the skin's normal by the varied fraction of its depth;
/// the skin itself stays. Fades out beyond `max_wall_m`, in depth and sideways of the skin, so
/// that ribs and mounts keep their place. The nodes of an element that would turn inside out keep
/// theirs, too.
///
/// # Errors
/// [`MeshError`] when `mesh` has an element that is inside out.
pub(crate) fn vary_thickness(
    mesh: &Tet10Mesh,
    skin: &SkinRegion,
    params: &VariationParams,
    max_wall_m: f64,
) -> Result<Varied, MeshError> {
    let mut nodes = moved_nodes(mesh, skin, params, max_wall_m);
    let mut held = vec![false; nodes.len()];
    loop {
        let inverted = mesh.elements().iter().filter(|element| {
            let here = element.map(|node| nodes[node.index()]);
            is_folded(&here) && element.iter().any(|node| !held[node.index()])
        });
        let inverted: Vec<[FeNodeId; 10]> = inverted.copied().collect();
        if inverted.is_empty() {
            break;
        }
        for node in inverted.iter().flatten() {
            held[node.index()] = true;
            nodes[node.index()] = mesh.position(*node);
        }
    }
    let n_held_nodes = held.iter().filter(|held| **held).count();
    Ok(Varied { mesh: Tet10Mesh::new(nodes, mesh.elements().to_vec())?, n_held_nodes })
}

fn moved_nodes(
    mesh: &Tet10Mesh,
    skin: &SkinRegion,
    params: &VariationParams,
    max_wall_m: f64,
) -> Vec<Point3<f64>> {
    let skin_points: Vec<Point3<f64>> = skin.nodes.iter().map(|n| mesh.position(*n)).collect();
    let index = PointIndex::new(&skin_points);
    let variation = SmoothField::scaled(params, mesh.nodes());
    let moved = mesh.nodes().iter().zip(&variation).map(|(x, f)| {
        let Some((nearest, _)) = index.nearest(x) else {
            return *x;
        };
        let normal = skin.normals[nearest];
        let offset = x - skin_points[nearest];
        let depth = -offset.dot(&normal);
        let sideways = (offset + depth * normal).norm();
        let weight = fade(depth, max_wall_m) * fade(sideways, max_wall_m);
        if depth <= 0.0 { *x } else { x - *f * weight * depth * normal }
    });
    moved.collect()
}

/// One up to `limit`, falling linearly to zero at twice that.
fn fade(distance: f64, limit: f64) -> f64 {
    (2.0 - distance / limit).clamp(0.0, 1.0)
}
