//! Real-time priority of the reading thread, as the system grants it.
#![cfg(target_os = "linux")]

use crate::support;

use std::time::Duration;

use hapdef_daq::source::{StreamParams, StreamSource, memory_link};
use hapdef_daq::{AcquireParams, Message, acquire};
use support::wait_for;

const SECOND: Duration = Duration::from_secs(1);

/// `sched_setscheduler(2)`.
const SCHED_FIFO: u32 = 1;

#[test]
fn real_time_is_given_or_the_refusal_says_what_to_do() {
    let (link, device) = memory_link();
    let source = StreamSource::new(link, StreamParams::default());
    let params = AcquireParams { realtime_priority: Some(10), ..AcquireParams::default() };
    let (acquisition, mut receivers) = acquire(source, params).unwrap();
    wait_for(&mut receivers[0], SECOND, |m| matches!(m, Message::Link(_)).then_some(()));
    let has_fifo = threads_policies().contains(&SCHED_FIFO);
    device.end();
    match acquisition.stop().realtime_fault.as_deref() {
        None => assert!(has_fifo, "no thread runs as SCHED_FIFO"),
        // The priority may be given where memory is not.
        Some(fault) if fault.contains("locking") => {
            assert!(has_fifo && fault.contains("raise memlock"), "{fault}");
        }
        Some(fault) => {
            assert!(!has_fifo, "{fault}");
            let has_advice = fault.contains("raise rtprio") || fault.contains("build on Linux");
            assert!(has_advice, "{fault}");
        }
    }
}

/// What is reserved and not used costs no memory: it was a gigabyte.
#[test]
fn locked_memory_is_that_which_is_used() {
    let resident_mb = || {
        let status = std::fs::read_to_string("/proc/self/status").unwrap();
        let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
        line.trim().trim_end_matches(" kB").parse::<f64>().unwrap() / 1024.0
    };
    let before = resident_mb();
    let reserved = Vec::<u8>::with_capacity(4 << 30);
    let entered = std::thread::spawn(|| hapdef_daq::enter_realtime(1)).join().unwrap();
    let later = Vec::<u8>::with_capacity(4 << 30);
    let more_mb = resident_mb() - before;
    assert!(more_mb < 100.0, "{more_mb} MB more, {entered:?}");
    drop((reserved, later));
}

/// The scheduling policy of each thread of this process: field 41 of `stat`, proc(5).
fn threads_policies() -> Vec<u32> {
    let tasks = std::fs::read_dir("/proc/self/task").unwrap();
    let policy = |stat: String| {
        // The name in brackets, which may hold blanks, is the second field.
        let (_, rest) = stat.rsplit_once(')')?;
        rest.split_whitespace().nth(38)?.parse().ok()
    };
    let stats = tasks.map(|task| std::fs::read_to_string(task.unwrap().path().join("stat")));
    stats.filter_map(|stat| policy(stat.ok()?)).collect()
}
