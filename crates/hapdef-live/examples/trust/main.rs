//! What a stream of a limb says while its zeros drift, when a hidden press lets go, when it can't see, and of a
//! press that grows slowly: in simulated time, on the bundle's own map with its noise.
//!
//! `cargo xtask soak` makes the bundle, runs this and keeps its figures; `--table` prints the slowest presses.

#![expect(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a measurement that prints, and ends where something is not as it has to be"
)]

mod blind;
#[path = "../../tests/it/support/fed.rs"]
mod fed;
#[path = "../../../hapdef-daq/examples/soak/metrics.rs"]
mod metrics;
mod silent;
mod tares;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};

use hapdef_daq::hdp1::{Hello, SampleFormat};
use hapdef_daq::source::ReplaySource;
use hapdef_daq::{Frame, Message};
use hapdef_inverse::SkinPoint;
use hapdef_live::estimator::SearchPlace;
use hapdef_live::{
    Bundle, Delivery, FnSink, Live, LiveFrame, LiveParams, Retare, TouchPhase, Wants,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const USAGE: &str = "trust BUNDLE [--long] [--table] [--seed N] [--metrics FILE]";

/// µε per count: no converter is what this is about.
const SCALE: f32 = 1.0 / 1024.0;

const PERIOD_S: f64 = 1e-3;

/// Frames before anything happens, the tare among them.
const BEFORE: usize = 1500;

/// The force above which a contact of an untouched limb is a false one, N.
const FALSE_N: f64 = 0.3;

/// Forces that slow presses grow to, N.
const GROWN_N: f64 = 10.0;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let bundle = Bundle::read(words.first().expect(USAGE).as_ref()).unwrap();
    let has = |name: &str| words.iter().any(|word| word == name);
    let value = |name: &str| words.iter().skip_while(|word| *word != name).nth(1);
    let seed = value("--seed").map_or(1, |word| word.parse().expect(USAGE));
    if has("--table") {
        return table(&bundle, seed);
    }
    let (n_drifts, n_releases) = if has("--long") { (16, 100) } else { (1, 8) };
    let n_false: usize = (0..n_drifts).map(|i| drift(&bundle, seed + i)).sum();
    println!(
        "drift at 1 µε/s, {n_drifts} × 10 min: {n_false} frames with a contact above {FALSE_N} N"
    );
    let mut lags_ms: Vec<f64> =
        (0..n_releases).map(|i| release(&bundle, seed + i).unwrap_or(f64::INFINITY)).collect();
    lags_ms.sort_unstable_by(f64::total_cmp);
    let n_missed = lags_ms.iter().filter(|lag| lag.is_infinite()).count();
    let at = |q: f64| lags_ms[(q * (lags_ms.len() - 1) as f64).round() as usize];
    let (median_ms, p99_ms) = (at(0.5), at(0.99));
    println!(
        "release of a hidden press: {n_missed} of {n_releases} not recognised, {median_ms} ms, 99 % {p99_ms} ms"
    );
    let (n_unknown, n_blind) = blind::count(&bundle, seed, if has("--long") { 100 } else { 10 });
    println!("frames of a blind sensor: {n_blind}, of these {n_unknown} unknown");
    let n_tares = if has("--long") { 100 } else { 10 };
    let refused = tares::count(&bundle, seed, n_tares);
    let [one, two, three, changed] = refused;
    println!(
        "of {n_tares} tares each refused: {one} under a press, {two} under two, {three} under three, {changed} where \
         zeros changed"
    );
    let pct = |n: usize| 100.0 * n as f64 / n_tares as f64;
    let figures = [
        ("trust.tare_one_press_refused_pct", pct(one), "%"),
        ("trust.tare_two_presses_refused_pct", pct(two), "%"),
        ("trust.tare_three_presses_refused_pct", pct(three), "%"),
        ("trust.tare_changed_zero_refused_pct", pct(changed), "%"),
        ("trust.drift_false_contacts", n_false as f64, "1"),
        ("trust.release_lag_ms", median_ms, "ms"),
        ("trust.release_lag_p99_ms", p99_ms, "ms"),
        ("trust.releases_missed_pct", 100.0 * n_missed as f64 / n_releases as f64, "%"),
        ("trust.unknown_when_blind_pct", 100.0 * n_unknown as f64 / n_blind as f64, "%"),
    ];
    metrics::report(&figures, seed, value("--metrics").map(PathBuf::from).as_deref());
}

/// Frames of ten minutes untouched with a contact, each gauge drifting by 1 µε/s up or down.
fn drift(bundle: &Bundle, seed: u64) -> usize {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let sign = |_: usize| if rng.random_bool(0.5) { 1.0 } else { -1.0 };
    let rates: Vec<f64> = (0..bundle.map().n_gauges()).map(sign).collect();
    let frames = play(bundle, 600_000, seed, Retare::Ask, move |index, y| {
        y.iter_mut().zip(&rates).for_each(|(y, rate)| *y += rate * index as f64 * PERIOD_S);
    });
    frames.iter().filter(|seen| seen.force_n > FALSE_N).count()
}

