//! Surfaces for the tests of shell limbs.

use std::path::{Path, PathBuf};

use hapdef_mesh::SurfaceMesh;
use nalgebra::Point3;

/// A file of the bundled limb.
pub fn fixture(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin").join(file)
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

/// A closed tube along z, 60 mm across and 200 mm long, its ends domes.
pub fn bottle() -> SurfaceMesh {
    let (n_around, n_up) = (36, 41);
    let mut vertices = vec![Point3::new(0.0, 0.0, 0.0)];
    for ring in 0..n_up {
        let height = 0.2 * (ring as f64 + 0.5) / n_up as f64;
        let from_end = height.min(0.2 - height);
        let radius = 0.03 * (1.0 - (1.0 - from_end / 0.03).max(0.0).powi(2)).sqrt();
        vertices.extend((0..n_around).map(|i| {
            let angle = std::f64::consts::TAU * i as f64 / n_around as f64;
            Point3::new(radius * angle.cos(), radius * angle.sin(), height)
        }));
    }
    vertices.push(Point3::new(0.0, 0.0, 0.2));
    let at = |ring: usize, i: usize| (1 + ring * n_around + i % n_around) as u32;
    let top = vertices.len() as u32 - 1;
    let mut triangles = Vec::new();
    for i in 0..n_around {
        triangles.push([0, at(0, i + 1), at(0, i)]);
        for ring in 0..n_up - 1 {
            let [a, b, c, d] = [at(ring, i), at(ring, i + 1), at(ring + 1, i + 1), at(ring + 1, i)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        triangles.push([at(n_up - 1, i), at(n_up - 1, i + 1), top]);
    }
    SurfaceMesh::new(vertices, triangles).unwrap()
}
