//! When `hapdef live` ends, and what it says then.

use anyhow::{Result, bail};
use hapdef_contact::printable;
use hapdef_daq::source::LinkState;
use hapdef_live::{Health, Live};

/// Names of the sinks on standard output.
const PRINTED: [&str; 2] = ["json", "text"];

/// Whether there is something to wait for: until the source has ended, nobody listens any more, or the device is
/// another than the gauges'.
pub(super) fn goes_on(live: &Live) -> bool {
    let is_in_vain = || {
        let health = live.health();
        let nobody_listens =
            !health.sinks.is_empty() && health.sinks.iter().all(|sink| sink.failure.is_some());
        nobody_listens || other_device(&health).is_some()
    };
    !live.has_ended() && !is_in_vain()
}

/// What waiting does not mend: why the device that is there can't be used.
fn other_device(health: &Health) -> Option<String> {
    match (&health.device_fault, &health.link) {
        (Some(fault), _) => Some(fault.to_string()),
        (None, Some(state @ LinkState::OtherChannels { .. })) => Some(state.to_string()),
        _ => None,
    }
}

/// The last line, whether there were frames, and frames that could be used, and whether all that was asked for was
/// written. Lines begin with `begin`. Standard output tells of its own faults.
pub(super) fn report(begin: &str, health: &Health) -> Result<()> {
    let total = &health.total;
    eprintln!(
        "{begin}{} frames, {} lost, {} dropped, {} late, {} refused; compute p50 {:.0} µs, p99 {:.0} µs, \
         longest {:.0} µs",
        health.n_frames,
        health.n_lost,
        health.n_dropped,
        health.n_deadline_missed,
        health.n_refused,
        total.compute.p50_us,
        total.compute.p99_us,
        total.compute.max_us,
    );
    if let Some(refusal) = &health.last_refusal {
        eprintln!("{begin}the estimator refused frames: {}", printable(refusal));
    }
    let name = &health.source_name;
    if let Some(fault) = &health.reader_fault {
        bail!("{name}: {fault}");
    }
    if let Some(fault) = other_device(health) {
        bail!("{name}: {fault}");
    }
    if health.n_frames == 0 {
        let link = health.link.as_ref();
        let link = link.map_or(String::new(), |link| format!(": {link}"));
        bail!("{name}: not one reading came{link}");
    }
    let elsewhere = health.sinks.iter().filter(|sink| !PRINTED.contains(&sink.name.as_str()));
    for sink in elsewhere {
        if let Some(failure) = &sink.failure {
            bail!("{} gave up: {failure}", sink.name);
        }
    }
    if let Some(state @ LinkState::Damaged { .. }) = &health.link {
        eprintln!("{begin}{}", printable(&format!("{name}: {state}")));
    }
    Ok(())
}
