//! A made-up limb, its bundle, and frames of it.
#![allow(dead_code, reason = "each test uses its part")]

pub mod endless;
pub mod fed;
pub mod laws;
pub mod played;
#[path = "../../../../hapdef-inverse/tests/it/world/mod.rs"]
pub mod world;

use std::sync::{Arc, Mutex};

use hapdef_daq::hdp1::{Hello, SampleFormat};
use hapdef_daq::{Frame, Message};
use hapdef_live::estimator::{EstimatorKind, SuperpositionSettings};
use hapdef_live::{Bundle, BundleGauge, BundleInfo};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use world::World;

pub const N_GAUGES: usize = 10;

/// µε per count of the made-up device: a power of two, so that counts are exact.
pub const SCALE: f32 = 1.0 / 1024.0;

pub fn settings() -> SuperpositionSettings {
    SuperpositionSettings {
        noise_ue: 1.0,
        map_error: 0.0,
        place_factor: 1.0,
        tip_ring_m: 0.0,
        tip_radius_m: 0.0,
        palm_radius_m: 0.0,
        friction: 0.0,
        n_sites: 400,
        max_contacts: 3,
        max_force_n: 60.0,
    }
}

/// The bundle of a world, whose skin was made with the barrel's normals.
pub fn bundle(world: &World) -> Bundle {
    let skin = world.map.skin();
    let outward: Vec<Vector3<f64>> =
        skin.nodes().iter().map(|x| Vector3::new(x.x, 0.0, x.z) / world::RADIUS_M).collect();
    let gauge = |i: usize| BundleGauge {
        name: format!("g{i}"),
        position_m: [0.0; 3],
        axis: [0.0, 1.0, 0.0],
        scale: 1.0,
    };
    let info = BundleInfo {
        scene: "barrel".to_owned(),
        made_by: "0.0.0".to_owned(),
        mount_m: None,
        deck_hash: None,
        gauges: (0..world.gauges.len()).map(gauge).collect(),
        estimator: EstimatorKind::Superposition,
        settings: settings(),
    };
    Bundle::new(info, world.map.clone(), Some(&outward)).unwrap()
}

/// What the device says of itself.
pub fn hello(n_channels: usize) -> Hello {
    let mut hello = Hello::plain(n_channels, SampleFormat::I32, 1000);
    hello.channels.iter_mut().for_each(|c| c.scale = SCALE);
    hello.seal();
    hello
}

/// Readings of `n` frames with noise: nothing for 400 frames, then a press of 20 N that rises in 30.
pub fn pressed(world: &World, n: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let point = world.draw_points(1, 0.01, &mut rng)[0];
    let frame = |index: usize| {
        let force_n = 20.0 * (index.saturating_sub(400) as f64 / 30.0).min(1.0);
        let mut y = world.readings(&[(point, force_n)]);
        world::add_noise(&mut y, 1.0, &mut rng);
        y
    };
    (0..n).map(frame).collect()
}

/// Readings as counts, and what the counts say.
pub fn quantised(readings: &[f64]) -> (Vec<i32>, Vec<f64>) {
    let counts: Vec<i32> = readings.iter().map(|y| (y / f64::from(SCALE)).round() as i32).collect();
    let values = counts.iter().map(|c| f64::from(*c) * f64::from(SCALE));
    let values = values.collect();
    (counts, values)
}

/// HELLO and frames a millisecond apart.
pub fn messages(readings: &[Vec<f64>]) -> Vec<Message> {
    let hello = Message::Hello(Arc::new(hello(readings[0].len())));
    let frames = readings.iter().enumerate().map(|(i, y)| {
        let mut frame = Frame::new(i as u32, SampleFormat::I32, quantised(y).0);
        frame.t_device_us = 1000 * i as u64;
        frame.t_host_ns = 1_000_000 * i as u64;
        Message::Frame(frame)
    });
    std::iter::once(hello).chain(frames).collect()
}

/// What a sink has collected.
pub type Collected<T> = Arc<Mutex<Vec<T>>>;

pub fn taken<T>(collected: &Collected<T>) -> Vec<T> {
    std::mem::take(&mut collected.lock().unwrap())
}
