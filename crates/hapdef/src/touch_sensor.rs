//! A simulated skin for simulators of robots: what presses and loads the limb goes in frame by frame, gauge readings and
//! contacts come out.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

use hapdef_daq::source::{Link, LinkFault, StreamParams, StreamSource};
use hapdef_live::estimator::SearchPlace;
use hapdef_live::{Delivery, FnSink, Live, LiveFrame, LiveParams, Wants};
use hapdef_rig::live::{LimbLoads, LiveLimb, LoadHandle, PressHandle, Pressed, RigLink, RunParams};
use nalgebra::{Point3, Vector3};

use crate::error::HapdefError;
use crate::open::OpenScene;
use crate::source::Source;
use crate::virtual_rig::{VirtualRigParams, virtual_device};

/// A frame that takes longer than this has not been made: the estimator's thread is gone.
const LONGEST: Duration = Duration::from_secs(60);

/// How the sensor works.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TouchSensorParams {
    /// Steps a second.
    pub rate_hz: f64,
    /// First time whose mean is the tare, s: nothing may touch then.
    pub tare_s: f64,
}

/// The scene's simulated rig, pressed and loaded by a simulator, with the live estimator behind its device: the same
/// steps give the same frames.
pub struct TouchSensor {
    limb: Arc<LiveLimb>,
    press: PressHandle,
    loads: LoadHandle,
    go: Sender<()>,
    frames: Receiver<LiveFrame>,
    live: Live,
    pressed: Vec<Pressed>,
}

/// The rig's link, which makes a frame when it is told to.
struct Stepped {
    link: RigLink,
    go: Receiver<()>,
}

impl Default for TouchSensorParams {
    /// 1,000 steps a second, tared for a second.
    fn default() -> Self {
        Self { rate_hz: 1000.0, tare_s: 1.0 }
    }
}

impl TouchSensor {
    /// The sensor of a scene, with the estimator that the scene chooses for a stream.
    ///
    /// # Errors
    /// As [`OpenScene::rig`] and [`OpenScene::estimator`]; [`HapdefError::Rig`] for a rate that can't be.
    pub fn new(scene: &OpenScene, params: &TouchSensorParams) -> Result<Self, HapdefError> {
        let limb = Arc::new(scene.rig()?);
        let rig = VirtualRigParams { rate_hz: params.rate_hz, ..VirtualRigParams::default() };
        let device = virtual_device(scene.scene(), Arc::clone(&limb), &rig)?;
        let (press, loads) = (device.press_handle(), device.load_handle());
        let link = RigLink::new(device, &RunParams::default(), |_| ())?;
        let (clock, (go, going)) = (link.clock(), channel());
        let stream = StreamParams { clock: Arc::clone(&clock), ..StreamParams::default() };
        let source = StreamSource::new(Stepped { link, go: going }, stream);
        let mut source = Source::new(source, scene.scene()).beside(scene.given_loads()?);
        source.params = LiveParams {
            tare_s: params.tare_s,
            is_recorded: true,
            is_lossless: true,
            clock,
            ..source.params
        };
        let (sender, frames) = channel();
        let sink = FnSink::new("simulator", Wants::ALL, move |frame: &LiveFrame| {
            // Nobody steps any more when it was dropped.
            let _ = sender.send(frame.clone());
        });
        let kind = scene.scene().estimator.kind().in_stream();
        let live = source
            .builder()
            .boxed_estimator(scene.estimator(Some(kind), SearchPlace::Here)?)
            .sink(sink.with_delivery(Delivery::Direct))
            .start()?;
        Ok(Self { limb, press, loads, go, frames, live, pressed: Vec::new() })
    }

    /// The next frame, with forces on the limb, N, at places, m, each at the nearest point of its surface, and with
    /// what loads the limb as a whole; all in the limb's frame. A force that pulls is left out: a skin is only pressed.
    ///
    /// # Errors
    /// [`HapdefError::Live`] where the estimator's thread is gone.
    pub fn step(
        &mut self,
        forces: &[(Point3<f64>, Vector3<f64>)],
        loads: LimbLoads,
    ) -> Result<LiveFrame, HapdefError> {
        self.pressed.clear();
        let numbered = (1..).zip(forces);
        let limb = &self.limb;
        self.pressed.extend(numbered.filter_map(|(id, (place, force_n))| {
            let (point, _) = limb.nearest(place)?;
            let normal_n = force_n.dot(&limb.inward(&point));
            Some(Pressed { id, position_m: *place, force_n: normal_n, shear_n: *force_n })
        }));
        self.press.set(self.pressed.clone());
        self.loads.set(loads);
        // A thread that is gone sends no frame.
        let _ = self.go.send(());
        self.frames.recv_timeout(LONGEST).map_err(|_| hapdef_live::LiveError::Panicked.into())
    }

    /// The runtime behind it: its health, a new tare.
    #[must_use]
    pub fn live(&self) -> &Live {
        &self.live
    }
}

impl Link for Stepped {
    fn open(&mut self) -> Result<(), LinkFault> {
        self.link.open()
    }

    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkFault> {
        if self.link.is_read_out() {
            match self.go.recv_timeout(timeout) {
                Ok(()) => {}
                Err(RecvTimeoutError::Timeout) => return Ok(0),
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(LinkFault::Ended { name: self.name() });
                }
            }
        }
        self.link.read(buffer, timeout)
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), LinkFault> {
        self.link.write(bytes)
    }

    fn close(&mut self) {
        self.link.close();
    }

    fn name(&self) -> String {
        "simulator".to_owned()
    }
}
