//! Curved shells.

use super::grid::Grid;
use super::problem::Problem;
use super::{CaseResult, Mesh};
use hapdef_sim::ShellKind;
use nalgebra::{Point3, Vector3};
use std::f64::consts::{FRAC_PI_2, PI};

/// The Scordelis–Lo roof (MacNeal and Harder 1985): radius 25, length 50, thickness 0.25, 40°,
/// E = 4.32e8, ν = 0, 90 per area; deflection at the middle of the free edge.
pub fn scordelis_lo(kind: ShellKind, mesh: Mesh) -> CaseResult {
    let grid = Grid::new(mesh.n, mesh.n, mesh.pattern, |u, v| {
        let a = u * 40.0 / 180.0 * PI;
        Point3::new(25.0 * a.sin(), 25.0 * v, 25.0 * a.cos())
    });
    let mut p = Problem::new(&grid, 0.25, 4.32e8, 0.0);
    p.mirror(&grid.side_u(false), 0);
    p.mirror(&grid.side_v(false), 1);
    p.fix(&grid.side_v(true), &[0, 2]);
    p.area_force(Vector3::new(0.0, 0.0, -90.0));
    let s = p.solve(kind);
    let value = -s.displacement[grid.id(mesh.n, 0)][2];
    CaseResult {
        value,
        reference: 0.3024,
        n_nodes: s.n_nodes,
    }
}

/// The pinched cylinder with end diaphragms (Belytschko et al. 1985): radius 300, length 600,
/// thickness 3, E = 3e6, ν = 0.3, unit forces; an eighth.
pub fn pinched_cylinder(kind: ShellKind, mesh: Mesh) -> CaseResult {
    let grid = Grid::new(mesh.n, mesh.n, mesh.pattern, |u, v| {
        let a = u * FRAC_PI_2;
        Point3::new(300.0 * a.sin(), 300.0 * v, 300.0 * a.cos())
    });
    let mut p = Problem::new(&grid, 3.0, 3e6, 0.3);
    p.mirror(&grid.side_u(false), 0);
    p.mirror(&grid.side_u(true), 2);
    p.mirror(&grid.side_v(false), 1);
    p.fix(&grid.side_v(true), &[0, 2]);
    p.force(0, 2, -0.25);
    let s = p.solve(kind);
    CaseResult {
        value: -s.displacement[0][2],
        reference: 1.8248e-5,
        n_nodes: s.n_nodes,
    }
}

/// The hemisphere with an 18° hole (MacNeal and Harder 1985): radius 10, thickness 0.04,
/// E = 6.825e7, ν = 0.3, unit forces on a quarter; 0.0940 in the source, 0.0924–0.0930 refined.
pub fn hemisphere(kind: ShellKind, mesh: Mesh) -> CaseResult {
    let grid = Grid::new(mesh.n, mesh.n, mesh.pattern, |u, v| {
        let (a, b) = (u * FRAC_PI_2, v * 72.0 / 180.0 * PI);
        Point3::new(
            10.0 * a.cos() * b.cos(),
            10.0 * a.sin() * b.cos(),
            10.0 * b.sin(),
        )
    });
    let mut p = Problem::new(&grid, 0.04, 6.825e7, 0.3);
    p.mirror(&grid.side_u(false), 1);
    p.mirror(&grid.side_u(true), 0);
    let (a, b) = (grid.id(0, 0), grid.id(mesh.n, 0));
    p.fix(&[a], &[2]);
    p.force(a, 0, 1.0);
    p.force(b, 1, -1.0);
    let s = p.solve(kind);
    CaseResult {
        value: s.displacement[a][0],
        reference: 0.093,
        n_nodes: s.n_nodes,
    }
}

/// NAFEMS LE3 (1990): a closed hemisphere, radius 10 m, thickness 0.04 m, E = 68.25 GPa, ν = 0.3,
/// 2 kN pairs; a quarter, its pole held along z. Three patches of n × n cells.
pub fn nafems_le3(kind: ShellKind, mesh: Mesh) -> CaseResult {
    // two patches would meet at a pole: here the octant is a triangle grid of n rows
    let n = 2 * mesh.n;
    let id = |i: usize, j: usize| {
        // row i from the pole has i + 1 nodes
        i * (i + 1) / 2 + j
    };
    let mut nodes = Vec::new();
    for i in 0..=n {
        for j in 0..=i {
            let polar = i as f64 / n as f64 * FRAC_PI_2;
            let a = if i == 0 {
                0.0
            } else {
                j as f64 / i as f64 * FRAC_PI_2
            };
            nodes.push(Point3::new(
                10.0 * polar.sin() * a.cos(),
                10.0 * polar.sin() * a.sin(),
                10.0 * polar.cos(),
            ));
        }
    }
    let mut triangles = Vec::new();
    for i in 0..n {
        for j in 0..=i {
            triangles.push([id(i, j), id(i + 1, j), id(i + 1, j + 1)]);
            if j < i {
                triangles.push([id(i, j), id(i + 1, j + 1), id(i, j + 1)]);
            }
        }
    }
    let grid = Grid {
        nodes,
        triangles,
        nu: 0,
        nv: 0,
    };
    let mut p = Problem::new(&grid, 0.04, 68.25e9, 0.3);
    let first: Vec<usize> = (0..=n).map(|i| id(i, 0)).collect();
    let last: Vec<usize> = (0..=n).map(|i| id(i, i)).collect();
    p.mirror(&first, 1);
    p.mirror(&last, 0);
    p.fix(&[0], &[2]);
    p.force(id(n, 0), 0, 2000.0);
    p.force(id(n, n), 1, -2000.0);
    let s = p.solve(kind);
    CaseResult {
        value: s.displacement[id(n, 0)][0],
        reference: 0.185,
        n_nodes: s.n_nodes,
    }
}

/// The hyperbolic paraboloid z = x² − y² of Chapelle and Bathe (1998), clamped at x = −½ under a
/// weight of 8000 Pa per unit thickness; E = 2e11, ν = 0.3. Half of it by symmetry; `value` is
/// the deflection at (½, 0) and the second figure the energy of the whole, J. The strip of 6 √t at
/// the clamped side has half the cells.
pub fn hypar(kind: ShellKind, mesh: Mesh, thickness: f64) -> (f64, f64) {
    let layer = (6.0 * thickness.sqrt()).min(0.5);
    let grid = Grid::new(2 * mesh.n, mesh.n, mesh.pattern, |u, v| {
        let s = if u < 0.5 {
            2.0 * u * layer
        } else {
            layer + (2.0 * u - 1.0) * (1.0 - layer)
        };
        let (x, y) = (s - 0.5, 0.5 * v);
        Point3::new(x, y, x * x - y * y)
    });
    let mut p = Problem::new(&grid, thickness, 2e11, 0.3);
    p.clamp(&grid.side_u(false));
    p.mirror(&grid.side_v(false), 1);
    p.area_force(Vector3::new(0.0, 0.0, -8000.0 * thickness));
    let s = p.solve(kind);
    (s.displacement[grid.id(2 * mesh.n, 0)][2], 2.0 * s.energy_j)
}
