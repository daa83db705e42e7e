//! From a touch to the stop signal: the rig on one pseudo-terminal, the signal on another, in real time.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use hapdef::touch::SearchPlace;
use hapdef::{VirtualRigParams, virtual_device};
use hapdef_daq::clock::{HostClock, SystemClock};
use hapdef_daq::source::{SerialLink, SerialOutput, SerialParams, StreamParams, StreamSource};
use hapdef_live::sinks::AlertSink;
use hapdef_live::{Alert, AlertLevel, AlertParams, Live, LiveParams};
use hapdef_rig::live::{
    DevicePort, PressScript, PtyPort, RandomScriptParams, RunParams, TruthFrame, random_script,
    spawn_rig,
};

use crate::judge::Samples;
use crate::play::Limb;

/// A touch that the signal has not told of after so long is missed.
const MISSED_NS: u64 = 500_000_000;
/// Before a touch the limb has had no force that keeps a stop for so long, so that a stop then is not an old one.
const QUIET_NS: u64 = 50_000_000;
/// A stop this near to a force that warns is of that force: the tracker's forces have errors.
const NEAR_NS: u64 = 20_000_000;

/// What came of the touches.
#[derive(Default)]
pub(crate) struct Stops {
    pub(crate) n_touches: usize,
    /// From the sample instant of a touch's first frame of 1 N to the stop at the other end of the wire.
    pub(crate) to_stop_ms: Samples,
    /// The same to anything but clear: a controller that stops where nothing is known has stopped by then.
    pub(crate) to_any_ms: Samples,
    /// Stops without any force that warns.
    pub(crate) n_false: usize,
}

/// The strongest true force of a frame.
#[derive(Clone, Copy)]
struct Pressed {
    t_ns: u64,
    force_n: f64,
}

/// A letter as it came.
#[derive(Clone, Copy)]
struct Said {
    t_ns: u64,
    letter: u8,
}

/// Presses by script `seed` for so long.
pub(crate) fn stops(limb: &Limb, seed: u64, seconds: f64) -> Stops {
    let (pressed, said) = play(limb, seed, seconds);
    let AlertParams { warn, stop, .. } = AlertParams::default();
    let mut stops = Stops::default();
    let mut quiet_since_ns = None;
    let mut was_pressed = true;
    for now in &pressed {
        if now.force_n >= stop.on_n && !was_pressed {
            let is_new = quiet_since_ns.is_some_and(|since| now.t_ns - since >= QUIET_NS);
            if is_new {
                stops.add(now.t_ns, &said);
            }
        }
        was_pressed = now.force_n >= stop.on_n;
        quiet_since_ns = match now.force_n < stop.off_n {
            true => quiet_since_ns.or(Some(now.t_ns)),
            false if now.force_n < stop.on_n => quiet_since_ns,
            false => None,
        };
    }
    let begins = said.windows(2).filter(|two| is_stop(two[1].letter) && !is_stop(two[0].letter));
    let is_false = |stop: &Said| {
        let near = pressed.iter().filter(|p| p.t_ns.abs_diff(stop.t_ns) <= NEAR_NS);
        near.map(|p| p.force_n).fold(0.0, f64::max) < warn.on_n
    };
    stops.n_false = begins.filter(|two| is_false(&two[1])).count();
    stops
}

impl Stops {
    fn add(&mut self, touched_ns: u64, said: &[Said]) {
        self.n_touches += 1;
        let clear = AlertLevel::Clear.letter() as u8;
        for (lags, is_it) in [
            (&mut self.to_stop_ms, &is_stop as &dyn Fn(u8) -> bool),
            (&mut self.to_any_ms, &|letter| letter != clear),
        ] {
            // what held at the touch, and what came after it
            let at = said.partition_point(|said| said.t_ns < touched_ns);
            let before = said[..at].last().filter(|said| is_it(said.letter)).map(|_| touched_ns);
            let after = || said[at..].iter().find(|said| is_it(said.letter)).map(|said| said.t_ns);
            let lag_ns = before.or_else(after).map(|t_ns| t_ns - touched_ns);
            let lag_ms =
                lag_ns.filter(|ns| *ns < MISSED_NS).map_or(f64::INFINITY, |ns| ns as f64 * 1e-6);
            lags.add(lag_ms);
        }
    }
}

