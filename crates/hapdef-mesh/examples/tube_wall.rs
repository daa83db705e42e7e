//! A skin, what is right or wrong with it, and the solid wall behind it: a tube of 48 × 12 squares.
//!
//! `cargo run --release --example tube_wall`
//!
//! ```text
//! triangles → SurfaceMesh → QualityReport
//!                  └──────→ extrude (1 mm inward) → ten-node tetrahedra
//! ```
#![allow(clippy::print_stdout, reason = "an example shows what it does")]

use std::f64::consts::TAU;

use hapdef_mesh::{
    ExtrudeParams, Extrusion, FaceCurve, MeshError, QualityReport, SkinSide, SurfaceMesh, extrude,
};
use nalgebra::Point3;

const RADIUS_M: f64 = 0.035;
const LENGTH_M: f64 = 0.1;
const WALL_M: f64 = 1e-3;
const N_AROUND: u32 = 48;
const N_ALONG: u32 = 12;

fn main() -> Result<(), MeshError> {
    let (quality, wall) = tube_wall()?;
    println!("{quality}");
    println!("wall: {} tetrahedra, {:.3} cm³", wall.mesh.elements().len(), wall.volume_m3 * 1e6);
    Ok(())
}

fn tube_wall() -> Result<(QualityReport, Extrusion), MeshError> {
    let skin = tube()?;
    let params = ExtrudeParams {
        side: SkinSide::Outer,
        n_layers: 2,
        curve: FaceCurve::Onto(&|p| on_the_tube(p)),
    };
    let wall = extrude(&skin, &vec![WALL_M; skin.vertices().len()], &params)?;
    Ok((QualityReport::of(&skin), wall))
}

fn tube() -> Result<SurfaceMesh, MeshError> {
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    for j in 0..=N_ALONG {
        for i in 0..N_AROUND {
            let (sin, cos) = (TAU * f64::from(i) / f64::from(N_AROUND)).sin_cos();
            let z = LENGTH_M * f64::from(j) / f64::from(N_ALONG);
            vertices.push(Point3::new(RADIUS_M * cos, RADIUS_M * sin, z));
        }
    }
    for j in 0..N_ALONG {
        for i in 0..N_AROUND {
            let at = |i: u32, j: u32| j * N_AROUND + i % N_AROUND;
            triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    SurfaceMesh::new(vertices, triangles)
}

fn on_the_tube(p: &Point3<f64>) -> Point3<f64> {
    let scale = RADIUS_M / p.x.hypot(p.y);
    Point3::new(p.x * scale, p.y * scale, p.z)
}

#[test]
fn area_and_volume_are_those_of_a_tube() {
    let (quality, wall) = tube_wall().unwrap();
    let n = f64::from(N_AROUND);
    let polygon_m = n * 2.0 * RADIUS_M * (TAU / 2.0 / n).sin();
    assert!((quality.area_m2 / (polygon_m * LENGTH_M) - 1.0).abs() < 1e-12);
    assert_eq!(quality.n_open_edges, 2 * N_AROUND as usize);
    // Curved faces: far nearer to the round tube than the polygon, which has .3 % less.
    let tube_m3 = TAU / 2.0 * (RADIUS_M.powi(2) - (RADIUS_M - WALL_M).powi(2)) * LENGTH_M;
    let error = wall.volume_m3 / tube_m3 - 1.0;
    assert!(error.abs() < 1e-4, "{error:e}");
}
