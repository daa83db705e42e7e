//! A client that never reads its socket: it misses lines, which are counted as its own, and nobody else
//! does.
//!
//! HAPDEF_SOAK=1 lets it stall for a minute instead of 4 s.

use crate::support::endless;

use std::net::TcpStream;
use std::time::Duration;

use endless::Endless;
use hapdef_live::estimator::{TouchEstimator, TouchFrame};
use hapdef_live::sinks::JsonServer;
use hapdef_live::{Delivery, FnSink, Live, LiveError, Touch, Wants};

const N_CHANNELS: usize = 64;
const MOST_MIB: f64 = 16.0;

/// Finds nothing.
struct Nothing;

impl TouchEstimator for Nothing {
    fn name(&self) -> &'static str {
        "nothing"
    }

    fn n_gauges(&self) -> usize {
        N_CHANNELS
    }

    fn estimate_frame(&mut self, _: &TouchFrame<'_>, touch: &mut Touch) -> Result<(), LiveError> {
        touch.clear();
        Ok(())
    }

    fn start_over(&mut self) {}
}

fn rss_mib() -> f64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kib: f64 = line.unwrap().trim().trim_end_matches(" kB").parse().unwrap();
    kib / 1024.0
}

#[test]
fn a_socket_that_is_not_read_costs_its_reader_only() {
    let is_long = std::env::var_os("HAPDEF_SOAK").is_some();
    let stall = Duration::from_secs(if is_long { 60 } else { 4 });
    let server = JsonServer::bind("tcp:127.0.0.1:0").unwrap();
    let address = server.address().strip_prefix("tcp:").unwrap().to_owned();
    let seen = FnSink::new("program", Wants::TARED, |frame| {
        assert_eq!(frame.n_skipped_before, 0);
    });
    let live = Live::builder(Endless::new(N_CHANNELS))
        .sink(seen.with_delivery(Delivery::Queue(4096)))
        .sink(server)
        .estimator(Nothing)
        .start()
        .unwrap();
    let stalled = TcpStream::connect(&address).unwrap();
    let name = stalled.local_addr().unwrap().to_string();
    // The socket's and the server's own buffers are full by then.
    std::thread::sleep(Duration::from_secs(1));
    let before_mib = rss_mib();
    std::thread::sleep(stall);
    let growth_mib = rss_mib() - before_mib;
    let health = live.stop().unwrap();
    let [program, json] = &health.sinks[..] else {
        panic!("{health:?}");
    };
    println!("{growth_mib:.1} MiB more in {stall:?}; {health}");
    assert!(growth_mib <= MOST_MIB, "{growth_mib} MiB");
    assert_eq!((health.n_lost, health.n_dropped), (0, 0), "{health}");
    assert_eq!((program.n_frames, program.n_skipped), (health.n_frames, 0));
    assert!(health.n_frames as f64 > 800.0 * stall.as_secs_f64());
    let [client] = &json.clients[..] else {
        panic!("{json:?}");
    };
    assert_eq!(client.name, name);
    assert!(client.n_left_out > 1000, "{client:?}");
    assert!(health.to_string().contains("is too slow"), "{health}");
    drop(stalled);
}
