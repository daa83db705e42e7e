//! Whatever drifts, stands still or falls silent: nothing is called untouched that the sensor can't know.

use crate::support;

use std::sync::{Arc, Mutex};
use std::time::Duration;

use hapdef_inverse::SkinPoint;
use hapdef_live::estimator::SearchPlace;
use hapdef_live::{
    AnyError, Delivery, Live, LiveEvent, LiveFrame, LiveParams, Retare, Sink, TouchPhase,
    UnknownReason, Wants,
};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use support::fed::{Fed, SetClock};
use support::laws::{config, drifted, points, rates};
use support::played::{TARE, play, play_frozen};
use support::world::{self, World};
use support::{N_GAUGES, bundle, messages};

/// Frame at which it is pressed, by a quarter of the strongest force expected or more, in 30 frames.
const PRESSED: usize = 1500;

/// Frames after which what happened has been noticed.
const SOON: usize = 200;

fn pressed(point: SkinPoint, force_n: f64, index: usize) -> Vec<(SkinPoint, f64)> {
    let share = (index.saturating_sub(PRESSED) as f64 / 30.0).min(1.0);
    if share > 0.0 { vec![(point, share * force_n)] } else { Vec::new() }
}

/// The first frame from `from` on in which nothing is said to touch.
fn untouched(frames: &[LiveFrame], from: usize) -> Option<usize> {
    (from..frames.len()).find(|index| frames[*index].phase == TouchPhase::Untouched)
}

proptest! {
    #![proptest_config(config(24))]

    /// A press beside drift of any rate that began after the tare, followed or too fast to be, is never called untouched.
    #[test]
    fn drift_hides_no_press(
        rates in rates(8.0),
        seed in 0_u64..1000,
        force_n in 10.0..30.0,
    ) {
        let world = World::new(N_GAUGES, 400, 5);
        let point = points(&world, 1, seed)[0];
        let signal = |index: usize| (pressed(point, force_n, index), drifted(&rates, index.saturating_sub(2 * TARE)));
        let played = play(&world, PRESSED + 1500, Retare::Ask, signal);
        prop_assert_eq!(untouched(&played.frames, PRESSED + SOON), None);
    }

    /// Gauges that stand still feel no press: one that they hide is never called untouched, and once all stand still
    /// nothing is known.
    #[test]
    fn frozen_gauges_hide_no_press(
        frozen in prop::collection::vec(any::<bool>(), N_GAUGES),
        from in TARE..PRESSED,
        seed in 0_u64..1000,
        force_n in 10.0..30.0,
    ) {
        let world = World::new(N_GAUGES, 400, 5);
        let point = points(&world, 1, seed)[0];
        let signal = |index: usize| (pressed(point, force_n, index), Vec::new());
        let played = play_frozen(&world, PRESSED + 800, &frozen, from, signal);
        prop_assert_eq!(untouched(&played.frames, PRESSED.max(from) + SOON), None);
        if frozen.iter().all(|is_frozen| *is_frozen) {
            let stalled = TouchPhase::Unknown(UnknownReason::StreamStalled);
            prop_assert!(played.frames[from + SOON..].iter().all(|frame| frame.phase == stalled));
        }
    }
}

/// What was said last.
#[derive(Clone, Debug)]
struct Said {
    phase: TouchPhase,
    is_stale: bool,
    n_contacts: usize,
    n_frames: usize,
}

struct Last(Arc<Mutex<Said>>);

impl Sink for Last {
    fn name(&self) -> String {
        "last".to_owned()
    }

    fn wants(&self) -> Wants {
        Wants::ALL
    }

    fn delivery(&self) -> Delivery {
        Delivery::Direct
    }

    fn frame(&mut self, frame: &LiveFrame) -> Result<(), AnyError> {
        let mut said = self.0.lock().unwrap();
        (said.phase, said.is_stale) = (frame.phase, frame.is_stale);
        (said.n_contacts, said.n_frames) = (frame.touch.contacts.len(), said.n_frames + 1);
        Ok(())
    }

    fn event(&mut self, event: &LiveEvent) -> Result<(), AnyError> {
        if let LiveEvent::Phase(status) = event {
            let mut said = self.0.lock().unwrap();
            (said.phase, said.is_stale) = (status.phase, status.is_stale);
            said.n_contacts = status.n_contacts;
        }
        Ok(())
    }
}

/// A runtime that is fed frames, some of them under a press.
struct Stream {
    live: Live,
    device: Fed,
    clock: SetClock,
    said: Arc<Mutex<Said>>,
    frames: std::vec::IntoIter<hapdef_daq::Message>,
    n_sent: usize,
}

impl Stream {
    fn start(seed: u64) -> Self {
        let world = World::new(N_GAUGES, 400, 5);
        let point = points(&world, 1, seed)[0];
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let frame = |index: usize| {
            let mut y = world.readings(&pressed(point, 12.0, index));
            world::add_noise(&mut y, 1.0, &mut rng);
            y
        };
        let readings: Vec<Vec<f64>> = (0..PRESSED + 2000).map(frame).collect();
        let (device, clock) = (Fed::default(), SetClock::default());
        let phase = TouchPhase::Taring;
        let said = Said { phase, is_stale: false, n_contacts: 0, n_frames: 0 };
        let said = Arc::new(Mutex::new(said));
        let live = Live::builder(device.clone())
            .bundle(&bundle(&world))
            .params(LiveParams {
                tare_s: TARE as f64 * 1e-3,
                clock: Arc::new(clock.clone()),
                ..LiveParams::default()
            })
            .estimator(bundle(&world).tracking(SearchPlace::Here).unwrap())
            .sink(Last(Arc::clone(&said)))
            .start()
            .unwrap();
        let mut frames = messages(&readings).into_iter();
        device.send(frames.by_ref().take(1));
        Self { live, device, clock, said, frames, n_sent: 0 }
    }

    fn send(&mut self, n: usize) {
        self.device.send(self.frames.by_ref().take(n));
        self.n_sent += n;
        while self.said.lock().unwrap().n_frames < self.n_sent {
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    fn said(&self) -> Said {
        self.said.lock().unwrap().clone()
    }
}

proptest! {
    #![proptest_config(config(8))]

    /// A stream that stops, untouched or touched: what was said is stale after a tenth of a second, and after three
    /// nothing is known, until frames come again.
    #[test]
    fn silence_is_never_untouched(
        is_pressed in any::<bool>(),
        pauses_ms in prop::collection::vec(1_u64..400, 1..6),
        seed in 0_u64..1000,
    ) {
        let mut stream = Stream::start(seed);
        stream.send(if is_pressed { PRESSED + 300 } else { PRESSED - 300 });
        let known = if is_pressed { TouchPhase::Touched } else { TouchPhase::Untouched };
        for _ in 0..2 {
            prop_assert_eq!(stream.said().phase, known);
            let mut silent_ms = 0;
            for pause_ms in &pauses_ms {
                stream.clock.pass(Duration::from_millis(*pause_ms));
                silent_ms += pause_ms;
                let said = stream.said();
                prop_assert_eq!(said.is_stale, silent_ms >= 100, "{} ms: {:?}", silent_ms, &said);
                let is_unknown = said.phase.why_unknown() == Some(UnknownReason::StreamStalled);
                prop_assert_eq!(is_unknown, silent_ms >= 300, "{} ms: {:?}", silent_ms, &said);
                prop_assert!(silent_ms < 300 || said.n_contacts == 0, "{:?}", said);
            }
            stream.send(100);
        }
        stream.device.end();
        stream.live.wait().unwrap();
    }
}
