//! A block of ten-node tetrahedra to time the solver on.

use hapdef_mesh::{FeNodeId, MeshError, TET10_EDGES, Tet10Mesh};
use nalgebra::Point3;

/// Distance of neighbouring nodes, m.
const SPACING_M: f64 = 1e-3;

/// The six orders in which a cube's axes can be walked: the tetrahedra of Kuhn's subdivision.
const WALKS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [1, 2, 0],
    [2, 0, 1],
    [0, 2, 1],
    [2, 1, 0],
    [1, 0, 2],
];

/// A block of `n`³ cubes, each of six tetrahedra; mid-side nodes lie on the lattice of half the
/// cubes' width.
pub(super) fn block(n: usize) -> Result<Tet10Mesh, MeshError> {
    let side = 2 * n + 1;
    let index = |x: [usize; 3]| FeNodeId::from_index(x[0] + side * (x[1] + side * x[2]));
    let at = |i: usize| {
        let lattice = [i % side, i / side % side, i / (side * side)];
        Point3::from(lattice.map(|x| x as f64 * SPACING_M))
    };
    let mut elements = Vec::with_capacity(6 * n.pow(3));
    for cube in 0..n.pow(3) {
        let origin = [cube % n, cube / n % n, cube / (n * n)].map(|x| 2 * x);
        for (i, walk) in WALKS.iter().enumerate() {
            let mut corners = [origin; 4];
            for step in 0..3 {
                corners[step + 1] = corners[step];
                corners[step + 1][walk[step]] += 2;
            }
            if i >= 3 {
                corners.swap(1, 2);
            }
            elements.push(std::array::from_fn(|i| {
                let middle = |[a, b]: [usize; 2]| {
                    std::array::from_fn(|d| (corners[a][d] + corners[b][d]) / 2)
                };
                index(
                    corners
                        .get(i)
                        .copied()
                        .unwrap_or_else(|| middle(TET10_EDGES[i - 4])),
                )
            }));
        }
    }
    Tet10Mesh::new((0..side.pow(3)).map(at).collect(), elements)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_block_is_a_mesh_and_fills_its_volume() {
        let mesh = block(2).unwrap();
        assert_eq!((mesh.nodes().len(), mesh.elements().len()), (125, 48));
        let volume_m3: f64 = (0..48)
            .map(|e| hapdef_mesh::tet10::volume(&mesh.element_positions(e)))
            .sum();
        assert!((volume_m3 / 64e-9 - 1.0).abs() < 1e-12, "{volume_m3}");
    }
}
