//! The virtual limb, pressed from the page and read by the runtime, frame by frame.

use std::collections::VecDeque;
use std::sync::Arc;

use hapdef_daq::source::{StreamParams, StreamSource};
use hapdef_live::estimator::SearchPlace;
use hapdef_live::{Live, LiveFrame, LiveParams, LiveSteps};
use hapdef_mesh::PointIndex;
use hapdef_rig::live::{
    Hands, LiveElectronics, LiveLimb, PressHandle, RigDevice, RigLink, RunParams, TrueContact,
};
use hapdef_view::{ContactMark, DeviceState, LocalPage, Offers, ViewCommand, ViewFrame};
use nalgebra::{Point3, Vector3};

use crate::error::PageError;
use crate::model::PageModel;
use crate::newest::SharedNewest;

/// Polls of the source for a frame, at most: opening takes some, and each gives one frame.
const MOST_POLLS: u32 = 8;

/// A limb that is pressed and read.
pub struct Session {
    steps: LiveSteps,
    newest: SharedNewest,
    page: LocalPage,
    limb: Arc<LiveLimb>,
    hands: Hands,
    press: PressHandle,
    skin: Skin,
    rate_hz: f64,
    n_stepped: u64,
    shown: ViewFrame,
    messages: VecDeque<PageMessage>,
}

/// What the page is told.
#[derive(Clone, Debug, PartialEq)]
pub enum PageMessage {
    /// JSON.
    Text(String),
    /// The surface or a frame.
    Bytes(Vec<u8>),
}

/// The touchable skin's normals.
struct Skin {
    index: PointIndex,
    normals: Vec<Vector3<f64>>,
}

impl Session {
    /// Untouched, before its first frame; the first messages of a page wait.
    ///
    /// # Errors
    /// [`PageError`] for a model that can't be used.
    pub fn new(model: &PageModel) -> Result<Self, PageError> {
        let (bundle, rig) = (model.bundle(), model.rig());
        let limb = Arc::new(model.limb()?);
        let electronics = LiveElectronics::new(
            rig.electronics.params(),
            rig.rate_hz,
            &limb.largest_ue(rig.largest_n),
        )?;
        let device = RigDevice::new(Arc::clone(&limb), None, electronics, rig.device())?;
        let press = device.press_handle();
        let newest = SharedNewest::default();
        let truths = newest.clone();
        let tell = move |truth: &_| truths.lock().truth.clone_from(truth);
        let link = RigLink::new(device, &RunParams::default(), tell)?;
        let clock = link.clock();
        let stream = StreamParams { clock: Arc::clone(&clock), ..StreamParams::default() };
        let steps = Live::builder(StreamSource::new(link, stream))
            .bundle(bundle)
            .params(LiveParams { clock, is_recorded: true, ..LiveParams::default() })
            .boxed_estimator(bundle.estimator(None, SearchPlace::Here)?)
            .sink(newest.clone())
            .in_steps()?;
        let offers = Offers { tare: true, record: false, press: Some(rig.press()) };
        let page = LocalPage::new(model.picture().clone(), offers)?;
        let device = page.device(&DeviceState { is_simulated: true, fault: None });
        let first = [page.hello(), device].map(PageMessage::Text);
        let surface = PageMessage::Bytes(page.surface());
        Ok(Self {
            steps,
            newest,
            messages: first.into_iter().chain([surface]).collect(),
            page,
            hands: Hands::new(&limb, &rig.hands())?,
            limb,
            press,
            skin: Skin::new(bundle.skin().nodes(), bundle.skin().normals()),
            rate_hz: rig.rate_hz,
            n_stepped: 0,
            shown: ViewFrame::default(),
        })
    }

    /// Frames per second.
    #[must_use]
    pub fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    /// Hears a message of the page; what is refused is answered.
    pub fn hear(&mut self, text: &str) {
        match self.page.read(text) {
            Ok(Some(command)) => self.obey(command),
            Ok(None) => {}
            Err(answer) => self.messages.push_back(PageMessage::Text(answer)),
        }
    }

