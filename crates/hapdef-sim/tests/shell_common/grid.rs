//! Triangulated rectangles mapped into space.

use super::{Mesh, Pattern};
use nalgebra::Point3;

/// A mapped grid of `nu` × `nv` cells; node (i, j) is `j * (nu + 1) + i`.
#[derive(Clone, Debug)]
pub struct Grid {
    pub nodes: Vec<Point3<f64>>,
    pub triangles: Vec<[usize; 3]>,
    pub nu: usize,
    pub nv: usize,
}

impl Grid {
    /// Cells of the unit square, two triangles each, mapped by `map(u, v)`.
    pub fn new(
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
                    Pattern::Distorted => (i * 7 + j * 3) % 5 < 2,
                };
                if up {
                    triangles.extend([[a, b, c], [a, c, d]]);
                } else {
                    triangles.extend([[a, b, d], [b, c, d]]);
                }
            }
        }
        Self {
            nodes,
            triangles,
            nu,
            nv,
        }
    }

    /// The node at grid position (i, j).
    pub fn id(&self, i: usize, j: usize) -> usize {
        j * (self.nu + 1) + i
    }

    /// Nodes at the side `u = 0` or `u = 1`, in order of v.
    pub fn side_u(&self, end: bool) -> Vec<usize> {
        let i = if end { self.nu } else { 0 };
        (0..=self.nv).map(|j| self.id(i, j)).collect()
    }

    /// Nodes at the side `v = 0` or `v = 1`, in order of u.
    pub fn side_v(&self, end: bool) -> Vec<usize> {
        let j = if end { self.nv } else { 0 };
        (0..=self.nu).map(|i| self.id(i, j)).collect()
    }
}

/// `n` times a whole factor, for a mesh.
pub fn cells(mesh: Mesh, factor: usize) -> usize {
    mesh.n * factor
}

/// Parameters of a node; distorted ones wander by 0.18 of a cell, and sides stay straight.
fn place(i: usize, j: usize, nu: usize, nv: usize, pattern: Pattern) -> [f64; 2] {
    let [u, v] = [i as f64 / nu as f64, j as f64 / nv as f64];
    if pattern != Pattern::Distorted {
        return [u, v];
    }
    let (x, y) = (i as f64, j as f64);
    let du = if i == 0 || i == nu {
        0.0
    } else {
        (2.3 * x + 3.1 * y + 0.4).sin()
    };
    let dv = if j == 0 || j == nv {
        0.0
    } else {
        (1.9 * x - 2.7 * y + 1.3).sin()
    };
    // corners' neighbours on a side move along it only
    [u + 0.18 * du / nu as f64, v + 0.18 * dv / nv as f64]
}
