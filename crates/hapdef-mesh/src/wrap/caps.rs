//! Openings closed by fans.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Point3;

use crate::surface::topology::sorted_half_edges;
use crate::{MeshError, SurfaceMesh};

/// The surface with a fan from the middle of each loop of open edges, and the number of loops. The
/// fans face either way.
pub(super) fn capped(mesh: &SurfaceMesh) -> Result<(SurfaceMesh, usize), MeshError> {
    let loops = open_loops(mesh);
    let mut vertices = mesh.vertices().to_vec();
    let mut triangles = mesh.triangles().to_vec();
    for rim in &loops {
        let sum = rim
            .iter()
            .fold(nalgebra::Vector3::zeros(), |sum, &v| sum + vertices[v as usize].coords);
        let middle = vertices.len() as u32;
        vertices.push(Point3::from(sum / rim.len() as f64));
        let next = rim.iter().cycle().skip(1);
        triangles.extend(rim.iter().zip(next).map(|(&a, &b)| [a, b, middle]));
    }
    Ok((SurfaceMesh::new(vertices, triangles)?, loops.len()))
}

/// Chains of open edges, each edge in one; one that does not return to its start counts as a loop.
fn open_loops(mesh: &SurfaceMesh) -> Vec<Vec<u32>> {
    let mut left: BTreeSet<(u32, u32)> = sorted_half_edges(mesh.triangles())
        .chunk_by(|a, b| a.ends() == b.ends())
        .filter(|uses| uses.len() == 1)
        .map(|uses| uses[0].ends())
        .collect();
    let mut around: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for &(a, b) in &left {
        around.entry(a).or_default().push(b);
        around.entry(b).or_default().push(a);
    }
    let mut loops = Vec::new();
    while let Some((first, second)) = left.pop_first() {
        let mut rim = vec![first, second];
        let mut last = second;
        while last != first {
            let next = around[&last].iter().find(|&&v| left.remove(&(last.min(v), last.max(v))));
            let Some(&next) = next else { break };
            rim.push(next);
            last = next;
        }
        if last == first {
            rim.pop();
        }
        loops.push(rim);
    }
    loops
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::topology::Edges;
    use crate::surface::triangles::tests::cuboid;

    #[test]
    fn two_openings_of_a_box_are_closed() {
        let full = cuboid(0.1, 0.2, 0.3);
        // Without its two ends, two triangles each.
        let open = full.with_triangles(full.triangles()[4..].to_vec());
        let (closed, n) = capped(&open).unwrap();
        assert_eq!(n, 2);
        let edges = Edges::of(closed.triangles());
        assert_eq!((edges.n_open, edges.n_non_manifold), (0, 0));
        assert!((closed.area_m2() - full.area_m2()).abs() < 1e-12);
        assert_eq!(capped(&full).unwrap(), (full, 0));
    }
}
