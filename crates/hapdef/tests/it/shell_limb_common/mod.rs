//! Surfaces for the tests of shell limbs.

use std::path::{Path, PathBuf};

use hapdef_mesh::{GltfParams, SurfaceMesh, read_gltf};
use nalgebra::Point3;

/// A file of the bundled limb.
pub fn fixture(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin").join(file)
}

/// A surface in metres.
pub fn surface(path: &Path) -> SurfaceMesh {
    read_gltf(path, &GltfParams::default()).unwrap().mesh
}

/// A tube 50 mm across with a wall of 1 mm, closed at its rims.
pub fn tube(length_m: f64) -> SurfaceMesh {
    let (n_around, n_along) = (48_u32, 20_u32);
    let ring = |radius: f64, i: u32| {
        let y = length_m * f64::from(i) / f64::from(n_along);
        (0..n_around).map(move |k| {
            let angle = std::f64::consts::TAU * f64::from(k) / f64::from(n_around);
            Point3::new(radius * angle.cos(), y, -radius * angle.sin())
        })
    };
    let walls = [0.025, 0.024].map(|radius| (0..=n_along).flat_map(move |i| ring(radius, i)));
    let vertices = walls.into_iter().flatten().collect();
    let at = |wall: u32, i: u32, k: u32| (wall * (n_along + 1) + i) * n_around + k % n_around;
    let mut triangles = Vec::new();
    let mut quad = |[a, b, c, d]: [u32; 4]| triangles.extend([[a, b, c], [a, c, d]]);
    for k in 0..n_around {
        for i in 0..n_along {
            quad([at(0, i, k), at(0, i, k + 1), at(0, i + 1, k + 1), at(0, i + 1, k)]);
            quad([at(1, i, k), at(1, i + 1, k), at(1, i + 1, k + 1), at(1, i, k + 1)]);
        }
        quad([at(0, 0, k), at(1, 0, k), at(1, 0, k + 1), at(0, 0, k + 1)]);
        let top = n_along;
        quad([at(0, top, k), at(0, top, k + 1), at(1, top, k + 1), at(1, top, k)]);
    }
    SurfaceMesh::new(vertices, triangles).unwrap()
}
