//! Streams of presses and drift, tared now and then.

use std::sync::{Arc, OnceLock};

use hapdef_daq::source::ReplaySource;
use hapdef_inverse::SkinPoint;
use hapdef_live::estimator::SearchPlace;
use hapdef_live::{
    AnyError, Delivery, Health, Live, LiveControl, LiveEvent, LiveFrame, LiveParams, Retare, Sink,
    TareFault, Wants,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::world::{self, World};
use super::{Collected, bundle, messages, taken};

/// Frames of the tare.
pub const TARE: usize = 400;

/// What came of a stream.
pub struct Played {
    pub frames: Vec<LiveFrame>,
    pub faults: Vec<Arc<TareFault>>,
    pub n_tared: usize,
    pub health: Health,
}

/// Keeps everything, and asks for a tare after a frame.
struct Keep {
    frames: Collected<LiveFrame>,
    events: Collected<LiveEvent>,
    control: Arc<OnceLock<LiveControl>>,
    tare_after: Option<usize>,
}

impl Sink for Keep {
    fn name(&self) -> String {
        "test".to_owned()
    }

    fn wants(&self) -> Wants {
        Wants::ALL
    }

    fn delivery(&self) -> Delivery {
        Delivery::Direct
    }

    fn frame(&mut self, frame: &LiveFrame) -> Result<(), AnyError> {
        if self.tare_after == Some(frame.seq as usize) {
            self.control.wait().tare();
        }
        self.frames.lock().unwrap().push(frame.clone());
        Ok(())
    }

    fn event(&mut self, event: &LiveEvent) -> Result<(), AnyError> {
        self.events.lock().unwrap().push(event.clone());
        Ok(())
    }
}

/// Forces and drift over frames: `force_n` at `point`, µε of drift on each gauge.
pub fn play(
    world: &World,
    n: usize,
    retare: Retare,
    signal: impl Fn(usize) -> (Vec<(SkinPoint, f64)>, Vec<f64>),
) -> Played {
    play_and_tare(world, n, retare, None, signal)
}

/// The same, with a tare that is asked for after a frame.
pub fn play_and_tare(
    world: &World,
    n: usize,
    retare: Retare,
    tare_after: Option<usize>,
    signal: impl Fn(usize) -> (Vec<(SkinPoint, f64)>, Vec<f64>),
) -> Played {
    play_readings(world, &readings(world, n, signal), retare, tare_after)
}

/// The same, the gauges of `frozen` `[n_gauges]` standing still from frame `from` on.
pub fn play_frozen(
    world: &World,
    n: usize,
    frozen: &[bool],
    from: usize,
    signal: impl Fn(usize) -> (Vec<(SkinPoint, f64)>, Vec<f64>),
) -> Played {
    let mut readings = readings(world, n, signal);
    for index in from.max(1)..n {
        for gauge in (0..frozen.len()).filter(|gauge| frozen[*gauge]) {
            readings[index][gauge] = readings[index - 1][gauge];
        }
    }
    play_readings(world, &readings, Retare::Ask, None)
}

/// Readings with noise of 1 µε `[n][n_gauges]`.
fn readings(
    world: &World,
    n: usize,
    signal: impl Fn(usize) -> (Vec<(SkinPoint, f64)>, Vec<f64>),
) -> Vec<Vec<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let frame = |index: usize| {
        let (contacts, drift) = signal(index);
        let mut y = world.readings(&contacts);
        y.iter_mut().zip(drift).for_each(|(y, drift)| *y += drift);
        world::add_noise(&mut y, 1.0, &mut rng);
        y
    };
    (0..n).map(frame).collect()
}

fn play_readings(
    world: &World,
    readings: &[Vec<f64>],
    retare: Retare,
    tare_after: Option<usize>,
) -> Played {
    let source = ReplaySource::new("memory", messages(readings).into_iter(), 0.0);
    let (frames, events) = (Collected::default(), Collected::default());
    let control = Arc::new(OnceLock::new());
    let sink = Keep {
        frames: Arc::clone(&frames),
        events: Arc::clone(&events),
        control: Arc::clone(&control),
        tare_after,
    };
    let live = Live::builder(source)
        .bundle(&bundle(world))
        .params(LiveParams {
            tare_s: TARE as f64 * 1e-3,
            retare,
            is_recorded: true,
            is_lossless: true,
            ..LiveParams::default()
        })
        .estimator(bundle(world).tracking(SearchPlace::Here).unwrap())
        .sink(sink)
        .start()
        .unwrap();
    let _ = control.set(live.control());
    let health = live.wait().unwrap();
    let events = taken(&events);
    let faults = events.iter().filter_map(|event| match event {
        LiveEvent::TareFault(fault) => Some(Arc::clone(fault)),
        _ => None,
    });
    let n_tared = events.iter().filter(|event| matches!(event, LiveEvent::Tared)).count();
    Played { faults: faults.collect(), frames: taken(&frames), n_tared, health }
}
