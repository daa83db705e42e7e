//! The computing thread: from messages to frames with contacts.

mod cause;
mod conditioning;
mod tare;

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use hapdef_contact::TouchPhase;
use hapdef_daq::hdp1::Hello;
use hapdef_daq::source::LinkState;
use hapdef_daq::{AcquireStats, Frame, Message, Receiver, without_realtime};

use super::counts::Counts;
use super::device::Device;
use super::outlet::Outlet;
use super::stages::{Stage, Stages};
use super::trust::{Signs, Trust};
use super::{LiveGauge, LiveParams, Shared};
use crate::estimator::{TouchEstimator, TouchFrame};
use crate::frame::LiveFrame;
use crate::health::Health;
use crate::signals::GivenLoads;
use crate::sink::{LiveEvent, Wants};
use conditioning::Conditioning;
use tare::TareWatch;

/// Longest wait for a message, so that a stop is seen.
const POLL: Duration = Duration::from_millis(20);

const SECOND_NS: u64 = 1_000_000_000;

const READER_PANICKED: &str = "the reader's thread panicked: report this with what it read from";

/// What the thread is given.
pub(super) struct Setup {
    pub(super) params: LiveParams,
    pub(super) noise_ue: f64,
    pub(super) gauges: Vec<LiveGauge>,
    pub(super) n_gauges: Option<usize>,
    pub(super) given: GivenLoads,
    pub(super) estimator: Option<Box<dyn TouchEstimator>>,
    pub(super) wants: Wants,
    pub(super) source_name: String,
}

/// What came to pass at the source.
pub(super) type TellStats = Box<dyn Fn() -> Arc<AcquireStats> + Send>;

/// The thread's state.
pub(super) struct Compute {
    setup: Setup,
    stats: TellStats,
    outlets: Vec<Box<dyn Outlet>>,
    shared: Arc<Shared>,
    device: Option<Device>,
    conditioning: Option<Conditioning>,
    tare_watch: TareWatch,
    trust: Trust,
    frame: LiveFrame,
    counts: Counts,
    stages: Stages,
    start_ns: u64,
    second_ns: u64,
    n_before: u64,
    /// A refusal of this second was put into words already.
    is_refusal_reported: bool,
}

impl Compute {
    pub(super) fn new(
        setup: Setup,
        stats: TellStats,
        outlets: Vec<Box<dyn Outlet>>,
        shared: Arc<Shared>,
    ) -> Self {
        let start_ns = setup.params.clock.now_ns();
        Self {
            frame: empty(setup.n_gauges.unwrap_or(0)),
            trust: Trust::new(setup.params.stale_after, setup.params.unknown_after, start_ns),
            setup,
            stats,
            outlets,
            shared,
            device: None,
            conditioning: None,
            tare_watch: TareWatch::default(),
            counts: Counts::default(),
            stages: Stages::new(),
            start_ns,
            second_ns: start_ns,
            n_before: 0,
            is_refusal_reported: false,
        }
    }

    /// Until the source has ended or it is stopped.
    pub(super) fn run(mut self, mut receiver: Receiver) {
        if let Some(priority) = self.setup.params.computing_priority() {
            // The reader says what is refused.
            let _ = hapdef_daq::enter_realtime(priority);
        }
        while !self.shared.stop.load(Ordering::Acquire) {
            let is_last = receiver.has_ended();
            match receiver.recv(POLL) {
                Some(message) => self.take_in(message),
                None if is_last => break,
                None => {}
            }
            self.turn();
        }
        self.end();
    }

    /// Takes a message of the source.
    pub(super) fn take_in(&mut self, message: Message) {
        self.shared.n_taken.fetch_add(1, Ordering::Release);
        self.message(message);
    }

    /// What is to be done now and then beside messages.
    pub(super) fn turn(&mut self) {
        if self.shared.tare.swap(false, Ordering::AcqRel) {
            self.tare();
        }
        self.wait();
        if self.now_ns() >= self.second_ns + SECOND_NS {
            self.tell_health();
        }
    }

    /// There will be no more messages.
    pub(super) fn end(&mut self) {
        self.tell_health();
        self.outlets.iter_mut().for_each(|outlet| outlet.end());
    }