    /// So many frames more; the last of them is shown.
    pub fn step(&mut self, n_frames: u32) {
        for _ in 0..n_frames {
            self.step_once();
        }
        let notices = std::mem::take(&mut self.newest.lock().notices);
        for words in notices {
            self.say(&words);
        }
        self.show();
    }

    /// The next message for the page.
    pub fn next_message(&mut self) -> Option<PageMessage> {
        self.messages.pop_front()
    }

    fn step_once(&mut self) {
        let is_tared = self.newest.lock().is_tared;
        let now_s = self.now_s();
        self.press.set(self.hands.pressed(&self.limb, is_tared, now_s));
        let before = self.newest.lock().n_frames;
        for _ in 0..MOST_POLLS {
            let is_open = self.steps.step();
            if !is_open || self.newest.lock().n_frames > before {
                break;
            }
        }
        self.n_stepped += 1;
    }

    fn obey(&mut self, command: ViewCommand) {
        let now_s = self.now_s();
        match command {
            ViewCommand::Tare => {
                self.newest.lock().is_tared = false;
                self.press.set(Vec::new());
                self.steps.tare();
                self.say("Taring: touch nothing");
            }
            ViewCommand::Press { finger, point_m, force_n, .. } => {
                self.hands.press(finger, point_m, force_n, now_s);
            }
            ViewCommand::Lift { finger } => self.hands.lift(finger, now_s),
            ViewCommand::Release => self.hands.release(now_s),
            ViewCommand::Random(on) => self.hands.set_random(on),
            // the page keeps its own picture; there is no disk, and no recording to steer
            ViewCommand::Snapshot { .. }
            | ViewCommand::Record(_)
            | ViewCommand::Pause(_)
            | ViewCommand::Seek { .. } => {}
        }
    }

    /// Shows the newest frame.
    fn show(&mut self) {
        let mut newest = self.newest.lock();
        let ranges = std::mem::take(&mut newest.ranges);
        let Some(frame) = &newest.frame else { return };
        let (shown, skin) = (&mut self.shown, &self.skin);
        shown.t_s = frame.t_host_ns as f64 * 1e-9;
        take(frame, shown, skin);
        shown.show_ranges(&ranges);
        shown.truths.clear();
        if newest.truth.seq == frame.seq {
            let mark = |truth: &TrueContact| {
                let contact = truth.contact();
                ContactMark::new(contact, skin.normal_at(&contact.position_m))
            };
            shown.truths.extend(newest.truth.contacts.iter().map(mark));
        }
        if let Some(health) = &newest.health {
            shown.health.rate_hz = health.rate_hz;
            shown.health.n_lost = health.n_lost;
            shown.health.n_crc_errors = health.source.rejected.n_damaged;
            let residual_us = health.source.clock_residual_us;
            shown.health.clock_residual_us = residual_us.unwrap_or(f64::NAN);
        }
        drop(newest);
        match self.page.frame(&self.shown) {
            Ok(bytes) => self.messages.push_back(PageMessage::Bytes(bytes)),
            Err(error) => self.say(&error.to_string()),
        }
    }

    fn say(&mut self, words: &str) {
        let notice = self.page.notice(words);
        self.messages.push_back(PageMessage::Text(notice));
    }

    fn now_s(&self) -> f64 {
        self.n_stepped as f64 / self.rate_hz
    }
}

/// Takes over what the runtime has found in a frame.
fn take(frame: &LiveFrame, shown: &mut ViewFrame, skin: &Skin) {
    shown.readings_ue.clone_from(&frame.tared_ue);
    shown.gauge_health.clone_from(&frame.gauges);
    shown.phase = frame.phase;
    shown.is_stale = frame.is_stale;
    shown.show_touch(&frame.touch, |point| skin.normal_at(point));
}

impl Skin {
    fn new(nodes: &[Point3<f64>], normals: &[Vector3<f64>]) -> Self {
        Self { index: PointIndex::new(nodes), normals: normals.to_vec() }
    }

    /// The outward normal near a point.
    fn normal_at(&self, point: &Point3<f64>) -> Vector3<f64> {
        let nearest = self.index.nearest(point);
        nearest.map_or_else(Vector3::z, |(node, _)| self.normals[node])
    }
}
