//! Triangulated rectangles mapped into space.

use hapdef_mesh::{FaceCurve, FeNodeId, SurfaceMesh};
use hapdef_sim::ShellMesh;
use nalgebra::Point3;

use super::{Body, BodyMesh};
use crate::VerifyError;

/// Where the diagonals run, and whether nodes are moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Pattern {
    /// From a cell's lowest to its highest corner.
    Up,
    /// The other way.
    Down,
    /// Inner nodes moved by up to 0.18 of a cell, diagonals in both ways.
    Moved,
}

impl Pattern {
    /// All of them.
    pub(crate) const ALL: &[Self] = &[Self::Up, Self::Down, Self::Moved];
}

/// Triangles, which may be those of cells.
#[derive(Clone, Debug, Default)]
pub(crate) struct Triangles {
    pub(crate) nodes: Vec<Point3<f64>>,
    pub(crate) corners: Vec<[usize; 3]>,
    /// Cells of a grid, where node (i, j) is `j * (n[0] + 1) + i`.
    pub(crate) n: [usize; 3],
}

/// `n` cells of the unit square, two triangles each, mapped by `map`.
pub(crate) fn grid(
    n: [usize; 3],
    pattern: Pattern,
    map: impl Fn(Point3<f64>) -> Point3<f64>,
) -> Triangles {
    let [nu, nv, _] = n;
    let nodes = (0..=nv).flat_map(|j| (0..=nu).map(move |i| place(i, j, nu, nv, pattern)));
    let id = |i: usize, j: usize| j * (nu + 1) + i;
    let mut corners = Vec::new();
    for j in 0..nv {
        for i in 0..nu {
            let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
            let up = match pattern {
                Pattern::Up => true,
                Pattern::Down => false,
                Pattern::Moved => (i * 7 + j * 3) % 5 < 2,
            };
            corners.extend(if up { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
        }
    }
    Triangles { nodes: nodes.map(map).collect(), corners, n }
}

impl Triangles {
    /// The body of uniform thickness.
    pub(crate) fn body(self, thickness: f64) -> Result<Body, VerifyError> {
        let Self { nodes, corners, n } = self;
        let corners = corners.into_iter().map(|t| t.map(FeNodeId::from_index)).collect();
        let thickness = vec![thickness; nodes.len()];
        let mesh = BodyMesh::Shell(ShellMesh::new(nodes, corners, thickness)?);
        let words = format!("{} × {} cells", n[0], n[1]);
        Ok(Body { mesh, n, words, h: 1.0 / n[0].max(1) as f64 })
    }

    /// Each triangle split into four, new nodes where `curve` puts them, and the two old nodes that
    /// each new one stands between.
    pub(crate) fn refined(
        &self,
        curve: &FaceCurve<'_>,
    ) -> Result<(Self, Vec<[usize; 2]>), VerifyError> {
        let corners = self.corners.iter().map(|t| t.map(|node| node as u32));
        let fine = SurfaceMesh::new(self.nodes.clone(), corners.collect())?.refined(curve)?;
        let corners = fine.mesh.triangles().iter().map(|t| t.map(|node| node as usize));
        let triangles =
            Self { nodes: fine.mesh.vertices().to_vec(), corners: corners.collect(), n: self.n };
        let halved = fine.halved_edges.iter().map(|ends| ends.map(|node| node as usize));
        Ok((triangles, halved.collect()))
    }
}

/// Parameters of a node; moved ones wander by 0.18 of a cell, and sides stay straight.
fn place(i: usize, j: usize, nu: usize, nv: usize, pattern: Pattern) -> Point3<f64> {
    let [u, v] = [i as f64 / nu as f64, j as f64 / nv as f64];
    if pattern != Pattern::Moved {
        return Point3::new(u, v, 0.0);
    }
    let (x, y) = (i as f64, j as f64);
    // nodes on a side move along it only
    let du = if i == 0 || i == nu { 0.0 } else { (2.3 * x + 3.1 * y + 0.4).sin() };
    let dv = if j == 0 || j == nv { 0.0 } else { (1.9 * x - 2.7 * y + 1.3).sin() };
    Point3::new(u + 0.18 * du / nu as f64, v + 0.18 * dv / nv as f64, 0.0)
}
