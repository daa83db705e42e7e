//! A limb that differs from its map.
#![allow(dead_code, reason = "each test uses a part of it")]

use hapdef_inverse::{Calibrated, CalibrationParams, InverseError, Press, ResponseMap, SkinPoint};
use nalgebra::Point3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::world::{self, World};

pub const N_GAUGES: usize = 6;

/// The limb: gains, and a smooth change of some per cent that no mode has.
pub struct Limb {
    pub gains: Vec<f64>,
    pub warp: f64,
}

impl Limb {
    pub fn plain() -> Self {
        Self { gains: vec![1.0; N_GAUGES], warp: 0.0 }
    }

    pub fn response(&self, world: &World, x: &Point3<f64>) -> Vec<f64> {
        let bump = 1.0 + self.warp * (60.0 * x.x + 35.0 * x.y).sin() * (45.0 * x.z).cos();
        let gauges = world.gauges.iter().zip(&self.gains);
        gauges.map(|(g, gain)| gain * bump * g.normal(x)).collect()
    }

    pub fn presses(&self, world: &World, n: usize, noise: f64, seed: u64) -> Vec<Press> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        (0..n)
            .map(|_| {
                let point = world::draw_point(world.map.skin(), &mut rng);
                let force_n = rng.random_range(5.0..34.0);
                let x = world.map.skin().position(&point);
                let mut readings: Vec<f64> =
                    self.response(world, &x).iter().map(|g| force_n * g).collect();
                world::add_noise(&mut readings, noise, &mut rng);
                Press { point, force_n, readings }
            })
            .collect()
    }

    /// Root mean square error of `map` over that of the response, at points of their own.
    pub fn error(&self, world: &World, map: &ResponseMap) -> f64 {
        let (mut error, mut all) = (0.0, 0.0);
        for point in test_points(world) {
            let x = map.skin().position(&point);
            for (t, g) in self.response(world, &x).iter().zip(map.normal(&point)) {
                error += (t - g).powi(2);
                all += t * t;
            }
        }
        (error / all).sqrt()
    }
}

pub fn test_points(world: &World) -> Vec<SkinPoint> {
    let mut rng = ChaCha8Rng::seed_from_u64(999);
    (0..300).map(|_| world::draw_point(world.map.skin(), &mut rng)).collect()
}

pub fn world() -> World {
    World::new(N_GAUGES, 150, 5)
}

pub fn fit(
    world: &World,
    presses: &[Press],
    params: &CalibrationParams,
) -> Result<Calibrated, InverseError> {
    Calibrated::fit(&world.map, &world.sites, &[], presses, params)
}

pub fn params() -> CalibrationParams {
    CalibrationParams::new(vec![1.0; N_GAUGES])
}
