//! From a frame to its contacts while busy loops have every core, with real-time priority and without.

use std::process::{Child, Command};
use std::sync::Arc;
use std::thread::available_parallelism;

use hapdef_daq::enter_realtime;
use hapdef_live::{Bundle, Delivery};

use crate::{Plan, live, metrics, quantiles_us, turn};

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

/// Runs turns of both kinds, and ends with 1 where what is asked for is not met.
pub fn measure(plan: &Plan, bundle: &Bundle, counts: &Arc<Vec<Vec<i32>>>) {
    let granted = std::thread::spawn(|| enter_realtime(1)).join().unwrap();
    let n_cores = available_parallelism().unwrap().get();
    let busy: Vec<BusyLoop> = (0..n_cores).map(|_| BusyLoop::start()).collect();
    let run = |priority: Option<u8>| {
        turn(bundle, counts, Some(DEVICE_PRIORITY), |path| {
            let (latencies_ns, health) = live(bundle, path, plan.turn, Delivery::Direct, priority);
            println!("  priority {priority:?}: {health}");
            latencies_ns
        })
    };
    let (mut plain_ns, mut realtime_ns) = (Vec::new(), Vec::new());
    for _ in 0..plan.n_rounds {
        plain_ns.extend(run(None));
        if granted.is_ok() {
            realtime_ns.extend(run(Some(PRIORITY)));
        }
    }
    drop(busy);
    let [p99_ms, worst_ms] = figures_ms(&mut plain_ns);
    let mut figures =
        vec![("trust.busy_p99_ms", p99_ms, "ms"), ("trust.busy_worst_second_ms", worst_ms, "ms")];
    if let Err(refusal) = granted {
        println!("{refusal}: hapdef doctor says what to do");
        return metrics::report(&figures, plan.seed, plan.metrics.as_deref());
    }
    let [p99_ms, worst_ms] = figures_ms(&mut realtime_ns);
    figures.push(("trust.realtime_p99_ms", p99_ms, "ms"));
    figures.push(("trust.realtime_worst_second_ms", worst_ms, "ms"));
    metrics::report(&figures, plan.seed, plan.metrics.as_deref());
    let is_met = p99_ms <= MOST_P99_MS && worst_ms <= MOST_MS;
    let words = if is_met { "met" } else { "not met" };
    println!(
        "p99 at most {MOST_P99_MS} ms, the longest of any second at most {MOST_MS} ms: {words}"
    );
    if !is_met {
        std::process::exit(1);
    }
}

/// The 99th percentile, and the longest of all: that of the worst second.
fn figures_ms(latencies_ns: &mut [u64]) -> [f64; 2] {
    let [_, p99_us] = quantiles_us(latencies_ns);
    [p99_us * 1e-3, latencies_ns[latencies_ns.len() - 1] as f64 * 1e-6]
}
