//! From a frame's first byte to its contacts, against a reader that does nothing else: 64 × i32 at
//! 1 kHz by a pseudo-terminal, in turns within one run. With `--busy`: with a busy loop for each core
//! beside it, with real-time priority and without.
//!
//! `cargo xtask bench live` and `bench realtime` make the bundle, run this and keep its figures.

#![expect(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a measurement that prints, and ends where something is not as it has to be"
)]

mod device;
#[path = "../../../hapdef-daq/examples/soak/metrics.rs"]
mod metrics;
mod realtime;

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use hapdef_daq::clock::{HostClock, SystemClock};
use hapdef_daq::hdp1::{Decoder, Event};
use hapdef_daq::source::{FrameSource, Link, SerialLink, SerialParams, StreamParams, StreamSource};
use hapdef_live::estimator::SearchPlace;
use hapdef_live::{Bundle, Delivery, FnSink, Health, Live, LiveParams, Wants};

use crate::device::{SENT_NS, Wire, pty, readings};

const USAGE: &str = "latency BUNDLE [--busy] [--seconds N] [--seed N] [--metrics FILE]";

/// Time at the start of a turn that is not counted, with the tare.
const WARM: Duration = Duration::from_secs(1);

/// Turns of each kind at most, and how long one is at least, s.
const MOST_ROUNDS: u64 = 5;
const LEAST_TURN_S: u64 = 4;

/// What is measured, and how long.
struct Plan {
    bundle: PathBuf,
    n_rounds: u64,
    turn: Duration,
    seed: u64,
    metrics: Option<PathBuf>,
    is_busy: bool,
}

fn main() {
    let plan = plan();
    let bundle = Bundle::read(&plan.bundle).unwrap();
    let counts = Arc::new(readings(&bundle, plan.seed));
    if plan.is_busy {
        return realtime::measure(&plan, &bundle, &counts);
    }
    let (mut bare_us, mut live_us) = (Vec::new(), Vec::new());
    for _ in 0..plan.n_rounds {
        bare_us.extend(turn(&bundle, &counts, pty(), None, |path| bare(path, plan.turn)));
        live_us.extend(turn(&bundle, &counts, pty(), None, |path| {
            let queue = Delivery::Queue(1024);
            let (times, health) = live(&bundle, serial(path), plan.turn, queue, None);
            println!("  {health}");
            times
        }));
    }
    let [bare, live] = [&mut bare_us, &mut live_us].map(|all| quantiles_us(all));
    println!(
        "bare reader: p50 {:.0} µs, p99 {:.0} µs ({} frames); frame to contacts: p50 {:.0} µs, p99 \
         {:.0} µs ({} frames)",
        bare[0],
        bare[1],
        bare_us.len(),
        live[0],
        live[1],
        live_us.len()
    );
    let figures = [
        ("live.p50_over_bare_us", live[0] - bare[0], "µs"),
        ("live.p99_over_bare", live[1] / bare[1], "1"),
        ("live.p99_us", live[1], "µs"),
        ("live.p99_bare_us", bare[1], "µs"),
    ];
    metrics::report(&figures, plan.seed, plan.metrics.as_deref());
    let is_met = live[0] - bare[0] <= 200.0 && live[1] <= 1.5 * bare[1] + 1000.0;
    let words = if is_met { "met" } else { "not met" };
    println!("p50 at most 200 µs above, p99 at most 1.5 times and 1 ms: {words}");
    if !is_met {
        std::process::exit(1);
    }
}

fn plan() -> Plan {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let value = |name: &str| words.iter().skip_while(|word| *word != name).nth(1);
    let number =
        |name: &str, default: u64| value(name).map_or(default, |v| v.parse().expect(USAGE));
    let is_busy = words.iter().any(|word| word == "--busy");
    let n_kinds: u64 = if is_busy { 4 } else { 2 };
    let all_s = number("--seconds", 2 * MOST_ROUNDS * LEAST_TURN_S);
    let n_rounds = (all_s / (n_kinds * LEAST_TURN_S)).clamp(1, MOST_ROUNDS);
    let turn = Duration::from_secs(all_s) / (n_kinds * n_rounds) as u32;
    assert!(turn > WARM, "--seconds: more than {} s is needed", n_kinds * WARM.as_secs());
    Plan {
        bundle: words.first().expect(USAGE).into(),
        n_rounds,
        turn,
        seed: number("--seed", 1),
        metrics: value("--metrics").map(PathBuf::from),
        is_busy,
    }
}

