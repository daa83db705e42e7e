//! A stream that stops.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use hapdef_live::estimator::SearchPlace;
use hapdef_live::{
    AnyError, Bundle, Delivery, Live, LiveEvent, LiveFrame, LiveParams, Sink, TouchPhase, Wants,
};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::fed::{Fed, SetClock};
use crate::{BEFORE, messages, response};

/// Times at which it is looked what was said last, from when the phase has to be unknown on.
const N_LOOKS: usize = 20;
const BETWEEN: Duration = Duration::from_millis(50);

/// Frames of the press before, in half of the streams.
const PRESSED: usize = 300;

/// The phase that was said last, and of how many frames.
struct Last(Arc<Mutex<(TouchPhase, usize)>>);

impl Sink for Last {
    fn name(&self) -> String {
        "last".to_owned()
    }

    fn wants(&self) -> Wants {
        Wants::CONTACTS
    }

    fn delivery(&self) -> Delivery {
        Delivery::Direct
    }

    fn frame(&mut self, frame: &LiveFrame) -> Result<(), AnyError> {
        let mut last = self.0.lock().unwrap();
        *last = (frame.phase, last.1 + 1);
        Ok(())
    }

    fn event(&mut self, event: &LiveEvent) -> Result<(), AnyError> {
        if let LiveEvent::Phase(status) = event {
            self.0.lock().unwrap().0 = status.phase;
        }
        Ok(())
    }
}

/// What is said, every 50 ms, once a stream has been silent for so long that nothing is known; half of the streams
/// stop while something presses.
pub(crate) fn phases(bundle: &Bundle, rng: &mut ChaCha8Rng) -> Vec<TouchPhase> {
    let (seed, force_n) = (rng.random(), 20.0 * f64::from(u8::from(rng.random_bool(0.5))));
    let g = response(bundle, rng);
    let n = BEFORE + PRESSED;
    let sent = messages(bundle, n, seed, move |index, y| {
        if index >= BEFORE {
            y.iter_mut().zip(&g).for_each(|(y, g)| *y += g * force_n);
        }
    });
    let (device, clock) = (Fed::default(), SetClock::default());
    let last = Arc::new(Mutex::new((TouchPhase::Taring, 0)));
    let params = LiveParams { clock: Arc::new(clock.clone()), ..LiveParams::default() };
    let unknown_after = params.unknown_after;
    let live = Live::builder(device.clone())
        .bundle(bundle)
        .params(params)
        .estimator(bundle.tracking(SearchPlace::Here).unwrap())
        .sink(Last(Arc::clone(&last)))
        .start()
        .unwrap();
    device.send(sent);
    while last.lock().unwrap().1 < n {
        std::thread::sleep(Duration::from_millis(1));
    }
    clock.pass(unknown_after);
    let look = |_| {
        clock.pass(BETWEEN);
        match last.lock().unwrap().0 {
            // a press that is still reported is as wrong as none
            TouchPhase::Touched => TouchPhase::Untouched,
            phase => phase,
        }
    };
    let said = (0..N_LOOKS).map(look).collect();
    device.end();
    live.wait().unwrap();
    said
}
