//! When `hapdef live` ends, and what it says then.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use hapdef_contact::printable;
use hapdef_daq::source::LinkState;
use hapdef_live::{Health, Live};

use super::live_record::{LiveRecorder, LiveRecorderState};

/// How often it looks whether to end.
const LOOK: Duration = Duration::from_millis(20);

/// Names of the sinks on standard output.
const PRINTED: [&str; 2] = ["json", "text"];

/// Until the source has ended, the person or `--seconds` ends it, nobody listens any more, or the device is
/// another than the gauges'. A recording that stops is reported at once; the rest goes on without it.
pub(super) fn wait(
    live: &Live,
    seconds: Option<f64>,
    recorder: Option<&LiveRecorder>,
    stop: &AtomicBool,
) {
    let start = Instant::now();
    let is_over = || seconds.is_some_and(|s| start.elapsed().as_secs_f64() >= s);
    let is_in_vain = || {
        let health = live.health();
        let nobody_listens =
            !health.sinks.is_empty() && health.sinks.iter().all(|sink| sink.failure.is_some());
        nobody_listens || other_device(&health).is_some()
    };
    let mut recorder = recorder;
    while !live.has_ended() && !stop.load(Ordering::Relaxed) && !is_over() && !is_in_vain() {
        if let Some(LiveRecorderState::Failed { why }) = recorder.map(LiveRecorder::state) {
            // Nobody may read it any more: what becomes of the recording is said in the end, too.
            eprintln!("the recording stopped: {}", printable(&why));
            recorder = None;
        }
        std::thread::sleep(LOOK);
    }
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
/// written. Standard output tells of its own faults.
pub(super) fn report(health: &Health) -> Result<()> {
    let total = &health.total;
    eprintln!(
        "{} frames, {} lost, {} dropped, {} late, {} refused; compute p50 {:.0} µs, p99 {:.0} µs, \
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
        eprintln!("the estimator refused frames: {}", printable(refusal));
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
        eprintln!("{}", printable(&format!("{name}: {state}")));
    }
    Ok(())
}
