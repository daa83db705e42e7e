//! Tares that are asked for under steady presses, and after zeros have changed.

use std::sync::{Arc, OnceLock};

use hapdef_daq::source::ReplaySource;
use hapdef_live::estimator::SearchPlace;
use hapdef_live::{
    Bundle, Delivery, FnSink, Live, LiveControl, LiveFrame, LiveParams, TouchPhase, Wants,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{BEFORE, messages, response};

/// Frames from the change of the readings to the tare, and to the end.
const HELD: usize = 600;
const AFTER: usize = 1500;

/// Zeros that change change by so much at most, µε: by more than drift in any direction is reckoned with.
const CHANGED_UE: f64 = 60.0;

/// Of `n` tares each under one, two and three presses of 5 to 25 N, and after zeros changed in any direction: how many
/// were refused.
pub(crate) fn count(bundle: &Bundle, seed: u64, n: u64) -> [usize; 4] {
    let mut n_refused = [0; 4];
    for seed in seed..seed + n {
        for (kind, refused) in n_refused.iter_mut().enumerate() {
            let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x7a3e);
            let change = match kind {
                3 => changed(bundle, &mut rng),
                kind => pressed(bundle, kind + 1, &mut rng),
            };
            *refused += usize::from(is_refused(bundle, seed, change));
        }
    }
    n_refused
}

fn pressed(bundle: &Bundle, n: usize, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let mut sum = vec![0.0; bundle.map().n_gauges()];
    for _ in 0..n {
        let (g, force_n) = (response(bundle, rng), rng.random_range(5.0..25.0));
        sum.iter_mut().zip(g).for_each(|(sum, g)| *sum += g * force_n);
    }
    sum
}

fn changed(bundle: &Bundle, rng: &mut ChaCha8Rng) -> Vec<f64> {
    (0..bundle.map().n_gauges()).map(|_| rng.random_range(-CHANGED_UE..CHANGED_UE)).collect()
}

/// Whether a tare is refused that is asked for while readings are `change` above the zero: the phase is touched after it.
fn is_refused(bundle: &Bundle, seed: u64, change: Vec<f64>) -> bool {
    let sent = messages(bundle, BEFORE + HELD + AFTER, seed, move |index, y| {
        let share = (index.saturating_sub(BEFORE) as f64 / 30.0).min(1.0);
        y.iter_mut().zip(&change).for_each(|(y, by)| *y += by * share);
    });
    let control: Arc<OnceLock<LiveControl>> = Arc::default();
    let last = Arc::new(std::sync::Mutex::new(TouchPhase::Taring));
    let (to_ask, to_keep) = (Arc::clone(&control), Arc::clone(&last));
    let sink = FnSink::new("tares", Wants::CONTACTS, move |frame: &LiveFrame| {
        if frame.seq as usize == BEFORE + HELD {
            to_ask.wait().tare();
        }
        *to_keep.lock().unwrap() = frame.phase;
    });
    let params = LiveParams { is_recorded: true, is_lossless: true, ..LiveParams::default() };
    let live = Live::builder(ReplaySource::new("memory", sent, 0.0))
        .bundle(bundle)
        .params(params)
        .estimator(bundle.tracking(SearchPlace::Here).unwrap())
        .sink(sink.with_delivery(Delivery::Direct))
        .start()
        .unwrap();
    let _ = control.set(live.control());
    live.wait().unwrap();
    *last.lock().unwrap() != TouchPhase::Untouched
}
