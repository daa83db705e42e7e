//! Where frames come from, and the contacts behind them, one frame after another.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::Duration;

use hapdef_daq::source::{FrameSource, StreamParams, StreamSource};
use hapdef_live::estimator::{SearchPlace, TouchEstimator};
use hapdef_live::{
    Delivery, FnSink, GivenLoads, Live, LiveBuilder, LiveFrame, LiveGauge, LiveParams, LoadSignal,
    Wants,
};
use hapdef_rig::live::{LiveLimb, PressScript, RigLink, RunParams};

use crate::error::HapdefError;
use crate::limb::Limb;
use crate::run::Run;
use crate::scene::Scene;
use crate::source_args::SourceArg;
use crate::virtual_rig::{VirtualRigParams, live_limb, random_presses, virtual_device};

/// Frames that wait at most to be looked at.
const N_WAITING: usize = 4096;

/// A device, a recording or the simulated rig, for the gauges of a scene.
pub struct Source {
    frames: Box<dyn FrameSource>,
    /// How the runtime reads it; to be changed before [`Self::contacts`].
    pub params: LiveParams,
    gauges: Vec<LiveGauge>,
    given: GivenLoads,
}

/// A frame as it came.
#[derive(Clone, Debug, PartialEq)]
pub struct RawFrame {
    /// Readings, not tared `[n_gauges]`, µε.
    pub readings_ue: Vec<f64>,
    /// What else the device measures of how the whole limb is loaded.
    pub signals: Vec<(LoadSignal, f64)>,
}

/// A play of the simulated rig.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigPlay {
    /// Its length, s; endless if `None`.
    pub seconds: Option<f64>,
    /// Seed of its presses.
    pub seed: u64,
}

/// Frames with the contacts found in them; an iterator that ends with its source.
pub struct Contacts {
    // The frames come first: dropping them sets free what waits to hand on another.
    frames: Receiver<LiveFrame>,
    live: Live,
}

impl Source {
    /// Frames of any source, such as one in memory, that come when they are due.
    pub fn new(frames: impl FrameSource + 'static, scene: &Scene) -> Self {
        Self::boxed(Box::new(frames), LiveParams::default(), scene)
    }

    /// A device or a recording.
    ///
    /// # Errors
    /// As [`SourceArg::open`].
    pub fn open(arg: &SourceArg, scene: &Scene) -> Result<Self, HapdefError> {
        let params = LiveParams {
            is_recorded: arg.is_recorded(),
            is_lossless: arg.is_unpaced(),
            ..LiveParams::default()
        };
        Ok(Self::boxed(arg.open_for(scene.gauges.sites.len())?, params, scene))
    }

    /// The simulated rig, pressed at random, as fast as frames are taken: the same frames every
    /// time.
    ///
    /// # Errors
    /// As [`live_limb`].
    pub fn rig(play: &RigPlay, run: &Run, limb: &Limb) -> Result<Self, HapdefError> {
        let real = Arc::new(live_limb(run, limb)?);
        let script = random_presses(&run.scene, &real, play.seed);
        Self::played(Some(script), play.seconds, real, run)
    }

    /// The simulated rig, touched by nothing: its noise, and the loads of a scene that has some.
    ///
    /// # Errors
    /// As [`live_limb`].
    pub fn untouched_rig(
        seconds: Option<f64>,
        run: &Run,
        limb: &Limb,
    ) -> Result<Self, HapdefError> {
        Self::played(None, seconds, Arc::new(live_limb(run, limb)?), run)
    }

    fn played(
        script: Option<PressScript>,
        duration_s: Option<f64>,
        real: Arc<LiveLimb>,
        run: &Run,
    ) -> Result<Self, HapdefError> {
        let params = VirtualRigParams { script, ..VirtualRigParams::default() };
        let device = virtual_device(&run.scene, real, &params)?;
        let play = RunParams { duration_s, ..RunParams::default() };
        let link = RigLink::new(device, &play, |_| ())?;
        let clock = link.clock();
        let stream = StreamParams { clock: Arc::clone(&clock), ..StreamParams::default() };
        let params =
            LiveParams { is_recorded: true, is_lossless: true, clock, ..LiveParams::default() };
        Ok(Self::boxed(Box::new(StreamSource::new(link, stream)), params, &run.scene))
    }

