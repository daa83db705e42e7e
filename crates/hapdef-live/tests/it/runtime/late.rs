//! Which frames count as late, by clocks that the test sets.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use hapdef_daq::clock::HostClock;
use hapdef_daq::hdp1::{Hello, SampleFormat};
use hapdef_daq::source::{FrameSource, SourceStats, SourceStatus};
use hapdef_daq::{Frame, Message};
use hapdef_live::{Delivery, Live, LiveParams};

use super::stand_ins::{Asked, Probe};
use crate::support::N_GAUGES;

const N_PACKETS: u64 = 50;
/// Time between scans.
const PERIOD_NS: u64 = 1_000_000;

#[derive(Clone, Default)]
struct SetClock(Arc<AtomicU64>);

impl HostClock for SetClock {
    fn now_ns(&self) -> u64 {
        self.0.load(Ordering::Acquire)
    }

    fn wall_ns(&self) -> u64 {
        self.now_ns()
    }
}

/// Sets the clock to a packet's arrival, sends its scans, and waits until all of them were seen.
struct Packets {
    clock: SetClock,
    n_seen: Arc<AtomicU64>,
    hello: Arc<Hello>,
    n_sent: u64,
    /// From a packet's last scan to its arrival.
    delay_ns: u64,
}

impl FrameSource for Packets {
    fn poll(&mut self, _: Duration, sink: &mut dyn FnMut(Message)) -> SourceStatus {
        let n_scans = u64::from(self.hello.n_scans);
        if self.n_seen.load(Ordering::Acquire) < self.n_sent * n_scans {
            std::thread::yield_now();
            return SourceStatus::Open;
        }
        match self.n_sent {
            0 => sink(Message::Hello(Arc::clone(&self.hello))),
            N_PACKETS => return SourceStatus::Ended,
            _ => {}
        }
        let first = self.n_sent * n_scans;
        let last_ns = (first + n_scans - 1) * PERIOD_NS;
        self.clock.0.store(last_ns + self.delay_ns, Ordering::Release);
        for scan in 0..n_scans {
            let counts = (0..N_GAUGES as i32).map(|g| g + (first + scan) as i32 % 7);
            let mut frame = Frame::new(self.n_sent as u32, SampleFormat::I32, counts);
            frame.scan = scan as u8;
            frame.t_host_ns = (first + scan) * PERIOD_NS;
            frame.t_device_us = frame.t_host_ns / 1000;
            sink(Message::Frame(frame));
        }
        self.n_sent += 1;
        SourceStatus::Open
    }

    fn stats(&self) -> SourceStats {
        SourceStats::default()
    }

    fn name(&self) -> String {
        "packets".to_owned()
    }
}

/// Frames and those of them that count as late at a deadline of 1 ms.
fn n_late(n_scans: u8, delay_ns: u64) -> (u64, u64) {
    let mut hello = Hello::plain(N_GAUGES, SampleFormat::I32, 1000);
    hello.n_scans = n_scans;
    hello.seal();
    let (clock, n_seen) = (SetClock::default(), Arc::<AtomicU64>::default());
    let source = Packets {
        clock: clock.clone(),
        n_seen: Arc::clone(&n_seen),
        hello: Arc::new(hello),
        n_sent: 0,
        delay_ns,
    };
    let probe = Probe::new(Delivery::Direct, move |_| {
        n_seen.fetch_add(1, Ordering::AcqRel);
        Ok(())
    });
    let params = LiveParams { tare_s: 0.0, clock: Arc::new(clock), ..LiveParams::default() };
    let live = Live::builder(source).params(params).estimator(Asked::default()).sink(probe);
    let health = live.start().unwrap().wait().unwrap();
    (health.n_frames, health.n_deadline_missed)
}

/// The first of several scans waits for the last one before anything can be here; that is nobody's fault.
#[test]
fn a_packets_age_counts_from_its_last_scan() {
    for n_scans in [1, 2, 4, 8] {
        let n = N_PACKETS * u64::from(n_scans);
        assert_eq!(n_late(n_scans, 300_000), (n, 0), "{n_scans} scans");
        assert_eq!(n_late(n_scans, 1_300_000), (n, n), "{n_scans} scans");
    }
}
