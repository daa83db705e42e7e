//! The runtime: a reader, a computing thread, a thread for each sink.

pub(crate) mod channels;
mod compute;
mod counts;
mod device;
mod frozen;
mod noise;
mod outlet;
mod sink_worker;
mod source;
mod stages;
mod steps;
mod trust;

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use hapdef_daq::clock::{HostClock, SystemClock};
use hapdef_daq::source::FrameSource;
use hapdef_daq::{AcquireParams, Receiver, acquire};
use hapdef_inverse::ConditionerParams;

use crate::bundle::Bundle;
use crate::error::{LiveError, check_not_negative, check_positive};
use crate::estimator::TouchEstimator;
use crate::health::Health;
use crate::runtime::compute::{Compute, Setup};
use crate::runtime::outlet::Outlet;
use crate::runtime::sink_worker::{SinkThread, SinkWorker};
use crate::runtime::source::{InFlight, LiveSource};
use crate::signals::GivenLoads;
use crate::sink::{Sink, Wants};
use crate::tare_fault::Retare;

pub use steps::LiveSteps;
pub use trust::BLIND_SHARE;

/// How long a sink may take to end, unless the runtime is lossless.
const PATIENCE: Duration = Duration::from_secs(2);

/// How the runtime works.
#[derive(Clone)]
pub struct LiveParams {
    /// Time whose mean is the tare, s; 0 where the device sends tared readings: nothing is taken
    /// off then, and no gauge but one without a number is left out.
    pub tare_s: f64,
    /// Standard deviation of a reading's noise, µε; the bundle's, or 1, if `None`. The converter's
    /// steps are added.
    pub noise_ue: Option<f64>,
    /// Frames per second of a device that doesn't say.
    pub rate_hz: f64,
    /// Parameters of conditioning; noise, period, tare and rails in it are replaced. Its defaults if
    /// `None`.
    pub conditioning: Option<ConditionerParams>,
    /// What becomes of a zero that was taken while something pressed unseen, once that lets go.
    pub retare: Retare,
    /// Time from the sample instant to the contacts beyond which a frame counts as late; where a packet has
    /// several scans, from the last of them.
    pub deadline: Duration,
    /// Time without a usable frame after which contacts are stale; not for recordings …
    pub stale_after: Duration,
    /// … and after which the phase is unknown and they are let go.
    pub unknown_after: Duration,
    /// The frames' times are those of a recording: how long frames waited is unknown.
    pub is_recorded: bool,
    /// For recordings as fast as they go: nothing is left out, and the source waits for the slowest
    /// sink.
    pub is_lossless: bool,
    /// Further receivers of what the source says, for recording; see [`Live::take_receivers`].
    pub n_receivers: usize,
    /// Messages that wait for the computing thread at most.
    pub ring_len: usize,
    /// Real-time priority of the reader's thread, and one less of the computing thread; see
    /// [`AcquireParams`].
    pub realtime_priority: Option<u8>,
    /// The host's clock: the one that the source has.
    pub clock: Arc<dyn HostClock>,
}

/// A gauge: which channel it is, and its scale.
#[derive(Clone, Debug, PartialEq)]
pub struct LiveGauge {
    /// Its name; a channel of that name (its first four letters, upper or lower case) is it. Where
    /// not every gauge has such a channel, the bridges are taken in their order.
    pub name: String,
    /// What the channel's value in µε is multiplied by.
    pub scale: f64,
}

/// Puts a runtime together.
pub struct LiveBuilder {
    source: Box<dyn FrameSource>,
    params: LiveParams,
    gauges: Vec<LiveGauge>,
    noise_ue: f64,
    given: GivenLoads,
    estimator: Option<Box<dyn TouchEstimator>>,
    sinks: Vec<Box<dyn Sink>>,
}

/// A running runtime. Dropping it stops it.
pub struct Live {
    shared: Arc<Shared>,
    compute: Option<JoinHandle<()>>,
    /// With their places in [`Health::sinks`].
    sinks: Vec<(usize, SinkThread)>,
    receivers: Vec<Receiver>,
    is_lossless: bool,
}

/// Stops or tares a runtime from any thread.
#[derive(Clone)]
pub struct LiveControl {
    shared: Arc<Shared>,
}

/// What the threads have in common.
struct Shared {
    stop: AtomicBool,
    tare: AtomicBool,
    /// Messages that the computing thread has taken.
    n_taken: AtomicU64,
    health: Mutex<Arc<Health>>,
}

impl Default for LiveParams {
    fn default() -> Self {
        Self {
            tare_s: 1.0,
            noise_ue: None,
            rate_hz: 1000.0,
            conditioning: None,
            retare: Retare::Ask,
            deadline: Duration::from_millis(1),
            // a hundred frames at 1 kHz: longer than a busy machine or a link makes one wait
            stale_after: Duration::from_millis(100),
            unknown_after: Duration::from_millis(300),
            is_recorded: false,
            is_lossless: false,
            n_receivers: 0,
            ring_len: AcquireParams::default().ring_len,
            realtime_priority: None,
            clock: Arc::new(SystemClock),
        }
    }
}

