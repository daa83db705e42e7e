//! Cells cut into six ten-node tetrahedra each, and grids of them.

use nalgebra::Point3;

use crate::{FeNodeId, MeshError, TET10_EDGES, Tet10Mesh};

/// The orders in which a cell's axes can be walked from its lowest to its highest corner; the last
/// three turn the other way.
const WALKS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];

impl Tet10Mesh {
    /// A block from the origin to `size_m`, of `n` cells along each axis, six elements a cell.
    ///
    /// # Errors
    /// [`MeshError::Solid`] if there is no cell, or a side is not above zero.
    pub fn block(size_m: [f64; 3], n: [usize; 3]) -> Result<Self, MeshError> {
        let [x, y, z] = size_m;
        kuhn_block(n, |p| Point3::new(p.x * x, p.y * y, p.z * z))
    }
}

/// The nodes of the six tetrahedra around the diagonal of `cell` (Kuhn, IBM Journal of Research
/// and Development 4(5), 1960), in half cells: the cell's lowest corner is node 2 · `cell`.
///
/// Nodes in the order of a [`Tet10Mesh`], volumes positive where the axes are right-handed. Cells
/// side by side fit each other.
#[must_use]
pub fn kuhn_cell(cell: [usize; 3]) -> [[[usize; 3]; 10]; 6] {
    std::array::from_fn(|walk| {
        let mut corners = [cell.map(|i| 2 * i); 4];
        for step in 0..3 {
            corners[step + 1] = corners[step];
            corners[step + 1][WALKS[walk][step]] += 2;
        }
        if walk >= 3 {
            corners.swap(1, 2);
        }
        let middle =
            |[a, b]: [usize; 2]| std::array::from_fn(|d| (corners[a][d] + corners[b][d]) / 2);
        std::array::from_fn(|i| match i {
            0..4 => corners[i],
            _ => middle(TET10_EDGES[i - 4]),
        })
    })
}

/// A grid of `n` cells over the unit cube, every node moved by `map`, each cell cut as in
/// [`kuhn_cell`]; nodes `[(2 n[0] + 1) (2 n[1] + 1) (2 n[2] + 1)]`, the first axis fastest.
///
/// # Errors
/// [`MeshError::Solid`] if there is no cell or `map` turns one inside out.
pub fn kuhn_block(
    n: [usize; 3],
    map: impl Fn(Point3<f64>) -> Point3<f64>,
) -> Result<Tet10Mesh, MeshError> {
    grid(n, 2 * n[0] + 1, map)
}

/// The same closed along the first axis, whose end is its beginning: `map` makes a ring of it;
/// nodes `[2 n[0] (2 n[1] + 1) (2 n[2] + 1)]`.
///
/// # Errors
/// As [`kuhn_block`].
pub fn kuhn_tube(
    n: [usize; 3],
    map: impl Fn(Point3<f64>) -> Point3<f64>,
) -> Result<Tet10Mesh, MeshError> {
    grid(n, 2 * n[0], map)
}

/// A grid with so many nodes along its first axis.
fn grid(
    n: [usize; 3],
    n_first: usize,
    map: impl Fn(Point3<f64>) -> Point3<f64>,
) -> Result<Tet10Mesh, MeshError> {
    let (n_second, n_third) = (2 * n[1] + 1, 2 * n[2] + 1);
    let id =
        |[i, j, k]: [usize; 3]| FeNodeId::from_index(i % n_first + n_first * (j + n_second * k));
    let position = |node: usize| {
        let at = [node % n_first, node / n_first % n_second, node / (n_first * n_second)];
        map(std::array::from_fn(|d| at[d] as f64 / (2 * n[d]) as f64).into())
    };
    let cells = (0..n.iter().product::<usize>())
        .map(|cell| [cell % n[0], cell / n[0] % n[1], cell / (n[0] * n[1])]);
    let elements = cells.flat_map(kuhn_cell).map(|nodes| nodes.map(id));
    let nodes = (0..n_first * n_second * n_third).map(position);
    Tet10Mesh::new(nodes.collect(), elements.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid::tet10;

    #[test]
    fn a_block_uses_every_node_and_fills_its_volume() {
        let mesh = kuhn_block([3, 2, 1], |p| Point3::new(p.x, 2.0 * p.y, 3.0 * p.z)).unwrap();
        assert_eq!((mesh.nodes().len(), mesh.elements().len()), (7 * 5 * 3, 36));
        let volumes = (0..36).map(|e| tet10::volume(&mesh.element_positions(e)));
        for volume_m3 in volumes {
            assert!((volume_m3 - 1.0 / 6.0).abs() < 1e-14, "{volume_m3}");
        }
        assert_eq!(mesh.boundary().faces.len(), 2 * 2 * (6 + 3 + 2));
    }

    #[test]
    fn a_tube_is_closed() {
        let mesh = kuhn_tube([12, 3, 1], |p| {
            let (sin, cos) = (std::f64::consts::TAU * p.x).sin_cos();
            Point3::new((1.0 + 0.2 * p.z) * cos, (1.0 + 0.2 * p.z) * sin, p.y)
        })
        .unwrap();
        assert_eq!(mesh.nodes().len(), 24 * 7 * 3);
        assert_eq!(
            mesh.boundary().faces.len(),
            2 * 12 * 3 * 2 + 2 * 12 * 2,
            "inside and outside, and two rims"
        );
    }

    #[test]
    fn a_mirrored_or_an_empty_block_is_refused() {
        assert!(kuhn_block([1; 3], |p| Point3::new(-p.x, p.y, p.z)).is_err());
        assert!(kuhn_block([2, 0, 1], |p| p).is_err());
    }
}
