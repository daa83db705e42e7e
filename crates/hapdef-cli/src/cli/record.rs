//! `hapdef record`: readings to a file that survives.

use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use clap::Args;
use hapdef::{SOURCE_FORMS, SourceArg};
use hapdef_cli::{print_json, shown};
use hapdef_contact::printable;
use hapdef_daq::record::{RecordParams, RecordStats, Recorder, check_unclaimed, record};
use hapdef_daq::source::{LinkState, SourceStats};
use hapdef_daq::{AcquireParams, Acquisition, Message, Receiver, acquire};
use serde_json::json;

use super::signals::stop_flag;
use super::topic::TopicArgs;

#[derive(Args)]
#[command(after_help = "Example:\n  \
    hapdef record --source serial:/dev/serial/by-id/usb-Arduino_Due --seconds 60 -o press.mcap\n\n\
    Ctrl-C and SIGTERM finish the file; until then it is called press.partial.mcap, and what was\n\
    written can be read. Readings are kept raw; a calibration is kept beside them as it is.")]
pub(crate) struct RecordArgs {
    #[arg(long, help = format!("Where readings come from: {SOURCE_FORMS}"))]
    source: SourceArg,
    #[command(flatten)]
    topic: TopicArgs,
    /// The recording.
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
    /// Stop after so many seconds.
    #[arg(long, value_parser = seconds)]
    seconds: Option<Duration>,
    /// Calibration in use, a JSON file: kept in the recording as it is.
    #[arg(long)]
    calibration: Option<PathBuf>,
    /// Real-time priority of the reading thread, 1 to 99.
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..=99))]
    realtime: Option<u8>,
    /// Overwrite a recording of the same name, and what is left of one that was broken off.
    #[arg(long)]
    force: bool,
    /// Print what was recorded as JSON.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &RecordArgs) -> Result<()> {
    let out = &args.out;
    let source = args.topic.of(&args.source)?;
    if !args.force && out.exists() {
        bail!("{}: is there already; choose another name or say --force", shown(out));
    }
    let read =
        |path: &PathBuf| std::fs::read(path).with_context(|| format!("{}: reading", shown(path)));
    let params = RecordParams {
        calibration: args.calibration.as_ref().map(read).transpose()?,
        source: source.to_string(),
        overwrites: args.force,
        ..RecordParams::default()
    };
    let acquire_params = AcquireParams {
        n_receivers: 2,
        realtime_priority: args.realtime,
        ..AcquireParams::default()
    };
    // The device has one host: who is refused must not take it from who records.
    check_unclaimed(out)?;
    let stop = stop_flag()?;
    let (acquisition, receivers) = acquire(source.open()?, acquire_params)?;
    let [for_file, for_us]: [Receiver; 2] =
        receivers.try_into().map_err(|_| anyhow::anyhow!("two receivers were asked for"))?;
    let recorder = record(for_file, out, params)?;
    let mut watch = Watch::new(acquisition, for_us, hapdef_cli::is_quiet());
    while !stop.load(Ordering::Relaxed) && watch.goes_on(&recorder, args.seconds) {}
    let Watch { acquisition, link, n_restarts, n_exchanges, .. } = watch;
    let acquired = acquisition.stop();
    let stats = acquired.source;
    let info = recorder.finish()?;
    if acquired.is_panicked {
        bail!(
            "{}: the reader's thread panicked; the readings until then are in {}",
            source,
            shown(out)
        );
    }
    if info.n_frames == 0 {
        let link = link.map_or(String::new(), |link| format!(": {link}"));
        bail!("{}: not one reading came{link}", shown(out));
    }
    if args.json {
        let happened = json!({
            "out": out,
            "n_frames": info.n_frames,
            "n_bytes": info.n_bytes,
            "n_lost": stats.losses.n_lost,
            "n_refused": n_refused(&stats),
            "n_dropped": info.n_dropped,
            "n_events_dropped": info.n_events_dropped,
            "n_host_time": stats.n_host_time,
            "n_restarts": n_restarts,
            "n_exchanges": n_exchanges,
        });
        print_json(&happened, false)?;
    } else {
        println!(
            "{}: {} frames, {} bytes; {} packets lost on the way, {} refused, {} frames dropped",
            shown(out),
            info.n_frames,
            info.n_bytes,
            stats.losses.n_lost,
            n_refused(&stats),
            info.n_dropped,
        );
    }
    if n_restarts > 0 {
        eprintln!("{n_restarts} restarts of the device, {n_exchanges} times another one came");
    }
    if stats.n_host_time > 0 {
        eprintln!(
            "{} readings are timed by their arrival: the device's clock was not believed",
            stats.n_host_time
        );
    }
    if info.n_events_dropped > 0 {
        eprintln!(
            "{} messages of the device, such as STATUS, were dropped: the disk was too slow",
            info.n_events_dropped
        );
    }
    Ok(())
}

