//! The computer: disk, cores, real-time limits.

use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::time::{Duration, Instant};

use rustix::process::{Resource, getrlimit, getuid};

use super::check::{Check, State};
use hapdef_cli::shown;

/// Bytes that are written to measure the disk.
const TRIAL_LEN: usize = 1 << 20;
const N_TRIALS: usize = 8;
/// Longest sync that a recording's flushes are not delayed by.
const SLOW_SYNC: Duration = Duration::from_millis(100);
/// An hour of 64 channels at 1 kHz.
const HOUR_BYTES: u64 = 2 << 30;
/// Room that a recording asks for before it begins.
const LEAST_BYTES: u64 = 64 << 20;

pub(super) fn checks(folder: &Path) -> Vec<Check> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let rtprio = getrlimit(Resource::Rtprio).current;
    let memlock = getrlimit(Resource::Memlock).current;
    vec![
        space(folder),
        speed(folder),
        core_count(cores),
        granted(realtime(rtprio, memlock, getuid().is_root())),
    ]
}

fn space(folder: &Path) -> Check {
    let stat = match rustix::fs::statvfs(folder) {
        Ok(stat) => stat,
        Err(error) => {
            let fix = format!("name a folder that is there: {}", shown(folder));
            return Check::bad("disk space", error.to_string(), fix);
        }
    };
    let free = stat.f_bavail.saturating_mul(stat.f_frsize);
    let found = format!("{:.1} GB free in {}", free as f64 * 1e-9, shown(folder));
    let fix = "make room or record elsewhere: 64 channels at 1 kHz take 2 GB an hour";
    if free < LEAST_BYTES {
        Check::bad("disk space", found, fix)
    } else if free < HOUR_BYTES {
        Check::warn("disk space", found, fix)
    } else {
        Check::ok("disk space", found)
    }
}

fn speed(folder: &Path) -> Check {
    let trial = folder.join(format!(".hapdef-doctor-{}", std::process::id()));
    let measured = write_speed(&trial);
    let _ = std::fs::remove_file(&trial);
    match measured {
        Ok((bytes_per_s, worst)) => {
            let found = format!(
                "{:.0} MB/s, {} ms for the slowest sync",
                bytes_per_s * 1e-6,
                worst.as_millis()
            );
            if worst <= SLOW_SYNC {
                Check::ok("disk speed", found)
            } else {
                let fix = "record to a faster disk, or after a loss of power more than 150 ms of \
                           readings may be missing";
                Check::warn("disk speed", found, fix)
            }
        }
        Err(error) => Check::bad(
            "disk speed",
            format!("{}: {error}", shown(folder)),
            "choose a folder that you may write to with --folder",
        ),
    }
}

/// Bytes per second, synced, and the longest sync.
fn write_speed(path: &Path) -> std::io::Result<(f64, Duration)> {
    let mut file = File::create_new(path)?;
    let bytes = vec![0x5a; TRIAL_LEN];
    let start = Instant::now();
    let mut worst = Duration::ZERO;
    for _ in 0..N_TRIALS {
        file.write_all(&bytes)?;
        let before = Instant::now();
        file.sync_data()?;
        worst = worst.max(before.elapsed());
    }
    let n_bytes = (N_TRIALS * TRIAL_LEN) as f64;
    Ok((n_bytes / start.elapsed().as_secs_f64(), worst))
}

fn core_count(n: usize) -> Check {
    let found = format!("{n}");
    if n >= 2 {
        return Check::ok("cores", found);
    }
    let fix = "give the program two cores: one reads, one computes";
    Check::warn("cores", found, fix)
}

/// What the limits allow, tried: a container may refuse it all the same.
fn granted(by_limits: Check) -> Check {
    let tried = std::thread::spawn(|| hapdef_daq::enter_realtime(1)).join();
    match tried {
        Ok(Ok(())) => Check::ok("real time", "priority and locked memory are granted"),
        Ok(Err(fault)) if by_limits.state == State::Ok => Check::warn(
            "real time",
            fault,
            "in a container: grant SYS_NICE and IPC_LOCK, as by --cap-add, and real-time run time",
        ),
        _ => by_limits,
    }
}

/// `None` is without limit.
fn realtime(rtprio: Option<u64>, memlock: Option<u64>, is_root: bool) -> Check {
    let may = is_root || rtprio.is_none_or(|limit| limit > 0);
    let may_lock = is_root || memlock.is_none_or(|limit| limit >= 256 << 20);
    match (may, may_lock) {
        (true, true) => Check::ok("real time", "priority and locked memory are allowed"),
        (false, _) => Check::warn(
            "real time",
            "the reading thread may have no real-time priority",
            "@realtime - rtprio 90 and @realtime - memlock unlimited in \
             /etc/security/limits.conf, join the group realtime, log in again",
        ),
        (true, false) => Check::warn(
            "real time",
            "memory may not be locked",
            "@realtime - memlock unlimited in /etc/security/limits.conf, log in again",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_measured_and_left_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let speed = speed(folder.path());
        assert_ne!(speed.state, State::Bad, "{speed}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        let nowhere = folder.path().join("nowhere");
        assert_eq!(super::speed(&nowhere).state, State::Bad);
        assert_eq!(space(&nowhere).state, State::Bad);
    }

    #[test]
    fn limits_that_stand_in_the_way_are_named() {
        assert_eq!(realtime(None, None, false).state, State::Ok);
        assert_eq!(realtime(Some(0), Some(0), true).state, State::Ok);
        let none = realtime(Some(0), Some(65536), false);
        assert!(none.fix.unwrap().contains("rtprio"));
        let some = realtime(Some(90), Some(65536), false);
        assert!(some.fix.unwrap().contains("memlock"));
        assert_eq!(core_count(1).state, State::Warn);
    }
}
