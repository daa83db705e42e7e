//! What is not sure: noise that is larger than assumed, explanations beside the best.

use crate::support;

use std::sync::Arc;

use hapdef_daq::source::ReplaySource;
use hapdef_live::estimator::{SearchPlace, TouchEstimator};
use hapdef_live::{Delivery, FnSink, Health, Live, LiveParams, Touch, Wants};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use support::world::{self, World};
use support::{Collected, N_GAUGES, bundle, messages, taken};

/// Nothing for 600 frames, then 20 N within 40 frames, with noise of `noise_ue`.
fn pressed(world: &World, n: usize, noise_ue: f64) -> Vec<Vec<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let point = world.draw_points(1, 0.01, &mut rng)[0];
    let frame = |index: usize| {
        let force_n = 20.0 * (index.saturating_sub(600) as f64 / 40.0).min(1.0);
        let mut y = world.readings(&[(point, force_n)]);
        world::add_noise(&mut y, noise_ue, &mut rng);
        y
    };
    (0..n).map(frame).collect()
}

/// Tares in 400 frames and follows contacts with an estimator that assumes 1 µε.
fn found(world: &World, noise_ue: f64) -> (Vec<Touch>, Health) {
    let readings = pressed(world, 800, noise_ue);
    let source = ReplaySource::new("memory", messages(&readings).into_iter(), 0.0);
    let found: Collected<Touch> = Collected::default();
    let to = Arc::clone(&found);
    let sink = FnSink::new("test", Wants::ALL, move |frame| {
        to.lock().unwrap().push(frame.touch.clone());
    });
    let live = Live::builder(source)
        .bundle(&bundle(world))
        .params(LiveParams {
            tare_s: 0.4,
            is_recorded: true,
            is_lossless: true,
            ..LiveParams::default()
        })
        .estimator(bundle(world).tracking(SearchPlace::Here).unwrap())
        .sink(sink.with_delivery(Delivery::Queue(64)))
        .start()
        .unwrap();
    let health = live.wait().unwrap();
    (taken(&found), health)
}

#[test]
fn noise_that_is_larger_than_assumed_is_measured_and_reckoned_with() {
    let world = World::new(N_GAUGES, 400, 5);
    let force_sd_n = |touches: &[Touch]| {
        let [contact] = &touches[799].contacts[..] else { panic!("{:?}", touches[799]) };
        contact.uncertainty.unwrap().force_sd_n()
    };
    let (touches, health) = found(&world, 1.0);
    assert_eq!(health.n_noisier, 0, "{health}");
    let quiet_sd_n = force_sd_n(&touches);

    let (touches, health) = found(&world, 5.0);
    assert_eq!(health.n_noisier, N_GAUGES, "{health}");
    assert!(health.noise_ue.iter().all(|sd| (sd - 5.0).abs() < 1.0));
    assert!(health.to_string().contains("noisier than assumed"), "{health}");
    let n_false = touches[..600].iter().filter(|t| !t.contacts.is_empty());
    assert_eq!(n_false.count(), 0);
    let noisy_sd_n = force_sd_n(&touches);
    println!("force sd {quiet_sd_n:.3} N, noisy {noisy_sd_n:.3} N");
    assert!(noisy_sd_n > 2.0 * quiet_sd_n);
}

/// With few gauges a small force can be in several places: the tracker says which.
#[test]
fn followed_contacts_have_alternatives() {
    let world = World::new(4, 400, 5);
    let mut tracking = bundle(&world).tracking(SearchPlace::Here).unwrap();
    let mut touch = Touch::default();
    let mut n_frames = 0;
    for readings in pressed(&world, 700, 1.0) {
        tracking.estimate(&readings, &mut touch).unwrap();
        let others = &touch.alternatives;
        assert_eq!(others.len(), touch.quality.unwrap().n_alternatives);
        assert!(others.is_sorted_by(|a, b| a.delta_cost <= b.delta_cost));
        for other in others {
            assert!(other.delta_cost.is_finite());
            let mut contacts = other.contacts();
            assert!(contacts.len() > 0 && contacts.all(|(_, force_n)| force_n >= 0.0));
        }
        n_frames += usize::from(!others.is_empty());
    }
    println!("{n_frames} frames have alternatives");
    assert!(n_frames > 0);
}