    fn message(&mut self, message: Message) {
        match message {
            Message::Frame(frame) => self.take(&frame),
            Message::Hello(hello) => self.hello(hello),
            Message::Restarted => {
                self.counts.n_restarts += 1;
                self.start_over();
                self.tell(&LiveEvent::Restarted);
            }
            Message::Link(state) => {
                match &state {
                    LinkState::Open => self.counts.n_opened += 1,
                    LinkState::Away(_) => {
                        self.start_over();
                        self.tare_watch.has_gap = true;
                    }
                    _ => {}
                }
                // A clock that jumped is counted, and the link is as it was.
                if !matches!(state, LinkState::Clock(_)) {
                    self.counts.link = Some(state.clone());
                }
                self.tell(&LiveEvent::Link(state));
            }
            Message::Status(status) => {
                if let Some(device) = &mut self.device {
                    device.take_status(status);
                }
                self.tell(&LiveEvent::Status(status));
            }
            Message::Log(text) => self.tell(&LiveEvent::Log(text)),
            Message::RoundTrip(_) => {}
        }
    }

    fn take(&mut self, frame: &Frame) {
        let taken_ns = self.now_ns();
        self.counts.n_frames += 1;
        self.counts.n_lost += u64::from(frame.n_lost_before);
        self.counts.n_dropped += u64::from(frame.n_dropped_before);
        if !self.read(frame) {
            self.counts.n_unusable += 1;
            return;
        }
        self.trust.hear(taken_ns);
        self.condition();
        let conditioned_ns = self.now_ns();
        self.estimate();
        let done_ns = self.now_ns();
        // When a recorded frame was done says nothing, and a replay is to be the same each time.
        self.frame.t_done_ns =
            if self.setup.params.is_recorded { frame.t_host_ns } else { done_ns };
        for outlet in &mut self.outlets {
            outlet.frame(&self.frame, &self.shared.stop);
        }
        let end_ns = self.now_ns();
        let stages = &mut self.stages;
        stages.add(Stage::Conditioning, conditioned_ns - taken_ns);
        stages.add(Stage::Estimate, done_ns - conditioned_ns);
        stages.add(Stage::Sinks, end_ns - done_ns);
        stages.add(Stage::Compute, end_ns - taken_ns);
        let queued_ns = taken_ns.saturating_sub(frame.t_host_ns);
        let mut latency_ns = done_ns - taken_ns;
        if !self.setup.params.is_recorded {
            stages.add(Stage::Queue, queued_ns);
            let rest_ns = self.device.as_ref().map_or(0, |d| d.rest_of_packet_ns(frame.scan));
            latency_ns += queued_ns.saturating_sub(rest_ns);
        }
        let deadline_ns = self.setup.params.deadline.as_nanos();
        self.counts.n_deadline_missed += u64::from(u128::from(latency_ns) > deadline_ns);
    }

    /// Takes over what the source says of a frame; false if it can't be used.
    fn read(&mut self, frame: &Frame) -> bool {
        let Some(device) = &mut self.device else {
            return false;
        };
        let to = &mut self.frame;
        if self.setup.wants.has_raw() {
            let Some(temperature) = device.read(frame, &mut to.raw_ue) else {
                return false;
            };
            to.temperature = temperature;
            device.read_signals(frame.t_device_us, &mut to.signals);
        }
        (to.seq, to.scan, to.flags) = (frame.seq, frame.scan, frame.flags);
        to.n_lost_before = frame.n_lost_before;
        to.n_dropped_before = frame.n_dropped_before;
        to.n_skipped_before = 0;
        (to.t_device_us, to.t_host_ns) = (frame.t_device_us, frame.t_host_ns);
        true
    }

    /// Says what is known while no frame comes.
    fn wait(&mut self) {
        if self.setup.params.is_recorded {
            return;
        }
        if let Some(status) = self.trust.wait(&mut self.frame, self.setup.params.clock.now_ns()) {
            self.tell(&LiveEvent::Phase(status));
        }
    }

    fn estimate(&mut self) {
        let wants = self.setup.wants;
        let to = &mut self.frame;
        to.touch.clear();
        (to.is_stale, to.smallest_seen_n) = (false, None);
        let has_zero = to.phase.is_known();
        let Some(estimator) = &mut self.setup.estimator else {
            return;
        };
        if !wants.has_contacts() || !has_zero {
            return;
        }
        self.counts.n_estimated += 1;
        let live = self.conditioning.as_ref().map(|c| &c.out.live[..]);
        let frame = TouchFrame { readings_ue: &to.tared_ue, live, wanted: wants.of_touch() };
        let found = estimator.estimate_frame(&frame, &mut to.touch);
        let is_refused = found.is_err();
        if let Err(error) = found {
            to.touch.clear();
            self.counts.n_refused += 1;
            if !std::mem::replace(&mut self.is_refusal_reported, true) {
                self.counts.last_refusal = Some(error.to_string().into());
            }
        }
        self.judge_contacts();
        let conditioning = self.conditioning.as_ref();
        let signs = Signs {
            sight: self.setup.estimator.as_ref().and_then(|estimator| estimator.sight()),
            live: conditioning.map(|c| &c.out.live[..]),
            blur: conditioning.map_or(1.0, Conditioning::blur),
            is_frozen: conditioning.is_some_and(|c| c.frozen.is_whole()),
            is_refused,
        };
        self.trust.judge(&mut self.frame, &signs);
    }