fn is_stop(letter: u8) -> bool {
    letter == AlertLevel::Stop.letter() as u8
}

/// Presses one after the other that come and go, so that each is told of by itself.
fn one_after_another(limb: &Limb, seed: u64, seconds: f64) -> PressScript {
    let contact = &limb.scene().contact;
    let range_n = (2.0, contact.force_range_n[1]);
    let params = RandomScriptParams {
        duration_s: seconds,
        impact_share: 0.0,
        slide_share: 0.0,
        quiet_s: 1.5,
        ..RandomScriptParams::new(1, contact.min_spacing_m, range_n, seed)
    };
    random_script(limb.real(), &params)
}

/// Forces and letters, in their order.
fn play(limb: &Limb, seed: u64, seconds: f64) -> (Vec<Pressed>, Vec<Said>) {
    let scene = limb.scene();
    let params = VirtualRigParams {
        script: Some(one_after_another(limb, seed, seconds)),
        ..VirtualRigParams::default()
    };
    let device = virtual_device(scene, Arc::clone(limb.real()), &params).unwrap();
    let (port, wire) = (PtyPort::open(None).unwrap(), PtyPort::open(None).unwrap());
    let source = SerialLink::new(&port.name(), SerialParams::default());
    let signal = SerialOutput::open(&wire.name(), &SerialParams::default()).unwrap();
    let alert = Alert::new(AlertParams::default()).unwrap();
    let params = LiveParams {
        noise_ue: Some(scene.estimator.superposition().noise_ue),
        ..LiveParams::default()
    };
    let live = Live::builder(StreamSource::new(source, StreamParams::default()))
        .params(params)
        .gauges(limb.gauges())
        .given(limb.given())
        .estimator(limb.tracker(SearchPlace::Background))
        .sink(AlertSink::new(signal, alert, Duration::from_millis(10)))
        .start()
        .unwrap();
    let stop = Arc::new(AtomicBool::new(false));
    let theirs = Arc::clone(&stop);
    let listener = std::thread::spawn(move || listen(wire, &theirs));
    let frames: Arc<Mutex<Vec<(u64, f64, f64)>>> = Arc::default();
    let to = Arc::clone(&frames);
    let run = RunParams { duration_s: Some(seconds), ..RunParams::default() };
    let rig = spawn_rig(device, port, run, move |frame: &TruthFrame| {
        let strongest_n = frame.contacts.iter().map(|c| c.force_n).fold(0.0, f64::max);
        to.lock().unwrap().push((SystemClock.now_ns(), frame.t_s, strongest_n));
    });
    let rig = rig.unwrap();
    while !rig.has_ended() {
        std::thread::sleep(Duration::from_millis(20));
    }
    drop(rig);
    println!("{}", live.stop().unwrap());
    stop.store(true, Ordering::Release);
    let said = listener.join().unwrap();
    let frames = std::mem::take(&mut *frames.lock().unwrap());
    (due(&frames), said)
}

/// Frames at the instants when they were due: the device's schedule began when the promptest of them was sent.
fn due(frames: &[(u64, f64, f64)]) -> Vec<Pressed> {
    let played_ns = |t_s: f64| (t_s * 1e9) as u64;
    let begun_ns =
        frames.iter().map(|(sent_ns, t_s, _)| sent_ns - played_ns(*t_s)).min().unwrap_or(0);
    let pressed = frames
        .iter()
        .map(|(_, t_s, force_n)| Pressed { t_ns: begun_ns + played_ns(*t_s), force_n: *force_n });
    pressed.collect()
}

/// The first letter of each line with the time at which it came.
fn listen(mut wire: PtyPort, stop: &AtomicBool) -> Vec<Said> {
    let (mut said, mut bytes, mut is_first) = (Vec::new(), Vec::new(), true);
    while !stop.load(Ordering::Acquire) {
        bytes.clear();
        wire.look(&mut bytes);
        let t_ns = SystemClock.now_ns();
        for &byte in &bytes {
            if is_first {
                said.push(Said { t_ns, letter: byte });
            }
            is_first = byte == b'\n';
        }
        if bytes.is_empty() {
            std::thread::sleep(Duration::from_micros(50));
        }
    }
    said
}
