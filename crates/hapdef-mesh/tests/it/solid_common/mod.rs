//! Solid meshes for tests.
#![allow(dead_code, reason = "each test file uses a part")]

use std::f64::consts::TAU;

use hapdef_mesh::{Tet10Mesh, kuhn_tube};
use nalgebra::Point3;

/// A tube about the y axis: `n` cells around, along and through the wall.
pub fn tube(n: [usize; 3], radii_m: [f64; 2], height_m: f64) -> Tet10Mesh {
    kuhn_tube(n, |at| {
        let radius_m = radii_m[1] + (radii_m[0] - radii_m[1]) * at.z;
        let (sin, cos) = (TAU * at.x).sin_cos();
        Point3::new(radius_m * cos, height_m * at.y, radius_m * sin)
    })
    .unwrap()
}
