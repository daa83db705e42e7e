//! Scripts played to the runtime, in memory.

use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use hapdef::scene::Scene;
use hapdef::touch::{SearchPlace, Tracking};
use hapdef::{OpenScene, SolvedLimb, VirtualRigParams, random_presses, virtual_device};
use hapdef_daq::Message;
use hapdef_daq::source::{
    FrameSource, ReplaySource, SourceStats, SourceStatus, StreamParams, StreamSource,
};
use hapdef_live::{
    Delivery, FnSink, GivenLoads, Live, LiveFrame, LiveParams, Touch, TouchPhase, Wants,
};
use hapdef_rig::live::{LiveLimb, RigLink, RunParams, TruthFrame};

use crate::judge::{Judge, Seen};

/// A limb as it is estimated and as it is pressed.
pub(crate) struct Limb {
    scene: OpenScene,
    solved: SolvedLimb,
    real: Arc<LiveLimb>,
}

/// What came of a script.
pub(crate) struct Played {
    pub(crate) seen: Seen,
    /// All that the device said.
    messages: Vec<Message>,
}

/// A source of which a copy is kept.
struct Kept<S> {
    source: S,
    messages: Arc<Mutex<Vec<Message>>>,
}

impl<S: FrameSource> FrameSource for Kept<S> {
    fn poll(&mut self, timeout: Duration, sink: &mut dyn FnMut(Message)) -> SourceStatus {
        let mut messages = self.messages.lock().unwrap();
        self.source.poll(timeout, &mut |message| {
            messages.push(message.clone());
            sink(message);
        })
    }

    fn stats(&self) -> SourceStats {
        self.source.stats()
    }

    fn name(&self) -> String {
        self.source.name()
    }
}

impl Limb {
    pub(crate) fn new(scene: OpenScene) -> Self {
        let solved = scene.solve().unwrap();
        let real = Arc::new(scene.rig().unwrap());
        Self { scene, solved, real }
    }

    pub(crate) fn name(&self) -> &str {
        &self.scene.scene().name
    }

    pub(crate) fn scene(&self) -> &Scene {
        self.scene.scene()
    }

    /// The limb as it is pressed.
    pub(crate) fn real(&self) -> &Arc<LiveLimb> {
        &self.real
    }

    /// What its device measures of loads that are no contacts.
    pub(crate) fn given(&self) -> GivenLoads {
        self.scene.given_loads().unwrap()
    }

    pub(crate) fn tracker(&self, place: SearchPlace) -> Tracking {
        self.solved.tracker(place).unwrap()
    }

    /// Plays script `seed` for so long, as fast as it goes.
    pub(crate) fn press(&self, seed: u64, seconds: f64) -> Played {
        let scene = self.scene.scene();
        let params = VirtualRigParams {
            script: Some(random_presses(scene, &self.real, seed)),
            ..VirtualRigParams::default()
        };
        let device = virtual_device(scene, Arc::clone(&self.real), &params).unwrap();
        let run = RunParams { duration_s: Some(seconds), ..RunParams::default() };
        let truth: Arc<Mutex<VecDeque<TruthFrame>>> = Arc::default();
        let to = Arc::clone(&truth);
        let link = RigLink::new(device, &run, move |frame| {
            to.lock().unwrap().push_back(frame.clone());
        });
        let link = link.unwrap();
        let clock = link.clock();
        let source = StreamSource::new(link, StreamParams { clock, ..StreamParams::default() });
        let messages: Arc<Mutex<Vec<Message>>> = Arc::default();
        let source = Kept { source, messages: Arc::clone(&messages) };
        let judge = Arc::new(Mutex::new(Judge::new(scene.contact.force_range_n[1])));
        let of_sink = Arc::clone(&judge);
        self.live(source, true, move |frame| {
            let mut truth = truth.lock().unwrap();
            while let Some(pressed) = truth.pop_front() {
                if pressed.seq == frame.seq {
                    of_sink.lock().unwrap().take(&pressed.contacts, frame);
                    break;
                }
            }
        });
        let seen = judge.lock().unwrap().end();
        let messages = std::mem::take(&mut *messages.lock().unwrap());
        Played { seen, messages }
    }

    /// The runtime on `source` to its end: as for a recording that is read as fast as it goes, or as for a device.
    fn live(
        &self,
        source: impl FrameSource + 'static,
        is_recorded: bool,
        take: impl FnMut(&LiveFrame) + Send + 'static,
    ) {
        let scene = self.scene.scene();
        let place = if is_recorded { SearchPlace::Here } else { SearchPlace::Background };
        let params = LiveParams {
            noise_ue: Some(scene.estimator.superposition().noise_ue),
            is_recorded,
            is_lossless: is_recorded,
            ..LiveParams::default()
        };
        let sink = FnSink::new("judge", Wants::CONTACTS, take).with_delivery(Delivery::Direct);
        let live = Live::builder(source)
            .params(params)
            .gauges(self.gauges())
            .given(self.given())
            .estimator(self.tracker(place))
            .sink(sink);
        let health = live.start().unwrap().wait().unwrap();
        assert!(health.n_frames > 0, "{health}");
        if !is_recorded {
            println!("{health}");
        }
    }

    pub(crate) fn gauges(&self) -> Vec<hapdef_live::LiveGauge> {
        let sites = self.scene.scene().gauges.sites.iter();
        let gauge = |name: &String| hapdef_live::LiveGauge { name: name.clone(), scale: 1.0 };
        sites.map(|site| gauge(&site.name)).collect()
    }

    /// What is found in `messages` that come at their own pace, or as fast as they go.
    fn found(&self, messages: Vec<Message>, is_live: bool) -> Vec<Found> {
        let speed = if is_live { 1.0 } else { 0.0 };
        let source = ReplaySource::new("memory", messages.into_iter(), speed);
        let (sender, found): (_, Receiver<Found>) = channel();
        self.live(source, !is_live, move |frame| {
            let found = (frame.seq, frame.phase, frame.is_stale, frame.touch.clone());
            sender.send(found).unwrap();
        });
        found.into_iter().collect()
    }
}

/// Number, phase, whether it is stale, contacts and quality of a frame.
type Found = (u32, TouchPhase, bool, Touch);

/// How many frames of a stream that runs at its own pace, full searches beside it, are to the last bit those of
/// its replay, and of how many.
pub(crate) fn replay_equal(limb: &Limb, seed: u64, seconds: f64) -> (usize, usize) {
    let messages = limb.press(seed, seconds).messages;
    let live = limb.found(messages.clone(), true);
    let replayed = limb.found(messages, false);
    let mut live = live.into_iter().peekable();
    let n = replayed.len();
    let is_same =
        |found: &Found| live.next_if(|live| live.0 == found.0).is_some_and(|l| l == *found);
    (replayed.iter().map(is_same).filter(|same| *same).count(), n)
}