/// Looks at a recording while it goes on.
struct Watch {
    acquisition: Acquisition,
    messages: Receiver,
    link: Option<LinkState>,
    uid: Option<[u8; 16]>,
    n_restarts: u64,
    n_exchanges: u64,
    start: Instant,
    n_lines: u32,
    is_quiet: bool,
}

impl Watch {
    fn new(acquisition: Acquisition, messages: Receiver, is_quiet: bool) -> Self {
        Self {
            acquisition,
            messages,
            link: None,
            uid: None,
            n_restarts: 0,
            n_exchanges: 0,
            start: Instant::now(),
            n_lines: 0,
            is_quiet,
        }
    }

    /// Waits a little and says how it goes; false when it is over.
    fn goes_on(&mut self, recorder: &Recorder, limit: Option<Duration>) -> bool {
        while let Some(message) = self.messages.try_recv() {
            match message {
                Message::Link(state) => {
                    eprintln!("link: {}", printable(&state.to_string()));
                    // A clock says nothing of the link.
                    if !matches!(state, LinkState::Clock(_)) {
                        self.link = Some(state);
                    }
                }
                Message::Restarted => {
                    self.n_restarts += 1;
                    eprintln!("the device started anew, or another one took its place");
                }
                Message::Hello(hello) if self.uid.is_some_and(|uid| uid != hello.uid) => {
                    self.n_exchanges += 1;
                    self.uid = Some(hello.uid);
                    eprintln!("another device: {}", hello.uid.escape_ascii());
                }
                Message::Hello(hello) => self.uid = Some(hello.uid),
                _ => {}
            }
        }
        let elapsed = self.start.elapsed();
        let stats = recorder.stats();
        if elapsed >= Duration::from_secs(1) * (self.n_lines + 1) {
            self.n_lines += 1;
            let acquired = self.acquisition.stats();
            if self.n_lines == 1
                && let Some(fault) = &acquired.realtime_fault
            {
                eprintln!("{fault}");
            }
            if !self.is_quiet {
                eprintln!("{}", health_line(self.n_lines, &acquired.source, &stats));
            }
        }
        let is_over = stats.fault.is_some()
            || matches!(self.link, Some(LinkState::OtherChannels { .. }))
            || limit.is_some_and(|limit| elapsed >= limit)
            || self.acquisition.has_ended();
        let pause = limit.map_or(Duration::MAX, |limit| limit.saturating_sub(elapsed));
        std::thread::sleep(pause.min(Duration::from_millis(20)));
        !is_over
    }
}

/// How it goes, in a line.
pub(super) fn health_line(seconds: u32, source: &SourceStats, recorded: &RecordStats) -> String {
    format!(
        "{seconds} s: {:.1} Hz, {} frames, {} lost, {} refused, {} dropped, {:.1} MB, flush {} ms \
         at worst, clock {:+.1} ppm",
        source.rate_hz,
        recorded.n_frames,
        source.losses.n_lost,
        n_refused(source),
        recorded.n_dropped,
        recorded.n_bytes as f64 * 1e-6,
        recorded.worst_flush.as_millis(),
        source.drift_ppm,
    )
}

/// Packets and lines that came damaged, twice, or in another form than announced.
pub(super) fn n_refused(source: &SourceStats) -> u64 {
    let rejected = source.rejected;
    rejected.n_damaged
        + rejected.n_version
        + rejected.n_schema
        + rejected.n_malformed
        + rejected.n_repeats
        + rejected.n_backwards
        + source.lines.n_refused
}

/// A time on the command line, s.
pub(super) fn seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse().ok().filter(|s: &f64| *s > 0.0);
    let duration = seconds.and_then(|s| Duration::try_from_secs_f64(s).ok());
    duration.ok_or_else(|| "expected seconds, more than 0".to_owned())
}