/// From when a press that was tared begins to let go, within 40 ms, until the phase is untouched again, ms.
fn release(bundle: &Bundle, seed: u64) -> Option<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x5eed);
    let (g, force_n) = (response(bundle, &mut rng), rng.random_range(5.0..25.0));
    let frames = play(bundle, BEFORE + 3000, seed, Retare::Auto, move |index, y| {
        let share = 1.0 - (index.saturating_sub(BEFORE) as f64 / 40.0).min(1.0);
        y.iter_mut().zip(&g).for_each(|(y, g)| *y += g * force_n * share);
    });
    // the zero was put right, and nothing came after it
    let mut last_first = frames.iter().rev().take_while(|seen| seen.seq >= BEFORE);
    let last = last_first.find(|seen| seen.phase != TouchPhase::Untouched).map(|seen| seen.seq);
    let is_right = frames.last().is_some_and(|seen| seen.phase == TouchPhase::Untouched);
    last.filter(|_| is_right).map(|seq| (seq + 1 - BEFORE) as f64 * PERIOD_S * 1e3)
}

/// Presses that grow steadily: in which share they are seen, and at which force.
fn table(bundle: &Bundle, seed: u64) {
    const N: u64 = 40;
    println!("| grows by, N/s | seen before {GROWN_N} N, % | force then, median N | 90 %, N |");
    println!("|---|---|---|---|");
    for rate in [0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2] {
        let grow = |i| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed + i);
            let g = response(bundle, &mut rng);
            let n = BEFORE + (GROWN_N / rate / PERIOD_S) as usize;
            let force_n = move |index: usize| rate * index.saturating_sub(BEFORE) as f64 * PERIOD_S;
            let frames = play(bundle, n, seed + i, Retare::Ask, move |index, y| {
                y.iter_mut().zip(&g).for_each(|(y, g)| *y += g * force_n(index));
            });
            let is_seen = |seen: &&Seen| seen.phase == TouchPhase::Touched && seen.force_n > 0.0;
            let first = frames.iter().find(is_seen);
            first.map_or(f64::INFINITY, |seen| force_n(seen.seq))
        };
        let mut forces_n: Vec<f64> = (0..N).map(grow).collect();
        forces_n.sort_unstable_by(f64::total_cmp);
        let n_seen = forces_n.iter().filter(|force_n| force_n.is_finite()).count();
        let quantile = |q: f64| match forces_n[(q * (N - 1) as f64) as usize] {
            force_n if force_n.is_finite() => format!("{force_n:.2}"),
            _ => "–".to_owned(),
        };
        let share = 100.0 * n_seen as f64 / N as f64;
        println!("| {rate} | {share:.0} | {} | {} |", quantile(0.5), quantile(0.9));
    }
}

/// What the gauges read for a newton at a random node.
fn response(bundle: &Bundle, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let points: Vec<SkinPoint> = bundle.skin().node_points().into_iter().flatten().collect();
    bundle.map().normal(&points[rng.random_range(0..points.len())])
}

/// What is kept of a frame.
struct Seen {
    seq: usize,
    phase: TouchPhase,
    /// The strongest contact's.
    force_n: f64,
}

/// What the device sends: `n` frames of noise with what `add` adds.
fn messages(
    bundle: &Bundle,
    n: usize,
    seed: u64,
    mut add: impl FnMut(usize, &mut [f64]) + Send + 'static,
) -> impl Iterator<Item = Message> + Send + 'static {
    let n_gauges = bundle.map().n_gauges();
    let mut hello = Hello::plain(n_gauges, SampleFormat::I32, 1000);
    hello.channels.iter_mut().for_each(|channel| channel.scale = SCALE);
    hello.seal();
    let (mut rng, noise_ue) = (ChaCha8Rng::seed_from_u64(seed), bundle.info.settings.noise_ue);
    let frame = move |index: usize| {
        let noise = |_| -> f64 { StandardNormal.sample(&mut rng) };
        let mut y: Vec<f64> = (0..n_gauges).map(noise).map(|z: f64| z * noise_ue).collect();
        add(index, &mut y);
        let counts = y.iter().map(|y| (y / f64::from(SCALE)).round() as i32);
        let mut frame = Frame::new(index as u32, SampleFormat::I32, counts.collect::<Vec<_>>());
        frame.t_device_us = 1000 * index as u64;
        frame.t_host_ns = 1_000_000 * index as u64;
        Message::Frame(frame)
    };
    std::iter::once(Message::Hello(Arc::new(hello))).chain((0..n).map(frame))
}

/// Plays `n` frames of noise with what `add` adds.
fn play(
    bundle: &Bundle,
    n: usize,
    seed: u64,
    retare: Retare,
    add: impl FnMut(usize, &mut [f64]) + Send + 'static,
) -> Vec<Seen> {
    let messages = messages(bundle, n, seed, add);
    let (sender, seen): (_, Receiver<Seen>) = channel();
    let sink = FnSink::new("trust", Wants::CONTACTS, move |frame: &LiveFrame| {
        let forces_n = frame.touch.contacts.iter().map(|contact| contact.force_n);
        let force_n = forces_n.fold(0.0, f64::max);
        sender.send(Seen { seq: frame.seq as usize, phase: frame.phase, force_n }).unwrap();
    });
    let params =
        LiveParams { retare, is_recorded: true, is_lossless: true, ..LiveParams::default() };
    let live = Live::builder(ReplaySource::new("memory", messages, 0.0))
        .bundle(bundle)
        .params(params)
        .estimator(bundle.tracking(SearchPlace::Here).unwrap())
        .sink(sink.with_delivery(Delivery::Direct))
        .start()
        .unwrap();
    live.wait().unwrap();
    seen.into_iter().collect()
}
