//! Triangle surfaces of known measures.
#![allow(dead_code, reason = "each test file uses a part")]

use std::f64::consts::TAU;

use hapdef_mesh::{FaceCurve, SurfaceMesh};
use nalgebra::{Matrix4, Point3, Vector3};

/// The cube with one corner at the origin.
pub fn cube(edge_m: f64) -> SurfaceMesh {
    let corner = |i: u32| Point3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
    let quads: [[u32; 4]; 6] =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let unit = SurfaceMesh::new((0..8).map(corner).collect(), triangles).unwrap();
    unit.scaled(edge_m).unwrap()
}

/// The sphere about the origin: an octahedron refined `n` times, 8 · 4ⁿ triangles.
pub fn sphere(radius_m: f64, n: usize) -> SurfaceMesh {
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    let vertices = axes.iter().flat_map(|a| [Point3::from(*a), Point3::from(-*a)]).collect();
    let mut triangles = Vec::new();
    for i in 0..8_u32 {
        let [a, b, c] = [i & 1, 2 + (i >> 1 & 1), 4 + (i >> 2)];
        let is_even = i.count_ones().is_multiple_of(2);
        triangles.push(if is_even { [a, b, c] } else { [a, c, b] });
    }
    let mut mesh = SurfaceMesh::new(vertices, triangles).unwrap();
    let onto = |p: &Point3<f64>| Point3::from(p.coords / p.coords.norm());
    for _ in 0..n {
        mesh = mesh.refined(&FaceCurve::Onto(&onto)).unwrap().mesh;
    }
    mesh.scaled(radius_m).unwrap()
}

/// The solid swept by a closed profile of (radius, z) about the z axis, in `n` steps; the profile
/// runs counter-clockwise in the (radius, z) plane.
pub fn revolved(profile: &[[f64; 2]], n: u32) -> SurfaceMesh {
    let m = profile.len() as u32;
    let vertex = |k: u32| {
        let [radius, z] = profile[(k % m) as usize];
        let (sin, cos) = (TAU * f64::from(k / m) / f64::from(n)).sin_cos();
        Point3::new(radius * cos, radius * sin, z)
    };
    let at = |i: u32, j: u32| (i % n) * m + j % m;
    let quad = |k: u32| {
        let (i, j) = (k / m, k % m);
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    let triangles = (0..n * m).flat_map(quad).collect();
    SurfaceMesh::new((0..n * m).map(vertex).collect(), triangles).unwrap()
}

/// A tube with open ends, its wall a solid: radii inside and outside, height, cells along.
pub fn tube(radii_m: [f64; 2], height_m: f64, along: usize, around: u32) -> SurfaceMesh {
    let z = |i: usize| height_m * i as f64 / along as f64;
    let up = (0..=along).map(|i| [radii_m[1], z(i)]);
    let down = (0..=along).rev().map(|i| [radii_m[0], z(i)]);
    revolved(&up.chain(down).collect::<Vec<_>>(), around)
}

/// The torus with `m` cells around its tube and `n` along.
pub fn torus(ring_m: f64, tube_m: f64, m: usize, n: u32) -> SurfaceMesh {
    let point = |j: usize| {
        let (sin, cos) = (TAU * j as f64 / m as f64).sin_cos();
        [ring_m + tube_m * cos, tube_m * sin]
    };
    revolved(&(0..m).map(point).collect::<Vec<_>>(), n)
}

/// The surface facing the other way.
pub fn turned(mesh: &SurfaceMesh) -> SurfaceMesh {
    let triangles = mesh.triangles().iter().map(|&[a, b, c]| [a, c, b]).collect();
    SurfaceMesh::new(mesh.vertices().to_vec(), triangles).unwrap()
}

/// Both surfaces as one.
pub fn joined(a: &SurfaceMesh, b: &SurfaceMesh) -> SurfaceMesh {
    let n = a.vertices().len() as u32;
    let moved = b.triangles().iter().map(|t| t.map(|v| v + n));
    let triangles = a.triangles().iter().copied().chain(moved).collect();
    SurfaceMesh::new([a.vertices(), b.vertices()].concat(), triangles).unwrap()
}

pub fn shifted(mesh: &SurfaceMesh, by: Vector3<f64>) -> SurfaceMesh {
    mesh.transformed(&Matrix4::new_translation(&by)).unwrap()
}

/// The surface with other triangles.
pub fn with_triangles(mesh: &SurfaceMesh, triangles: Vec<[u32; 3]>) -> SurfaceMesh {
    SurfaceMesh::new(mesh.vertices().to_vec(), triangles).unwrap()
}

/// 4/3 π (R³ − r³).
pub fn ball_m3(outer_m: f64, inner_m: f64) -> f64 {
    4.0 / 3.0 * std::f64::consts::PI * (outer_m.powi(3) - inner_m.powi(3))
}
