//! From a frame to its contacts while busy loops have every core, with real-time priority and without.

use std::process::{Child, Command};
use std::sync::Arc;
use std::thread::available_parallelism;

use hapdef_daq::enter_realtime;
use hapdef_daq::source::{FrameSource, StreamParams, StreamSource, TcpLink};
use hapdef_live::{Bundle, Delivery};

use crate::device::{pty, tcp};
use crate::{Plan, live, metrics, quantiles_us, serial, turn};

/// Of the device, which is a board of its own, above that of the reader.
const DEVICE_PRIORITY: u8 = 70;
const PRIORITY: u8 = 50;

/// What is asked for with real-time priority, ms: of 99 % of the frames, and of all in each second.
const MOST_P99_MS: f64 = 2.0;
const MOST_MS: f64 = 20.0;

/// A process that computes until it is dropped, at the priority that this one has.
struct BusyLoop(Child);

impl BusyLoop {
    fn start() -> Self {
        Self(Command::new("sh").args(["-c", "while :; do :; done"]).spawn().unwrap())
    }
}

impl Drop for BusyLoop {
    fn drop(&mut self) {
        self.0.kill().unwrap();
        self.0.wait().unwrap();
    }
}

/// How a turn goes: the names of its figures, the wire, whether it has real-time priority.
struct Kind {
    names: [&'static str; 2],
    is_serial: bool,
    is_realtime: bool,
}

const KINDS: [Kind; 4] = [
    Kind {
        names: ["trust.busy_p99_ms", "trust.busy_worst_second_ms"],
        is_serial: false,
        is_realtime: false,
    },
    Kind {
        names: ["trust.realtime_p99_ms", "trust.realtime_worst_second_ms"],
        is_serial: false,
        is_realtime: true,
    },
    Kind {
        names: ["trust.busy_serial_p99_ms", "trust.busy_serial_worst_second_ms"],
        is_serial: true,
        is_realtime: false,
    },
    Kind {
        names: ["trust.realtime_serial_p99_ms", "trust.realtime_serial_worst_second_ms"],
        is_serial: true,
        is_realtime: true,
    },
];

/// Runs turns of each kind by turns, and ends with 1 where what is asked for by TCP is not met.
pub fn measure(plan: &Plan, bundle: &Bundle, counts: &Arc<Vec<Vec<i32>>>) {
    let granted = std::thread::spawn(|| enter_realtime(1)).join().unwrap();
    let n_cores = available_parallelism().unwrap().get();
    let busy: Vec<BusyLoop> = (0..n_cores).map(|_| BusyLoop::start()).collect();
    let mut latencies_ns = KINDS.map(|_| Vec::new());
    for _ in 0..plan.n_rounds {
        for (kind, latencies_ns) in KINDS.iter().zip(&mut latencies_ns) {
            if !kind.is_realtime || granted.is_ok() {
                latencies_ns.extend(run(kind, plan, bundle, counts));
            }
        }
    }
    drop(busy);
    if let Err(refusal) = &granted {
        println!("{refusal}: hapdef doctor says what to do");
    }
    let mut is_met = true;
    for (kind, latencies_ns) in KINDS.iter().zip(&mut latencies_ns) {
        if latencies_ns.is_empty() {
            continue;
        }
        let [_, p99_us] = quantiles_us(latencies_ns);
        let p99_ms = p99_us * 1e-3;
        // The longest of the worst second is the longest of all.
        let worst_ms = latencies_ns[latencies_ns.len() - 1] as f64 * 1e-6;
        let figures = [(kind.names[0], p99_ms, "ms"), (kind.names[1], worst_ms, "ms")];
        metrics::report(&figures, plan.seed, plan.metrics.as_deref());
        let is_asked = kind.is_realtime && !kind.is_serial;
        is_met &= !is_asked || (p99_ms <= MOST_P99_MS && worst_ms <= MOST_MS);
    }
    let words = if is_met { "met" } else { "not met" };
    println!(
        "with real-time priority p99 at most {MOST_P99_MS} ms, longest at most {MOST_MS} ms: {words}"
    );
    if !is_met {
        std::process::exit(1);
    }
}

fn run(kind: &Kind, plan: &Plan, bundle: &Bundle, counts: &Arc<Vec<Vec<i32>>>) -> Vec<u64> {
    let wire = if kind.is_serial { pty() } else { tcp() };
    turn(bundle, counts, wire, Some(DEVICE_PRIORITY), |address| {
        let source: Box<dyn FrameSource> = match kind.is_serial {
            true => Box::new(serial(address)),
            false => Box::new(StreamSource::new(TcpLink::new(address), StreamParams::default())),
        };
        let priority = kind.is_realtime.then_some(PRIORITY);
        let (latencies_ns, health) = live(bundle, source, plan.turn, Delivery::Direct, priority);
        println!("  {}: {health} {:?}", kind.names[0], health.total);
        latencies_ns
    })
}
