//! A strip that is clamped at one end and pressed at the other: how far it bends, and what a strain
//! gauge on it reads.
//!
//! `cargo run --release --example cantilever`
//!
//! ```text
//! ▓▓▓▓┌──────────────┬──────────────┐ ↓ 1 N
//! ▓▓▓▓│    gauge on top, half way   │   100 × 20 × 2 mm, E = 1.7 GPa
//! ▓▓▓▓└──────────────┴──────────────┘
//! ```
//!
//! The gauge's reading comes once from the solved displacement, and once from its own adjoint solve,
//! which has the answer for a force anywhere.
#![allow(clippy::print_stdout, reason = "an example shows what it does")]

use std::error::Error;

use hapdef_mesh::{
    ExtrudeParams, Extrusion, FaceCurve, FeNodeId, GaugeId, SkinSide, SurfaceMesh, extrude,
};
use hapdef_sim::{
    ElasticModel, ElasticParams, GaugeSite, GaugeStrain, IsotropicMaterial, NodalLoad,
};
use nalgebra::{Point3, Vector3};

const LENGTH_M: f64 = 0.1;
const WIDTH_M: f64 = 0.02;
const HEIGHT_M: f64 = 2e-3;
const YOUNGS_MODULUS_PA: f64 = 1.7e9;
const N_ALONG: u32 = 40;
const N_ACROSS: u32 = 4;

struct Bent {
    tip_m: f64,
    reading: f64,
    reading_adjoint: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let bent = bend()?;
    println!("1 N at the end: {:.3} mm", bent.tip_m * 1e3);
    println!("the gauge half way: {:.3} µε", bent.reading * 1e6);
    println!("by its adjoint: {:.3} µε", bent.reading_adjoint * 1e6);
    Ok(())
}

fn bend() -> Result<Bent, Box<dyn Error>> {
    let mesh = strip()?.mesh;
    let nodes_at = |x: f64| -> Vec<FeNodeId> {
        let nodes = mesh.nodes().iter().enumerate();
        let there = nodes.filter(|(_, p)| (p.x - x).abs() < 1e-9);
        there.map(|(i, _)| FeNodeId::from_index(i)).collect()
    };
    let material = IsotropicMaterial::new(YOUNGS_MODULUS_PA, 0.0, 930.0)?;
    let model = ElasticModel::build(&mesh, &ElasticParams::new(material, nodes_at(0.0)))?;
    let end = nodes_at(LENGTH_M);
    let share = Vector3::z() * (-1.0 / end.len() as f64);
    let load = NodalLoad {
        forces_n: end.iter().map(|node| (*node, share)).collect(),
        ..NodalLoad::default()
    };
    let (displacement, _) = model.solve(&load)?;
    let site = GaugeSite {
        position: Point3::new(LENGTH_M / 2.0, WIDTH_M / 2.0, HEIGHT_M),
        axis: Vector3::x(),
        length_m: 8e-3,
        width_m: 5e-3,
    };
    let gauge = GaugeStrain::new(&mesh, &mesh.boundary().faces, &site)?;
    let (response, _) = model.response(std::slice::from_ref(&gauge))?;
    let sum: f64 = end.iter().map(|node| displacement[node.index()].z).sum();
    Ok(Bent {
        tip_m: -sum / end.len() as f64,
        reading: gauge.strain(&displacement),
        reading_adjoint: response.reading(GaugeId::from_index(0), &load),
    })
}

/// The strip: its upper side as triangles, extruded downward.
fn strip() -> Result<Extrusion, Box<dyn Error>> {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..=N_ALONG {
        for j in 0..=N_ACROSS {
            let x = LENGTH_M * f64::from(i) / f64::from(N_ALONG);
            let y = WIDTH_M * f64::from(j) / f64::from(N_ACROSS);
            vertices.push(Point3::new(x, y, HEIGHT_M));
            if i < N_ALONG && j < N_ACROSS {
                let (a, b) = (i * (N_ACROSS + 1) + j, (i + 1) * (N_ACROSS + 1) + j);
                triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
            }
        }
    }
    let upper = SurfaceMesh::new(vertices, triangles)?;
    let params = ExtrudeParams { side: SkinSide::Outer, n_layers: 1, curve: FaceCurve::Flat };
    let heights_m = vec![HEIGHT_M; upper.vertices().len()];
    Ok(extrude(&upper, &heights_m, &params)?)
}

#[test]
fn it_bends_as_a_beam_does() {
    let bent = bend().unwrap();
    // Euler–Bernoulli with Timoshenko's shear: P L³ / 3 E I + P L / κ G A; ν = 0, κ = 5/6.
    let area_m2 = WIDTH_M * HEIGHT_M;
    let inertia_m4 = area_m2 * HEIGHT_M * HEIGHT_M / 12.0;
    let shear_pa = YOUNGS_MODULUS_PA / 2.0;
    let tip_m = LENGTH_M.powi(3) / (3.0 * YOUNGS_MODULUS_PA * inertia_m4)
        + LENGTH_M / (5.0 / 6.0 * shear_pa * area_m2);
    assert!((bent.tip_m / tip_m - 1.0).abs() < 2e-3, "{}", bent.tip_m);
    // ε = M h / 2 E I half way
    let strain = LENGTH_M / 2.0 * HEIGHT_M / 2.0 / (YOUNGS_MODULUS_PA * inertia_m4);
    assert!((bent.reading / strain - 1.0).abs() < 1e-2, "{}", bent.reading);
    assert!((bent.reading_adjoint / bent.reading - 1.0).abs() < 1e-9);
}