    fn boxed(frames: Box<dyn FrameSource>, params: LiveParams, scene: &Scene) -> Self {
        let noise_ue = Some(scene.estimator.superposition().noise_ue);
        let sites = scene.gauges.sites.iter();
        let gauges = sites.map(|site| LiveGauge { name: site.name.clone(), scale: 1.0 });
        let params = LiveParams { noise_ue, ..params };
        Self { frames, params, gauges: gauges.collect(), given: GivenLoads::default() }
    }

    /// The same, of a device that measures loads: what they read is taken off before contacts are looked for.
    #[must_use]
    pub fn beside(self, given: GivenLoads) -> Self {
        Self { given, ..self }
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> String {
        self.frames.name()
    }

    /// Where a tracker's full searches run: within the frame for a recording, which gives the same
    /// contacts each time then, else beside it.
    #[must_use]
    pub fn search_place(&self) -> SearchPlace {
        if self.params.is_recorded { SearchPlace::Here } else { SearchPlace::Background }
    }

    /// Starts to read, and finds the contacts of every frame.
    ///
    /// # Errors
    /// [`HapdefError::Live`] where gauges and estimator don't fit, or a thread can't be started.
    pub fn contacts(
        self,
        estimator: impl TouchEstimator + 'static,
    ) -> Result<Contacts, HapdefError> {
        self.boxed_contacts(Box::new(estimator))
    }

    /// The same with an estimator that was chosen at run time.
    ///
    /// # Errors
    /// As [`Self::contacts`].
    pub fn boxed_contacts(
        self,
        estimator: Box<dyn TouchEstimator>,
    ) -> Result<Contacts, HapdefError> {
        self.start(Wants::ALL, Some(estimator))
    }

    /// Reads frames until the source ends or for `seconds`, as they come.
    ///
    /// # Errors
    /// [`HapdefError::Live`] where gauges don't fit, or a thread can't be started.
    pub fn raw_frames(self, seconds: Option<f64>) -> Result<Vec<RawFrame>, HapdefError> {
        let frames = self.start(Wants::RAW, None)?;
        let mut begin_ns = None;
        let is_in_time = |frame: &LiveFrame| {
            let since_ns = frame.t_host_ns.saturating_sub(*begin_ns.get_or_insert(frame.t_host_ns));
            seconds.is_none_or(|seconds| (since_ns as f64) < seconds * 1e9)
        };
        let raw = |frame: LiveFrame| RawFrame { readings_ue: frame.raw_ue, signals: frame.signals };
        Ok(frames.take_while(is_in_time).map(raw).collect())
    }

    /// The runtime that reads it, without estimator and sinks.
    pub(crate) fn builder(self) -> LiveBuilder {
        Live::boxed_builder(self.frames).params(self.params).gauges(self.gauges).given(self.given)
    }

    fn start(
        self,
        wants: Wants,
        estimator: Option<Box<dyn TouchEstimator>>,
    ) -> Result<Contacts, HapdefError> {
        let (sender, frames) = sync_channel(N_WAITING);
        let sink = FnSink::new("contacts", wants, move |frame: &LiveFrame| {
            // Nobody looks any more when it was dropped.
            let _ = sender.send(frame.clone());
        });
        let mut live = self.builder().sink(sink.with_delivery(Delivery::Queue(N_WAITING)));
        if let Some(estimator) = estimator {
            live = live.boxed_estimator(estimator);
        }
        Ok(Contacts { frames, live: live.start()? })
    }
}

impl Contacts {
    /// The runtime behind it: its health, a new tare.
    #[must_use]
    pub fn live(&self) -> &Live {
        &self.live
    }

    /// The next frame.
    ///
    /// # Errors
    /// [`RecvTimeoutError::Timeout`] where none comes in time, [`RecvTimeoutError::Disconnected`]
    /// at the source's end.
    pub fn next_within(&self, timeout: Duration) -> Result<LiveFrame, RecvTimeoutError> {
        self.frames.recv_timeout(timeout)
    }
}

impl Iterator for Contacts {
    type Item = LiveFrame;

    fn next(&mut self) -> Option<LiveFrame> {
        self.frames.recv().ok()
    }
}