    fn hello(&mut self, hello: Arc<Hello>) {
        let setup = &self.setup;
        let found =
            Device::new(Arc::clone(&hello), &setup.gauges, setup.n_gauges, setup.params.rate_hz);
        let is_same = match (&found, &self.device) {
            (Ok(found), Some(before)) => found.is_same(before),
            _ => false,
        };
        match found.and_then(|device| self.prepare(device, is_same)) {
            Ok(()) => self.counts.device_fault = None,
            Err(fault) => {
                self.device = None;
                self.counts.device_fault = Some(fault.into());
                // Whoever started this can do nothing but end it.
                self.tell_health();
            }
        }
        self.tell(&LiveEvent::Hello(hello));
    }

    /// Frames of `device` come from now on; the same one with the same schema keeps its tare.
    fn prepare(&mut self, device: Device, is_same: bool) -> Result<(), String> {
        if let Some(estimator) = &mut self.setup.estimator {
            let accepted = estimator.set_frame_period(device.period_s);
            accepted.map_err(|error| error.to_string())?;
        }
        if !is_same {
            let least_ue = self.assumed_noise_ue(&device);
            let priority = self.setup.params.computing_priority();
            if let Some(estimator) = &mut self.setup.estimator {
                let accepted = without_realtime(priority, || estimator.set_least_noise(&least_ue));
                accepted.map_err(|error| error.to_string())?;
            }
            self.check_given(&device)?;
            let conditioning = self.conditioning(&device);
            self.conditioning = conditioning.map_err(|error| error.to_string())?;
            self.frame = empty(device.n_gauges());
            self.trust.start_over();
            self.tare_watch = TareWatch::new(device.n_gauges());
        }
        self.device = Some(device);
        Ok(())
    }

    fn start_over(&mut self) {
        self.trust.start_over();
        if let Some(estimator) = &mut self.setup.estimator {
            estimator.start_over();
        }
    }

    fn tell(&mut self, event: &LiveEvent) {
        self.outlets.iter_mut().for_each(|outlet| outlet.event(event));
    }

    fn tell_health(&mut self) {
        let now_ns = self.now_ns();
        let passed_s = (now_ns - self.second_ns) as f64 * 1e-9;
        let stats = (self.stats)();
        let (second, total) = self.stages.end_second();
        let n_new = self.counts.n_frames - self.n_before;
        let has_frames = self.counts.n_frames > self.counts.n_unusable;
        let mut health = Health {
            uptime_s: (now_ns - self.start_ns) as f64 * 1e-9,
            source_name: self.setup.source_name.clone(),
            source: stats.source,
            realtime_fault: stats.realtime_fault.clone(),
            reader_fault: stats.is_panicked.then(|| READER_PANICKED.into()),
            rate_hz: n_new as f64 / passed_s.max(1e-9),
            phase: has_frames.then_some(self.frame.phase),
            is_stale: has_frames && self.frame.is_stale,
            smallest_seen_n: self.frame.smallest_seen_n,
            n_contacts: self.frame.touch.contacts.len(),
            n_late_searches: self.setup.estimator.as_ref().map_or(0, |e| e.n_late_searches()),
            gauges: self.frame.gauges.clone(),
            second,
            total,
            sinks: self.outlets.iter().map(|outlet| outlet.health()).collect(),
            ..Health::default()
        };
        self.counts.fill(&mut health);
        (self.second_ns, self.n_before) = (now_ns, self.counts.n_frames);
        self.is_refusal_reported = false;
        let health = Arc::new(health);
        self.shared.set_health(Arc::clone(&health));
        self.tell(&LiveEvent::Health(health));
    }

    fn now_ns(&self) -> u64 {
        self.setup.params.clock.now_ns()
    }
}

/// A frame before any has come: nothing is known.
fn empty(n_gauges: usize) -> LiveFrame {
    LiveFrame { phase: TouchPhase::Taring, ..LiveFrame::new(n_gauges) }
}