impl LiveParams {
    /// One less than the reader's, which then loses nothing while frames are computed.
    fn computing_priority(&self) -> Option<u8> {
        self.realtime_priority.map(|priority| priority.saturating_sub(1).max(1))
    }

    fn check(&self) -> Result<(), LiveError> {
        check_not_negative("tare_s", self.tare_s)?;
        check_positive("rate_hz", self.rate_hz)?;
        if let Some(noise_ue) = self.noise_ue {
            check_positive("noise_ue", noise_ue)?;
        }
        Ok(())
    }
}

impl LiveBuilder {
    /// How it works; the defaults otherwise.
    #[must_use]
    pub fn params(mut self, params: LiveParams) -> Self {
        self.params = params;
        self
    }

    /// Takes gauges and noise from a bundle. The estimator is chosen apart from it.
    #[must_use]
    pub fn bundle(mut self, bundle: &Bundle) -> Self {
        let gauge =
            |gauge: &crate::BundleGauge| LiveGauge { name: gauge.name.clone(), scale: gauge.scale };
        self.gauges = bundle.info.gauges.iter().map(gauge).collect();
        self.noise_ue = bundle.info.settings.noise_ue;
        self.given = bundle.given.clone();
        self
    }

    /// The gauges in the order of the estimator; the device's bridges in their order otherwise.
    #[must_use]
    pub fn gauges(mut self, gauges: Vec<LiveGauge>) -> Self {
        self.gauges = gauges;
        self
    }

    /// Loads on the whole limb that the device measures: what they read is taken off.
    #[must_use]
    pub fn given(mut self, given: GivenLoads) -> Self {
        self.given = given;
        self
    }

    /// What finds contacts.
    #[must_use]
    pub fn estimator(self, estimator: impl TouchEstimator + 'static) -> Self {
        self.boxed_estimator(Box::new(estimator))
    }

    /// The same, chosen at run time.
    #[must_use]
    pub fn boxed_estimator(mut self, estimator: Box<dyn TouchEstimator>) -> Self {
        self.estimator = Some(estimator);
        self
    }

    /// One more sink.
    #[must_use]
    pub fn sink(self, sink: impl Sink + 'static) -> Self {
        self.boxed_sink(Box::new(sink))
    }

    /// The same, chosen at run time.
    #[must_use]
    pub fn boxed_sink(mut self, sink: Box<dyn Sink>) -> Self {
        self.sinks.push(sink);
        self
    }

    /// Starts all threads.
    ///
    /// # Errors
    /// [`LiveError::Parameter`], [`LiveError::NoEstimator`], [`LiveError::FrameLength`] where gauges
    /// and estimator don't fit, [`LiveError::Thread`].
    pub fn start(mut self) -> Result<Live, LiveError> {
        let sinks = std::mem::take(&mut self.sinks);
        let wants = self.wanted(&sinks)?;
        let (setup, source) = self.setup(wants)?;
        let shared = Arc::new(Shared::new());
        let params = &setup.params;
        let is_lossless = params.is_lossless;
        let in_flight = is_lossless.then(|| InFlight::new(&shared, params.ring_len));
        let acquire_params = AcquireParams {
            n_receivers: 1 + params.n_receivers,
            ring_len: InFlight::ring_len(is_lossless, params.ring_len),
            realtime_priority: params.realtime_priority,
        };
        let mut outlets: Vec<Box<dyn Outlet>> = Vec::with_capacity(sinks.len());
        let mut threads = Vec::with_capacity(sinks.len());
        for (index, sink) in sinks.into_iter().enumerate() {
            let (worker, thread) =
                SinkWorker::start(sink, setup.n_gauges.unwrap_or(0), is_lossless)?;
            outlets.push(Box::new(worker));
            threads.extend(thread.map(|thread| (index, thread)));
        }
        let source = LiveSource::new(source, in_flight);
        let (acquisition, mut receivers) = acquire(source, acquire_params)?;
        let receiver = receivers.remove(0);
        let stats = Box::new(move || acquisition.stats());
        let compute = Compute::new(setup, stats, outlets, Arc::clone(&shared));
        let compute = spawn("hapdef-compute", move || compute.run(receiver))?;
        Ok(Live { shared, compute: Some(compute), sinks: threads, receivers, is_lossless })
    }

    /// What frames are computed with, and the source; sinks are for whoever calls them.
    fn setup(self, wants: Wants) -> Result<(Setup, Box<dyn FrameSource>), LiveError> {
        self.params.check()?;
        let n_gauges = self.n_gauges()?;
        if let Some(n_gauges) = n_gauges {
            self.given.check(n_gauges)?;
        }
        let setup = Setup {
            noise_ue: self.params.noise_ue.unwrap_or(self.noise_ue),
            params: self.params,
            gauges: self.gauges,
            n_gauges,
            given: self.given,
            estimator: self.estimator,
            wants,
            source_name: self.source.name(),
        };
        Ok((setup, self.source))
    }

