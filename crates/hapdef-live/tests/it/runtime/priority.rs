//! Which threads have real-time priority.
#![cfg(target_os = "linux")]

use std::time::Duration;

use hapdef_daq::source::ReplaySource;
use hapdef_live::estimator::SearchPlace;
use hapdef_live::{FnSink, Live, LiveParams, Wants};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::support::world::{self, World};
use crate::support::{N_GAUGES, bundle, messages};

/// `sched_setscheduler(2)`.
const SCHED_FIFO: u32 = 1;

/// The policy of each thread of this name: field 41 of `stat`, proc(5).
fn policies(name: &str) -> Vec<u32> {
    let tasks = std::fs::read_dir("/proc/self/task").unwrap();
    let stats =
        tasks.filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("stat")).ok());
    let policy = |stat: String| {
        let (head, rest) = stat.rsplit_once(')')?;
        head.ends_with(&format!("({name}"))
            .then(|| rest.split_whitespace().nth(38)?.parse().ok())?
    };
    stats.filter_map(policy).collect()
}

/// A tare that is noisier than was assumed makes the estimator anew, in the computing thread: its searches take as
/// long as forty frames, and hold up nobody.
#[test]
fn searches_inherit_no_real_time_priority() {
    let world = World::new(N_GAUGES, 400, 5);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let noisy = |_| {
        let mut readings = vec![0.0; N_GAUGES];
        world::add_noise(&mut readings, 8.0, &mut rng);
        readings
    };
    let readings: Vec<Vec<f64>> = (0..1000).map(noisy).collect();
    let bundle = bundle(&world);
    let source = ReplaySource::new("memory", messages(&readings).into_iter(), 1.0);
    let params = LiveParams { tare_s: 0.2, realtime_priority: Some(10), ..LiveParams::default() };
    let live = Live::builder(source)
        .bundle(&bundle)
        .params(params)
        .estimator(bundle.tracking(SearchPlace::Background).unwrap())
        .sink(FnSink::new("robot", Wants::CONTACTS, |_| ()))
        .start()
        .unwrap();
    std::thread::sleep(Duration::from_millis(600));
    let (searching, computing) = (policies("contact search"), policies("hapdef-compute"));
    let health = live.stop().unwrap();
    assert!(health.n_frames > 300 && health.n_noisier > 0, "{health}");
    assert!(searching.len() >= 2 && !searching.contains(&SCHED_FIFO), "{searching:?}");
    let is_granted = health.realtime_fault.is_none();
    assert_eq!(computing.contains(&SCHED_FIFO), is_granted, "{computing:?}");
}
