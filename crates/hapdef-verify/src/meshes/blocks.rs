//! Mapped grids of ten-node tetrahedra, joined where they touch.

use std::collections::BTreeMap;

use hapdef_mesh::{FeNodeId, TET10_EDGES, Tet10Mesh, kuhn_cell};
use nalgebra::Point3;

use crate::VerifyError;

/// A mesh under construction: one mapped grid after another.
///
/// Each cell becomes six tetrahedra around its diagonal (Kuhn). Mid-side nodes lie on the mapped
/// middle of their edge, so that curved maps give curved faces. Nodes closer than [`TOLERANCE`]
/// are one. Face diagonals run from a cell's lowest to its highest corner: blocks that share a
/// face must count it in the same two directions, or both mirrored.
#[derive(Debug, Default)]
pub(crate) struct Blocks {
    nodes: Vec<Point3<f64>>,
    elements: Vec<[FeNodeId; 10]>,
    near: BTreeMap<[i64; 3], Vec<FeNodeId>>,
}

/// Nodes that are closer are one.
const TOLERANCE: f64 = 1e-7;

/// The octant x, y, z ≥ 0 of a hollow sphere, inner radius 1, outer 2, `n` cells through the wall:
/// concentric cubes blown up to spheres.
///
/// The cube's Kuhn cells have no tetrahedron across the planes x = y, y = z, z = x, where the map
/// has a kink.
pub(crate) fn hollow_octant(n: usize) -> Result<Tet10Mesh, VerifyError> {
    let in_wall = |cell: [usize; 3]| cell.iter().any(|&c| c >= n);
    let onto_spheres = |p: Point3<f64>| {
        let cube = p.coords * 2.0;
        Point3::from(cube * (cube.amax() / cube.norm()))
    };
    Blocks::default().block_of([2 * n; 3], in_wall, onto_spheres).finish()
}

/// The mesh with its corner nodes moved and its mid-side nodes halfway.
pub(crate) fn moved(
    mesh: &Tet10Mesh,
    map: impl Fn(FeNodeId, Point3<f64>) -> Point3<f64>,
) -> Result<Tet10Mesh, VerifyError> {
    let mut nodes = mesh.nodes().to_vec();
    for &corner in mesh.elements().iter().flat_map(|e| &e[..4]) {
        nodes[corner.index()] = map(corner, mesh.position(corner));
    }
    for element in mesh.elements() {
        for (i, [a, b]) in TET10_EDGES.into_iter().enumerate() {
            let (a, b) = (nodes[element[a].index()], nodes[element[b].index()]);
            nodes[element[4 + i].index()] = nalgebra::center(&a, &b);
        }
    }
    Ok(Tet10Mesh::new(nodes, mesh.elements().to_vec())?)
}

/// The nodes of a straight-sided tetrahedron.
pub(crate) fn straight(corners: [[f64; 3]; 4]) -> [Point3<f64>; 10] {
    let corners = corners.map(Point3::from);
    std::array::from_fn(|i| match i {
        0..4 => corners[i],
        _ => nalgebra::center(&corners[TET10_EDGES[i - 4][0]], &corners[TET10_EDGES[i - 4][1]]),
    })
}

impl Blocks {
    /// A grid of `n` cells over the unit cube, moved by `map`.
    pub(crate) fn block(self, n: [usize; 3], map: impl Fn(Point3<f64>) -> Point3<f64>) -> Self {
        self.block_of(n, |_| true, map)
    }

    /// The cells of [`Self::block`] whose index satisfies `keep`.
    pub(crate) fn block_of(
        mut self,
        n: [usize; 3],
        keep: impl Fn([usize; 3]) -> bool,
        map: impl Fn(Point3<f64>) -> Point3<f64>,
    ) -> Self {
        // points on a grid of half cells
        let mut ids: BTreeMap<[usize; 3], FeNodeId> = BTreeMap::new();
        for number in 0..n[0] * n[1] * n[2] {
            let cell = [number % n[0], number / n[0] % n[1], number / n[0] / n[1]];
            if !keep(cell) {
                continue;
            }
            for points in kuhn_cell(cell) {
                let element = points.map(|at| {
                    *ids.entry(at).or_insert_with(|| {
                        let x = |c: usize| at[c] as f64 / (2 * n[c]) as f64;
                        self.node(map(Point3::new(x(0), x(1), x(2))))
                    })
                });
                self.add(element);
            }
        }
        self
    }

    /// The mesh of all blocks.
    pub(crate) fn finish(self) -> Result<Tet10Mesh, VerifyError> {
        Ok(Tet10Mesh::new(self.nodes, self.elements)?)
    }

    /// The node at `p`, an old one if there is one.
    fn node(&mut self, p: Point3<f64>) -> FeNodeId {
        let bin = p.coords.map(|c| (c / (4.0 * TOLERANCE)).round() as i64);
        for offset in 0..27_i64 {
            let beside = [offset % 3 - 1, offset / 3 % 3 - 1, offset / 9 - 1];
            let at: [i64; 3] = std::array::from_fn(|c| bin[c] + beside[c]);
            let found = self.near.get(&at).and_then(|ids| {
                let close = |id: &&FeNodeId| (self.nodes[id.index()] - p).norm() < TOLERANCE;
                ids.iter().find(close)
            });
            if let Some(&id) = found {
                return id;
            }
        }
        let id = FeNodeId::from_index(self.nodes.len());
        self.nodes.push(p);
        self.near.entry(bin.into()).or_default().push(id);
        id
    }

    /// Adds an element, turned to a positive corner volume; one that the map has collapsed to a
    /// face is left out.
    fn add(&mut self, mut element: [FeNodeId; 10]) {
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| element[i]);
        if [b, c, d].contains(&a) || [c, d].contains(&b) || c == d {
            return;
        }
        let [a, b, c, d] = [a, b, c, d].map(|id| self.nodes[id.index()]);
        if (b - a).cross(&(c - a)).dot(&(d - a)) < 0.0 {
            for (i, j) in [(1, 2), (4, 6), (8, 9)] {
                element.swap(i, j);
            }
        }
        self.elements.push(element);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hapdef_mesh::tet10;

    fn volume(mesh: &Tet10Mesh) -> f64 {
        let elements = 0..mesh.elements().len();
        elements.map(|e| tet10::volume(&mesh.element_positions(e))).sum()
    }

    #[test]
    fn mirrored_blocks_join_and_fill_their_volume() {
        let mesh = Blocks::default()
            .block([2, 3, 1], |p| p)
            .block([2, 3, 1], |p| Point3::new(-p.x, p.y, p.z))
            .finish()
            .unwrap();
        assert_eq!(mesh.nodes().len(), 9 * 7 * 3);
        assert_eq!(mesh.elements().len(), 72);
        assert!((volume(&mesh) - 2.0).abs() < 1e-14);
    }

    #[test]
    fn a_curved_map_has_curved_faces() {
        let quarter = |p: Point3<f64>| {
            let (r, phi) = (1.0 + p.x, p.y * std::f64::consts::FRAC_PI_2);
            Point3::new(r * phi.cos(), r * phi.sin(), p.z)
        };
        let error = |n: usize| {
            let mesh = Blocks::default().block([1, n, 1], quarter).finish().unwrap();
            (volume(&mesh) - 0.75 * std::f64::consts::PI).abs()
        };
        // quadratic edges on a circle: the area is off by h⁴
        let order = (error(4) / error(8)).log2();
        assert!(order > 3.8, "order {order}");
    }
}
