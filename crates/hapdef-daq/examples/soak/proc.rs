//! What Linux says about this process: memory, and the time of a thread.

use std::fs;
use std::time::Duration;

/// Resident memory, MiB.
pub fn rss_mib() -> f64 {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|l| l.strip_prefix("VmRSS:")).unwrap();
    let kib: f64 = line.trim().trim_end_matches(" kB").parse().unwrap();
    kib / 1024.0
}

/// Processor time of the thread of that name (its first 15 letters).
pub fn thread_cpu(name: &str) -> Duration {
    let tasks = fs::read_dir("/proc/self/task").unwrap();
    let times = tasks.filter_map(|task| {
        let folder = task.ok()?.path();
        let comm = fs::read_to_string(folder.join("comm")).ok()?;
        let is_it = comm.trim_end() == &name[..name.len().min(15)];
        // First field of schedstat: time on the processor, ns.
        let stat = fs::read_to_string(folder.join("schedstat")).ok()?;
        let ns = stat.split(' ').next()?.parse().ok()?;
        is_it.then(|| Duration::from_nanos(ns))
    });
    times.sum()
}
