//! A made-up limb on which the estimator's inner loops are timed: a barrel with gauges that see ring
//! modes, bending and a lobe of their own, smooth as elasticity is.

use std::f64::consts::TAU;

use hapdef_inverse::{InverseError, ResponseMap, ResponseParams, Skin, SkinFaces, SkinParams};
use nalgebra::{Point3, Vector3};

/// Gauges of the barrel.
pub(super) const N_GAUGES: usize = 10;

/// Measures of the barrel, m, and its squares around and along.
const RADIUS_M: f64 = 0.035;
const LENGTH_M: f64 = 0.11;
const SQUARES: [usize; 2] = [28, 22];

/// The barrel's response, µε/N.
pub(super) fn barrel() -> Result<ResponseMap, InverseError> {
    let skin = skin()?;
    let at = |x: &Point3<f64>| {
        let x = *x;
        (0..N_GAUGES).map(move |gauge| -outward(&x) * response_ue_per_n(gauge, &x))
    };
    let adjoint: Vec<Vector3<f64>> = skin.nodes().iter().flat_map(at).collect();
    ResponseMap::from_nodal(skin, N_GAUGES, &adjoint, &ResponseParams::default())
}

fn outward(x: &Point3<f64>) -> Vector3<f64> {
    Vector3::new(x.x, 0.0, x.z) / RADIUS_M
}

/// Reading of a gauge per newton against the normal at `x`, µε/N.
fn response_ue_per_n(gauge: usize, x: &Point3<f64>) -> f64 {
    let i = gauge as f64;
    let turn = x.z.atan2(x.x) - TAU * (0.618 * i).fract();
    let up_m = x.y - LENGTH_M * (0.15 + 0.7 * (0.755 * i).fract());
    let fade = (-0.5 * (up_m / 0.04).powi(2)).exp();
    let modes = [(3.0, 0.3), (5.0, -0.4), (3.0, 0.1), (1.5, 0.5)];
    let ring = (1..)
        .zip(modes)
        .map(|(n, (size, phase))| size * fade * (f64::from(n) * turn + phase + 0.2 * i).cos());
    let lever = 4.0 * (x.y / LENGTH_M).powi(2) * turn.cos();
    let aside_m = 2.0 * RADIUS_M * (0.5 * turn).sin();
    let lobe = 14.0 * (-0.5 * (aside_m.powi(2) + up_m.powi(2)) / 0.012_f64.powi(2)).exp();
    ring.sum::<f64>() + lever + lobe
}

fn skin() -> Result<Skin, InverseError> {
    let [around, along] = SQUARES;
    let node = |i: usize, j: usize| (j * around + i % around) as u32;
    let place = |k: usize| {
        let angle = TAU * (k % around) as f64 / around as f64;
        let y = LENGTH_M * (k / around) as f64 / along as f64;
        Point3::new(RADIUS_M * angle.cos(), y, RADIUS_M * angle.sin())
    };
    let nodes: Vec<Point3<f64>> = (0..around * (along + 1)).map(place).collect();
    let square = |k: usize| {
        let (i, j) = (k % around, k / around);
        let [a, b] = [node(i, j), node(i, j + 1)];
        let [c, d] = [node(i + 1, j + 1), node(i + 1, j)];
        [[a, b, c], [a, c, d]]
    };
    let faces: Vec<[u32; 3]> = (0..around * along).flat_map(square).collect();
    let normals: Vec<Vector3<f64>> = nodes.iter().map(outward).collect();
    Skin::new(nodes, SkinFaces::Linear(&faces), Some(&normals), &SkinParams::default())
}
