//! Errors by number of contacts on a made-up limb, count estimated, beside the time per frame.
//!
//! `cargo run --release --example accuracy -- [n_frames] [noise_ue] [n_gauges]`
#![allow(clippy::print_stdout, reason = "a table is what it is for")]

#[path = "../tests/it/world/mod.rs"]
mod world;

use std::time::Instant;

use hapdef_inverse::{ContactEstimate, EstimatorParams, NoiseParams, Verdict};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use world::World;

fn main() {
    let mut args = std::env::args().skip(1).map(|a| a.parse::<f64>().ok());
    let mut next = |default: f64| args.next().flatten().unwrap_or(default);
    let (n_frames, noise_ue, n_gauges) = (next(300.0) as usize, next(1.0), next(10.0) as usize);
    println!("{n_gauges} gauges, {noise_ue} µε, forces 5–34 N, {n_frames} frames a row");
    println!(
        "{:>2} {:>8} {:>8} {:>8} {:>7} {:>7} {:>7} {:>7} {:>8} {:>8} {:>8}",
        "k",
        "mean mm",
        "median",
        "p90",
        ">10 mm",
        "mean N",
        "count",
        "unsure",
        "p50 µs",
        "p99 µs",
        "cpu µs"
    );
    for k in 1..=4 {
        println!("{}", row(k, n_frames, noise_ue, n_gauges));
    }
}

fn row(k: usize, n_frames: usize, noise_ue: f64, n_gauges: usize) -> String {
    let world = World::new(n_gauges, 800, 7);
    let noise = NoiseParams::uniform(n_gauges, noise_ue);
    let estimator = world.estimator(noise, EstimatorParams::default());
    let (mut scratch, mut out) = (estimator.scratch(), ContactEstimate::default());
    let mut rng = ChaCha8Rng::seed_from_u64(100 + k as u64);
    let (mut mm, mut newtons, mut times) = (Vec::new(), Vec::new(), Vec::new());
    let (mut n_right, mut n_unsure) = (0, 0);
    let cpu_before = cpu_us();
    for _ in 0..n_frames {
        let points = world.draw_points(k, 0.012, &mut rng);
        let contacts: Vec<_> = points.iter().map(|p| (*p, rng.random_range(5.0..34.0))).collect();
        let mut y = world.readings(&contacts);
        world::add_noise(&mut y, noise_ue, &mut rng);
        // the least of three runs, since other programs share the machine
        let mut least_us = f64::INFINITY;
        for _ in 0..3 {
            let start = Instant::now();
            let result = estimator.estimate_into(&y, &mut scratch, &mut out);
            least_us = least_us.min(start.elapsed().as_secs_f64() * 1e6);
            assert!(result.is_ok(), "{result:?}");
        }
        times.push(least_us);
        let skin = world.map.skin();
        let truth: Vec<_> = points.iter().map(|p| skin.position(p)).collect();
        let found: Vec<_> = out.contacts.iter().map(|c| c.position_m).collect();
        for (i, m) in world::matched(&truth, &found).into_iter().enumerate() {
            let (d, f) = m.map_or((0.1, contacts[i].1), |j| {
                let miss = (truth[i] - found[j]).norm();
                (miss, (contacts[i].1 - out.contacts[j].force_n).abs())
            });
            mm.push(d * 1e3);
            newtons.push(f);
        }
        n_right += usize::from(out.contacts.len() == k);
        n_unsure += usize::from(matches!(out.verdict, Verdict::NotIdentifiable(_)));
    }
    let cpu = (cpu_us() - cpu_before) / (3 * n_frames) as f64;
    let n = mm.len() as f64;
    let bad = mm.iter().filter(|&&d| d > 10.0).count() as f64 / n * 100.0;
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let share = |c: usize| c as f64 / n_frames as f64 * 100.0;
    let (mean_mm, mean_n) = (mean(&mm), mean(&newtons));
    format!(
        "{k:>2} {mean_mm:>8.3} {:>8.3} {:>8.3} {bad:>6.1}% {mean_n:>7.3} {:>6.1}% {:>6.1}% {:>8.0} {:>8.0} {cpu:>8.0}",
        quantile(&mut mm, 0.5),
        quantile(&mut mm, 0.9),
        share(n_right),
        share(n_unsure),
        quantile(&mut times, 0.5),
        quantile(&mut times, 0.99),
    )
}

/// Time this program has run on a core, µs; 0 where the system does not say.
fn cpu_us() -> f64 {
    let text = std::fs::read_to_string("/proc/self/schedstat").unwrap_or_default();
    let ns = text.split_whitespace().next().and_then(|w| w.parse().ok());
    ns.map_or(0.0, |ns: f64| ns * 1e-3)
}

fn quantile(values: &mut [f64], q: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * q).round() as usize]
}