    /// Gauges of a frame, where that is known before the device says so.
    fn n_gauges(&self) -> Result<Option<usize>, LiveError> {
        let named = Some(self.gauges.len()).filter(|n| *n > 0);
        let wanted = self.estimator.as_ref().map(|e| e.n_gauges());
        match (wanted, named) {
            (Some(expected), Some(found)) if expected != found => {
                Err(LiveError::FrameLength { expected, found })
            }
            _ => Ok(wanted.or(named)),
        }
    }

    fn wanted(&self, sinks: &[Box<dyn Sink>]) -> Result<Wants, LiveError> {
        let mut asking = sinks.iter().filter(|sink| sink.wants().has_contacts());
        if let (None, Some(sink)) = (&self.estimator, asking.next()) {
            return Err(LiveError::NoEstimator { sink: sink.name() });
        }
        let each = sinks.iter().map(|sink| sink.wants());
        Ok(each.fold(Wants::NOTHING, Wants::or))
    }
}

impl Live {
    /// A runtime on a source; it needs at least a sink to be of use.
    #[must_use]
    pub fn builder(source: impl FrameSource + 'static) -> LiveBuilder {
        Self::boxed_builder(Box::new(source))
    }

    /// The same with a source that was chosen at run time.
    #[must_use]
    pub fn boxed_builder(source: Box<dyn FrameSource>) -> LiveBuilder {
        LiveBuilder {
            source,
            params: LiveParams::default(),
            gauges: Vec::new(),
            noise_ue: 1.0,
            given: GivenLoads::default(),
            estimator: None,
            sinks: Vec::new(),
        }
    }

    /// What stops or tares it from another thread.
    #[must_use]
    pub fn control(&self) -> LiveControl {
        LiveControl { shared: Arc::clone(&self.shared) }
    }

    /// The further receivers that were asked for, each with everything that the source says; empty
    /// when they were taken.
    pub fn take_receivers(&mut self) -> Vec<Receiver> {
        std::mem::take(&mut self.receivers)
    }

    /// How it is doing, as of at most a second ago.
    #[must_use]
    pub fn health(&self) -> Arc<Health> {
        self.shared.health()
    }

    /// True when the source has said everything, or it was stopped.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        self.compute.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Waits until the source has said everything, or [`LiveControl::stop`] is called; then brings
    /// the sinks to their end. What came to pass.
    ///
    /// # Errors
    /// [`LiveError::Panicked`].
    pub fn wait(mut self) -> Result<Health, LiveError> {
        self.end()
    }

    /// Stops it, and the same.
    ///
    /// # Errors
    /// [`LiveError::Panicked`].
    pub fn stop(self) -> Result<Health, LiveError> {
        self.control().stop();
        self.wait()
    }

    fn end(&mut self) -> Result<Health, LiveError> {
        let joined = self.compute.take().map(JoinHandle::join);
        let deadline = (!self.is_lossless).then(|| Instant::now() + PATIENCE);
        let mut health = Health::clone(&self.shared.health());
        for (index, sink) in self.sinks.drain(..) {
            let found = sink.end(deadline);
            if let Some(of_sink) = health.sinks.get_mut(index) {
                *of_sink = found;
            }
        }
        match joined {
            Some(Err(_)) => Err(LiveError::Panicked),
            _ => Ok(health),
        }
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        if self.compute.is_some() {
            self.control().stop();
            // whoever drops it does not ask what came to pass
            let _ = self.end();
        }
    }
}

impl LiveControl {
    /// Asks it to stop; it does within some 20 ms.
    pub fn stop(&self) {
        self.shared.stop.store(true, Ordering::Release);
    }

    /// Takes a new tare of the next frames, which must be untouched.
    pub fn tare(&self) {
        self.shared.tare.store(true, Ordering::Release);
    }

    /// How it is doing, as of at most a second ago.
    #[must_use]
    pub fn health(&self) -> Arc<Health> {
        self.shared.health()
    }
}

impl Shared {
    fn new() -> Self {
        Self {
            stop: AtomicBool::new(false),
            tare: AtomicBool::new(false),
            n_taken: AtomicU64::new(0),
            health: Mutex::default(),
        }
    }

    fn health(&self) -> Arc<Health> {
        Arc::clone(&self.health.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn set_health(&self, health: Arc<Health>) {
        *self.health.lock().unwrap_or_else(PoisonError::into_inner) = health;
    }
}

/// A named thread.
fn spawn(name: &str, work: impl FnOnce() + Send + 'static) -> Result<JoinHandle<()>, LiveError> {
    let builder = std::thread::Builder::new().name(name.to_owned());
    builder.spawn(work).map_err(|source| LiveError::Thread { name: name.to_owned(), source })
}