/// A device plays on a wire, at a real-time priority if one is given, while `read` reads it.
fn turn<T>(
    bundle: &Bundle,
    counts: &Arc<Vec<Vec<i32>>>,
    wire: Wire,
    priority: Option<u8>,
    read: impl FnOnce(&str) -> T,
) -> T {
    let stop = Arc::new(AtomicBool::new(false));
    let (theirs, counts) = (Arc::clone(&stop), Arc::clone(counts));
    let hello = device::hello(bundle);
    let device = std::thread::spawn(move || {
        let _ = priority.map(hapdef_daq::enter_realtime);
        device::play(&(wire.end)(), &hello, &counts, &theirs);
    });
    let times = read(&wire.address);
    stop.store(true, Ordering::Release);
    device.join().unwrap();
    times
}

/// Time from when packet `seq` was sent until now, ns.
fn since_sent_ns(seq: u32) -> u64 {
    let sent_ns = SENT_NS[seq as usize % SENT_NS.len()].load(Ordering::Relaxed);
    SystemClock.now_ns().saturating_sub(sent_ns)
}

/// Reads and decodes on one thread that does nothing else.
fn bare(path: &str, turn: Duration) -> Vec<u64> {
    let mut link = SerialLink::new(path, SerialParams::default());
    link.open().unwrap();
    link.write(&[0]).unwrap();
    let (mut decoder, mut buffer) = (Decoder::new(), vec![0; 1 << 14]);
    let mut times = Vec::with_capacity(1 << 16);
    let start = Instant::now();
    while start.elapsed() < turn {
        let n = link.read(&mut buffer, Duration::from_millis(20)).unwrap();
        decoder.push(&buffer[..n], &mut |event| {
            if let Event::Data(data) = event
                && start.elapsed() >= WARM
            {
                times.push(since_sent_ns(data.header.seq));
            }
        });
    }
    times
}

/// Reads, tares, follows contacts and hands them to a sink, on its own thread or directly.
fn live(
    bundle: &Bundle,
    source: impl FrameSource + 'static,
    turn: Duration,
    delivery: Delivery,
    realtime_priority: Option<u8>,
) -> (Vec<u64>, Health) {
    let times = Arc::new(Mutex::new(Vec::with_capacity(1 << 16)));
    let (to, start) = (Arc::clone(&times), Instant::now());
    let sink = FnSink::new("robot", Wants::ALL, move |frame| {
        if start.elapsed() >= WARM {
            to.lock().unwrap().push(since_sent_ns(frame.seq));
        }
    });
    let live = Live::builder(source)
        .bundle(bundle)
        .params(LiveParams { tare_s: 0.2, realtime_priority, ..LiveParams::default() })
        .estimator(bundle.tracking(SearchPlace::Background).unwrap())
        .sink(sink.with_delivery(delivery))
        .start()
        .unwrap();
    std::thread::sleep(turn);
    let health = live.stop().unwrap();
    let times = std::mem::take(&mut *times.lock().unwrap());
    (times, health)
}

fn serial(path: &str) -> impl FrameSource + use<> {
    let link = SerialLink::new(path, SerialParams::default());
    StreamSource::new(link, StreamParams::default())
}

/// Median and 99th percentile, µs.
fn quantiles_us(times_ns: &mut [u64]) -> [f64; 2] {
    assert!(!times_ns.is_empty(), "no frame came through");
    times_ns.sort_unstable();
    [0.5, 0.99].map(|q| {
        let at = (q * times_ns.len() as f64) as usize;
        times_ns[at.min(times_ns.len() - 1)] as f64 * 1e-3
    })
}
