//! The wire takes nothing away: contacts of HDP1 frames are those of their readings.

use crate::support;

use std::sync::Arc;
use std::time::Duration;

use hapdef_daq::hdp1::{Encoder, FrameFlags};
use hapdef_daq::source::{MemoryDevice, StreamParams, StreamSource, memory_link};
use hapdef_live::estimator::{SearchPlace, TouchEstimator};
use hapdef_live::{Delivery, FnSink, Live, LiveParams, Touch, Wants};
use support::world::World;
use support::{Collected, N_GAUGES, bundle, hello, pressed, quantised, taken};

/// Encodes frames as the device does, and sends them as fast as the host reads.
fn play(device: &MemoryDevice, readings: &[Vec<f64>]) {
    while !device.is_open() {
        std::thread::sleep(Duration::from_millis(1));
    }
    let hello = hello(N_GAUGES);
    let mut encoder = Encoder::new();
    let mut bytes = vec![0];
    encoder.hello(&hello, 0, &mut bytes).unwrap();
    for (i, y) in readings.iter().enumerate() {
        let flags = FrameFlags::default();
        let t_us = 1000 * i as u64;
        encoder.data(&hello, t_us, flags, &quantised(y).0, &mut bytes).unwrap();
        if i % 20 == 19 {
            device.send(&bytes);
            bytes.clear();
            std::thread::sleep(Duration::from_millis(2));
        }
    }
    device.send(&bytes);
    device.end();
}

fn over_the_wire(
    world: &World,
    readings: &[Vec<f64>],
    estimator: impl TouchEstimator + 'static,
) -> Vec<Touch> {
    let (link, device) = memory_link();
    let found: Collected<Touch> = Collected::default();
    let to = Arc::clone(&found);
    let sink = FnSink::new("test", Wants::ALL, move |frame| {
        assert_eq!(frame.n_skipped_before, 0);
        to.lock().unwrap().push(frame.touch.clone());
    });
    let live = Live::builder(StreamSource::new(link, StreamParams::default()))
        .bundle(&bundle(world))
        .params(LiveParams { tare_s: 0.0, is_lossless: true, ..LiveParams::default() })
        .estimator(estimator)
        .sink(sink.with_delivery(Delivery::Queue(64)))
        .start()
        .unwrap();
    play(&device, readings);
    let health = live.wait().unwrap();
    assert_eq!(device.n_dropped(), 0);
    let n = readings.len() as u64;
    assert_eq!((health.n_frames, health.n_lost, health.n_dropped), (n, 0, 0));
    assert_eq!(health.source.losses.n_delivered, n);
    taken(&found)
}

/// Bit for bit those of the readings that the counts stand for; and half a count (0.0005 µε) of
/// rounding moves a contact by less than 10 µm.
#[test]
fn contacts_of_frames_are_those_of_their_readings() {
    let world = World::new(N_GAUGES, 400, 5);
    let readings = pressed(&world, 480, 9);
    let found = over_the_wire(&world, &readings, bundle(&world).superposition().unwrap());
    assert_eq!(found.len(), readings.len());
    let mut direct = bundle(&world).superposition().unwrap();
    let (mut expected, mut exact) = (Touch::default(), Touch::default());
    let (mut n_contacts, mut worst_m) = (0, 0.0_f64);
    for (readings, found) in readings.iter().zip(&found) {
        direct.estimate(&quantised(readings).1, &mut expected).unwrap();
        assert_eq!(*found, expected);
        direct.estimate(readings, &mut exact).unwrap();
        if exact.contacts.len() == 1 && found.contacts.len() == 1 {
            n_contacts += 1;
            let miss = exact.contacts[0].position_m - found.contacts[0].position_m;
            worst_m = worst_m.max(miss.norm());
        }
    }
    println!("{n_contacts} contacts, {:.2} µm apart at most", worst_m * 1e6);
    assert!(n_contacts >= 50 && worst_m < 1e-5, "{n_contacts} contacts, {worst_m} m");
}

#[test]
fn followed_contacts_are_those_of_their_readings_too() {
    let world = World::new(N_GAUGES, 400, 5);
    let readings = pressed(&world, 900, 11);
    let make = || bundle(&world).tracking(SearchPlace::Here).unwrap();
    let found = over_the_wire(&world, &readings, make());
    let mut direct = make();
    let mut expected = Touch::default();
    for (i, (readings, found)) in readings.iter().zip(&found).enumerate() {
        direct.estimate(&quantised(readings).1, &mut expected).unwrap();
        assert_eq!(*found, expected, "frame {i}");
    }
    assert_eq!(expected.contacts.len(), 1);
    assert!(expected.contacts[0].id.is_some() && expected.contacts[0].phase.is_some());
}
