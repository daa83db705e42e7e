//! Two contacts behind one frame of ten readings, each with how sure it is: a made-up barrel whose
//! gauges see bending, ovalling and what is near.
//!
//! `cargo run --release --example two_contacts`
//!
//! ```text
//! adjoint fields of the gauges → ResponseMap ─┐
//! readings, µε ───────────────────────────────┴→ ContactEstimator → contacts, covariance, verdict
//! ```
#![allow(clippy::print_stdout, reason = "an example shows what it does")]

use std::f64::consts::TAU;
use std::sync::Arc;

use hapdef_inverse::{
    ContactEstimate, ContactEstimator, EstimatorParams, InverseError, NoiseParams, ResponseMap,
    ResponseParams, ScanSites, Skin, SkinFaces, SkinParams,
};
use nalgebra::{Point3, Vector3};

const RADIUS_M: f64 = 0.035;
const LENGTH_M: f64 = 0.11;
const N_GAUGES: usize = 10;
const NOISE_UE: f64 = 1.0;
/// Angle around the barrel, height in m, force in N.
const PRESSED: [(f64, f64, f64); 2] = [(0.4, 0.04, 12.0), (2.9, 0.07, 7.0)];

fn main() -> Result<(), InverseError> {
    let estimate = two_contacts()?;
    println!("{:?}", estimate.verdict);
    for contact in &estimate.contacts {
        let [x, y, z] = (contact.position_m.coords * 1e3).into();
        let sd = |i: usize| contact.covariance[(i, i)].sqrt();
        println!(
            "{:.3} N at ({x:.2}, {y:.2}, {z:.2}) mm, ±{:.2} N, ±{:.2} mm",
            contact.force_n,
            sd(2),
            sd(0).hypot(sd(1)) * 1e3
        );
    }
    Ok(())
}

fn two_contacts() -> Result<ContactEstimate, InverseError> {
    let skin = barrel()?;
    let adjoint: Vec<Vector3<f64>> = skin
        .nodes()
        .iter()
        .flat_map(|x| (0..N_GAUGES).map(move |gauge| -outward(x) * response(gauge, x)))
        .collect();
    let map = ResponseMap::from_nodal(skin, N_GAUGES, &adjoint, &ResponseParams::default())?;
    let mut readings_ue = vec![0.0; N_GAUGES];
    for (angle, height_m, force_n) in PRESSED {
        let (point, _) = map.skin().nearest(&place(angle, height_m))?;
        for (sum, unit) in readings_ue.iter_mut().zip(map.normal(&point)) {
            *sum += force_n * unit;
        }
    }
    let sites = ScanSites::farthest(map.skin(), 400)?;
    let noise = NoiseParams::uniform(N_GAUGES, NOISE_UE);
    let (map, sites) = (Arc::new(map), Arc::new(sites));
    ContactEstimator::new(map, sites, noise, EstimatorParams::default())?.estimate(&readings_ue)
}

fn barrel() -> Result<Skin, InverseError> {
    let (n_around, n_up) = (56, 44);
    let (mut nodes, mut faces) = (Vec::new(), Vec::new());
    for j in 0..=n_up {
        for i in 0..n_around {
            let height_m = LENGTH_M * f64::from(j) / f64::from(n_up);
            nodes.push(place(TAU * f64::from(i) / f64::from(n_around), height_m));
            if j < n_up {
                let at = |i: u32, j: u32| j * n_around + i % n_around;
                faces.push([at(i, j), at(i, j + 1), at(i + 1, j + 1)]);
                faces.push([at(i, j), at(i + 1, j + 1), at(i + 1, j)]);
            }
        }
    }
    let normals: Vec<Vector3<f64>> = nodes.iter().map(outward).collect();
    let faces = SkinFaces::Linear(&faces);
    Skin::new(nodes, faces, Some(&normals), &SkinParams::default())
}

fn place(angle: f64, height_m: f64) -> Point3<f64> {
    Point3::new(RADIUS_M * angle.cos(), height_m, RADIUS_M * angle.sin())
}

fn outward(x: &Point3<f64>) -> Vector3<f64> {
    Vector3::new(x.x, 0.0, x.z) / x.x.hypot(x.z)
}

/// Reading of a gauge per newton at `x`, µε/N.
fn response(gauge: usize, x: &Point3<f64>) -> f64 {
    let g = gauge as f64;
    let turn = x.z.atan2(x.x) - TAU * 0.618 * g;
    let rise_m = x.y - LENGTH_M * (0.15 + 0.7 * (0.755 * g).fract());
    let fade = (-0.5 * (rise_m / 0.04).powi(2)).exp();
    let ring = 3.0 * turn.cos() + 5.0 * (2.0 * turn + 0.3 * g).cos() + 3.0 * (3.0 * turn).cos();
    let lever = 4.0 * (x.y / LENGTH_M).powi(2) * turn.cos();
    let near_2 =
        ((2.0 * RADIUS_M * (turn / 2.0).sin()).powi(2) + rise_m.powi(2)) / 0.012_f64.powi(2);
    fade * ring + lever + 9.0 * (-0.5 * near_2).exp()
}

#[test]
fn both_contacts_are_found() {
    let estimate = two_contacts().unwrap();
    assert_eq!(estimate.contacts.len(), 2, "{estimate:?}");
    for (angle, height_m, force_n) in PRESSED {
        let truth = place(angle, height_m);
        let miss = |c: &&hapdef_inverse::LocatedContact| (c.position_m - truth).norm();
        let mut contacts = estimate.contacts.iter();
        let found = contacts.find(|c| miss(c) < 0.01).unwrap();
        // Without noise, what is left is the prior on forces and the facets of the barrel.
        assert!(miss(&found) < 0.2e-3, "{} m", miss(&found));
        assert!((found.force_n - force_n).abs() < 0.1, "{} N", found.force_n);
    }
}
