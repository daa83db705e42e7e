//! Triangulated rectangles mapped into space.

use hapdef_mesh::{FaceCurve, SurfaceMesh};
use nalgebra::Point3;

use crate::VerifyError;

/// How a benchmark is meshed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mesh {
    /// Cells along the shortest direction that the case divides.
    pub(super) n: usize,
    /// Where the diagonals run.
    pub(super) pattern: Pattern,
}

/// Where the diagonals run, and whether nodes are moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Pattern {
    /// From a cell's lowest to its highest corner.
    Up,
    /// The other way.
    Down,
    /// Inner nodes moved by up to 0.18 of a cell, diagonals in both ways.
    Moved,
}

impl Pattern {
    /// All of them.
    pub(super) const ALL: [Self; 3] = [Self::Up, Self::Down, Self::Moved];
}

/// A mapped grid of `nu` × `nv` cells; node (i, j) is `j * (nu + 1) + i`.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    pub(super) nodes: Vec<Point3<f64>>,
    pub(super) triangles: Vec<[usize; 3]>,
    pub(super) nu: usize,
    pub(super) nv: usize,
}

impl Grid {
    /// Cells of the unit square, two triangles each, mapped by `map(u, v)`.
    pub(super) fn new(
        nu: usize,
        nv: usize,
        pattern: Pattern,
        map: impl Fn(f64, f64) -> Point3<f64>,
    ) -> Self {
        let mut nodes = Vec::new();
        for j in 0..=nv {
            for i in 0..=nu {
                let [u, v] = place(i, j, nu, nv, pattern);
                nodes.push(map(u, v));
            }
        }
        let id = |i: usize, j: usize| j * (nu + 1) + i;
        let mut triangles = Vec::new();
        for j in 0..nv {
            for i in 0..nu {
                let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
                let up = match pattern {
                    Pattern::Up => true,
                    Pattern::Down => false,
                    Pattern::Moved => (i * 7 + j * 3) % 5 < 2,
                };
                if up {
                    triangles.extend([[a, b, c], [a, c, d]]);
                } else {
                    triangles.extend([[a, b, d], [b, c, d]]);
                }
            }
        }
        Self { nodes, triangles, nu, nv }
    }

    /// The node at grid position (i, j).
    pub(super) fn id(&self, i: usize, j: usize) -> usize {
        j * (self.nu + 1) + i
    }

    /// Nodes at the side `u = 0` or `u = 1`, in order of v.
    pub(super) fn side_u(&self, end: bool) -> Vec<usize> {
        let i = if end { self.nu } else { 0 };
        (0..=self.nv).map(|j| self.id(i, j)).collect()
    }

    /// Nodes at the side `v = 0` or `v = 1`, in order of u.
    pub(super) fn side_v(&self, end: bool) -> Vec<usize> {
        let j = if end { self.nv } else { 0 };
        (0..=self.nu).map(|i| self.id(i, j)).collect()
    }

    /// Nodes on all four sides, each once.
    pub(super) fn sides(&self) -> Vec<usize> {
        let ends = [false, true];
        let mut all: Vec<usize> = ends
            .into_iter()
            .flat_map(|end| [self.side_u(end), self.side_v(end)].concat())
            .collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Each triangle split into four, new nodes where `curve` puts them, and the two old nodes that
    /// each new one stands between.
    pub(super) fn refined(
        &self,
        curve: &FaceCurve<'_>,
    ) -> Result<(Self, Vec<[usize; 2]>), VerifyError> {
        let triangles = self.triangles.iter().map(|t| t.map(|node| node as u32));
        let fine = SurfaceMesh::new(self.nodes.clone(), triangles.collect())?.refined(curve)?;
        let triangles = fine.mesh.triangles().iter();
        let grid = Self {
            nodes: fine.mesh.vertices().to_vec(),
            triangles: triangles.map(|t| t.map(|node| node as usize)).collect(),
            nu: 0,
            nv: 0,
        };
        let halved = fine.halved_edges.iter();
        let halved = halved.map(|ends| ends.map(|node| node as usize));
        Ok((grid, halved.collect()))
    }

    /// The cells in words.
    pub(super) fn cells(&self) -> String {
        format!("{} × {} cells", self.nu, self.nv)
    }
}

/// Parameters of a node; moved ones wander by 0.18 of a cell, and sides stay straight.
fn place(i: usize, j: usize, nu: usize, nv: usize, pattern: Pattern) -> [f64; 2] {
    let [u, v] = [i as f64 / nu as f64, j as f64 / nv as f64];
    if pattern != Pattern::Moved {
        return [u, v];
    }
    let (x, y) = (i as f64, j as f64);
    // nodes on a side move along it only
    let du = if i == 0 || i == nu { 0.0 } else { (2.3 * x + 3.1 * y + 0.4).sin() };
    let dv = if j == 0 || j == nv { 0.0 } else { (1.9 * x - 2.7 * y + 1.3).sin() };
    [u + 0.18 * du / nu as f64, v + 0.18 * dv / nv as f64]
}
