//! How the runtime is doing, once a second.

use std::fmt::{self, Display, Formatter};
use std::sync::Arc;

use hapdef_contact::{GaugeHealth, TouchPhase};
use hapdef_daq::source::{LinkState, SourceStats};

pub use crate::histogram::Latency;
use crate::tare_fault::TareFault;

/// What came to pass. Counts are since the start.
#[derive(Clone, Debug, Default)]
pub struct Health {
    /// Since the start, s.
    pub uptime_s: f64,
    /// Name of the source.
    pub source_name: String,
    /// Counts of the source: bytes, frames, losses, refused packets, rate, drift.
    pub source: SourceStats,
    /// What became of the link last.
    pub link: Option<LinkState>,
    /// Why nobody reads any more, where the reader has broken down.
    pub reader_fault: Option<Arc<str>>,
    /// Why real-time priority was not given although it was asked for, and what to do.
    pub realtime_fault: Option<Arc<str>>,
    /// Why the device's frames can't be used, and what to do.
    pub device_fault: Option<Arc<str>>,
    /// Frames that came through to the computing thread.
    pub n_frames: u64,
    /// Frames of this second, per second.
    pub rate_hz: f64,
    /// Packets lost before those frames, on the link or by the device.
    pub n_lost: u64,
    /// Frames dropped because the computing thread was too slow.
    pub n_dropped: u64,
    /// Frames that could not be used: before the first HELLO, or of an unsuitable device.
    pub n_unusable: u64,
    /// Restarts of the device.
    pub n_restarts: u64,
    /// Times the link came back.
    pub n_reconnects: u64,
    /// Frames that were conditioned.
    pub n_conditioned: u64,
    /// Frames that contacts were looked for in.
    pub n_estimated: u64,
    /// Of these, frames that the estimator refused.
    pub n_refused: u64,
    /// Why it refused the last of them.
    pub last_refusal: Option<Arc<str>>,
    /// Frames whose contacts came later than the deadline.
    pub n_deadline_missed: u64,
    /// As [`crate::estimator::TouchEstimator::n_late_searches`].
    pub n_late_searches: u64,
    /// Taring, untouched, touched or unknown; none before the first frame.
    pub phase: Option<TouchPhase>,
    /// Why the last tare was refused or does not hold.
    pub tare_fault: Option<Arc<TareFault>>,
    /// The last frame's contacts are stale.
    pub is_stale: bool,
    /// As [`crate::LiveFrame::smallest_seen_n`], of the last frame.
    pub smallest_seen_n: Option<f64>,
    /// Contacts of the last frame.
    pub n_contacts: usize,
    /// Why gauges don't count, as of the last frame `[n_gauges]`.
    pub gauges: Vec<GaugeHealth>,
    /// Noise of each gauge that is used, µε: the assumed one, or what the tare measured where
    /// that is surely larger; empty before the first tare `[n_gauges]`.
    pub noise_ue: Vec<f64>,
    /// Gauges that were measured to be noisier than assumed.
    pub n_noisier: usize,
    /// Times of this second.
    pub second: StageTimes,
    /// Times since the start.
    pub total: StageTimes,
    /// What became of the sinks.
    pub sinks: Vec<SinkHealth>,
}

/// Times of a frame, stage by stage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StageTimes {
    /// From the sample instant on the host's clock until the computing thread took it: the link's
    /// shortest delay is not in it. Not measured for replays.
    pub queue: Latency,
    /// Scaling, tare, drift, gauge faults.
    pub conditioning: Latency,
    /// The estimator.
    pub estimate: Latency,
    /// Handing over to the sinks, with those that run on the computing thread.
    pub sinks: Latency,
    /// From when the computing thread took it until it was handed over.
    pub compute: Latency,
}

/// What became of one sink.
#[derive(Clone, Debug, Default)]
pub struct SinkHealth {
    /// Its name.
    pub name: String,
    /// Frames it was given.
    pub n_frames: u64,
    /// Frames it was not given because it was too slow.
    pub n_skipped: u64,
    /// Events it was not given because it was too slow.
    pub n_events_dropped: u64,
    /// Times that it took for a frame.
    pub busy: Latency,
    /// Why it was given up, if it was.
    pub failure: Option<Arc<str>>,
    /// It did not end when everything ended.
    pub is_stuck: bool,
    /// Those that it serves at the moment.
    pub clients: Vec<ClientHealth>,
}

/// How one client of a sink is doing.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ClientHealth {
    /// Who it is, by its address.
    pub name: String,
    /// Lines that it was not sent because it was too slow.
    pub n_left_out: u64,
}

impl Health {
    /// Names of the gauges that don't count, by their number.
    fn bad_gauges(&self) -> impl Iterator<Item = (usize, GaugeHealth)> + '_ {
        let gauges = self.gauges.iter().copied().enumerate();
        gauges.filter(|(_, health)| *health != GaugeHealth::Good)
    }
}

impl Display for Health {
    /// One line.
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let phase: &dyn Display = self.phase.as_ref().map_or(&"waiting", |phase| phase);
        write!(
            f,
            "{:.0} Hz · {phase} · {}{} contacts · lost {} dropped {} · p50/p99 µs: queue {:.0}/{:.0} \
             compute {:.0}/{:.0} · deadline missed {}",
            self.rate_hz,
            if self.is_stale { "stale: " } else { "" },
            self.n_contacts,
            self.n_lost,
            self.n_dropped,
            self.second.queue.p50_us,
            self.second.queue.p99_us,
            self.second.compute.p50_us,
            self.second.compute.p99_us,
            self.n_deadline_missed,
        )?;
        for (gauge, health) in self.bad_gauges() {
            write!(f, " · gauge {gauge} {health:?}")?;
        }
        if self.n_noisier > 0 {
            let most_ue = self.noise_ue.iter().copied().fold(0.0, f64::max);
            let n = self.n_noisier;
            write!(f, " · {n} gauges noisier than assumed, up to {most_ue:.2} µε")?;
        }
        if self.n_restarts + self.n_reconnects > 0 {
            let (restarts, back) = (self.n_restarts, self.n_reconnects);
            write!(f, " · restarts {restarts} reconnects {back}")?;
        }
        if self.source.n_host_time > 0 {
            let n = self.source.n_host_time;
            write!(
                f,
                " · {n} readings timed by their arrival: the device's clock is not believed"
            )?;
        }
        if self.n_late_searches > 0 {
            let n = self.n_late_searches;
            write!(f, " · {n} searches came late: a replay may find other contacts")?;
        }
        if self.n_refused > 0 {
            write!(f, " · refused {}", self.n_refused)?;
        }
        if let Some(state) = self.link.as_ref().filter(|s| **s != LinkState::Open) {
            write!(f, " · {state}")?;
        }
        if let Some(fault) = &self.tare_fault {
            write!(f, " · {fault}")?;
        }
        let faults = [&self.reader_fault, &self.device_fault, &self.realtime_fault];
        for fault in faults.into_iter().flatten() {
            write!(f, " · {fault}")?;
        }
        for sink in &self.sinks {
            if let Some(failure) = &sink.failure {
                write!(f, " · {} gave up: {failure}", sink.name)?;
            } else if sink.n_skipped > 0 {
                write!(f, " · {} skipped {}", sink.name, sink.n_skipped)?;
            }
            for client in sink.clients.iter().filter(|c| c.n_left_out > 0) {
                let (name, n) = (&client.name, client.n_left_out);
                write!(f, " · {name} is too slow, {n} lines left out")?;
            }
        }
        Ok(())
    }
}
