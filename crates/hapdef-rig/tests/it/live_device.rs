//! The device read by `hapdef-daq`: nothing wrong comes through, what is lost is counted, a seed repeats.

use crate::live_support;

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use hapdef_daq::hdp1::Hello;
use hapdef_daq::source::{
    FrameSource, Link, SourceStats, SourceStatus, StreamParams, StreamSource,
};
use hapdef_daq::{Frame, Message};
use hapdef_rig::live::{
    LiveElectronics, Pressed, RigDevice, RigDeviceParams, RigLink, RunParams, TruthFrame,
};
use live_support::{device, electronics, plate, script};
use nalgebra::Point3;

/// What came out of a source.
struct Heard {
    frames: Vec<(u32, Frame)>,
    hellos: Vec<Arc<Hello>>,
    n_restarts: usize,
    stats: SourceStats,
    truth: Vec<TruthFrame>,
}

fn hear(device: RigDevice, seconds: f64, faults: &[&str]) -> Heard {
    let truth = Arc::new(Mutex::new(Vec::new()));
    let theirs = Arc::clone(&truth);
    let params = RunParams {
        duration_s: Some(seconds),
        faults: faults.iter().map(|text| text.parse().unwrap()).collect(),
        ..RunParams::default()
    };
    let keep = move |frame: &TruthFrame| theirs.lock().unwrap().push(frame.clone());
    let link = RigLink::new(device, &params, keep).unwrap();
    let clock = link.clock();
    let params = StreamParams { clock, ..StreamParams::default() };
    let mut source = StreamSource::new(link, params);
    let (mut frames, mut hellos, mut n_restarts) = (Vec::new(), Vec::<Arc<Hello>>::new(), 0);
    loop {
        let status = source.poll(Duration::ZERO, &mut |message| match message {
            Message::Frame(frame) => {
                let boot_id = hellos.last().map_or(0, |hello| hello.boot_id);
                frames.push((boot_id, frame));
            }
            Message::Hello(hello) => hellos.push(hello),
            Message::Restarted => n_restarts += 1,
            _ => {}
        });
        if status == SourceStatus::Ended {
            break;
        }
    }
    let stats = source.stats();
    let truth = truth.lock().unwrap().clone();
    Heard { frames, hellos, n_restarts, stats, truth }
}

fn plain(seed: u64) -> RigDevice {
    device(Some(&script()), RigDeviceParams::default(), seed)
}

#[test]
fn a_whole_wire_carries_everything() {
    let heard = hear(plain(1), 3.0, &[]);
    assert_eq!(heard.frames.len(), 3000);
    assert_eq!((heard.stats.losses.n_lost, heard.n_restarts), (0, 0));
    assert_eq!(heard.truth.len(), 3000);
    // The truth's strains are in the readings, within noise and half a step.
    let limb = plate();
    let hello = &heard.hellos[0];
    let mut worst = 0.0_f64;
    for ((_, frame), truth) in heard.frames.iter().zip(&heard.truth) {
        assert_eq!((frame.seq, frame.t_device_us), (truth.seq, truth.t_device_us));
        let (mut strain, mut read) = ([0.0; 3], [0.0; 3]);
        for contact in &truth.contacts {
            limb.add_strain_ue(&contact.point, &contact.force_vector_n(), &mut strain);
        }
        frame.scaled(hello, &mut read);
        for (a, b) in strain.iter().zip(read) {
            worst = worst.max((a - b).abs());
        }
    }
    assert!(worst < 6.0, "{worst} µε off, noise is 1 µε");
    let rate_hz = heard.stats.rate_hz;
    assert!((rate_hz - 1000.0).abs() < 2.0, "{rate_hz} frames per second");
}

#[test]
fn a_damaged_wire_delivers_nothing_wrong_and_every_loss_is_counted() {
    let sent: BTreeMap<u32, Frame> =
        hear(plain(2), 30.0, &[]).frames.into_iter().map(|(_, frame)| (frame.seq, frame)).collect();
    let faults: [&[&str]; 6] = [
        &["bitflips=1e-5"],
        &["bitflips=1e-4"],
        &["drops=1e-4"],
        &["dups=1e-4"],
        &["bursts=1e-4x16", "drops=1e-5"],
        &["holes=2e-6x4096"],
    ];
    for faults in faults {
        let heard = hear(plain(2), 30.0, faults);
        let n_wrong = heard.frames.iter().filter(|(_, frame)| {
            let right = &sent[&frame.seq];
            (right.bits(), right.t_device_us) != (frame.bits(), frame.t_device_us)
        });
        assert_eq!(n_wrong.count(), 0, "{faults:?}");
        let (first, last) = (heard.frames[0].1.seq, heard.frames[heard.frames.len() - 1].1.seq);
        let n_missing = u64::from(last - first + 1) - heard.frames.len() as u64;
        let frames = heard.frames[1..].iter();
        let n_reported: u64 = frames.map(|(_, f)| u64::from(f.n_lost_before)).sum();
        assert!(n_missing > 0, "{faults:?}: nothing was hit");
        assert_eq!(n_reported, n_missing, "{faults:?}");
    }
}

#[test]
fn a_reset_has_a_new_boot_id_and_begins_again() {
    let heard = hear(plain(3), 3.0, &["reset=1.25"]);
    assert_eq!(heard.n_restarts, 1);
    let ids: Vec<u32> = heard.hellos.iter().map(|hello| hello.boot_id).collect();
    assert_eq!((ids[0], ids[ids.len() - 1]), (1, 2));
    assert_eq!(heard.frames.len(), 3000);
    assert_eq!(heard.stats.losses.n_lost, 0);
    for ((boot_id, frame), truth) in heard.frames.iter().zip(&heard.truth) {
        assert_eq!((*boot_id, frame.seq), (truth.boot_id, truth.seq));
        assert_eq!(frame.t_device_us, u64::from(frame.seq) * 1000);
    }
    assert_eq!(heard.truth[1250].seq, 0);
    assert!((heard.truth[1250].t_s - 1.25).abs() < 1e-12, "the play goes on");
}

#[test]
fn a_fast_clock_is_measured() {
    let params = RigDeviceParams {
        drift_ppm: 100.0,
        clock_offset_us: 5_000_000,
        ..RigDeviceParams::default()
    };
    let heard = hear(device(None, params, 4), 8.0, &[]);
    // In 8 s of true time a clock that is 100 ppm fast takes a sample more.
    assert_eq!(heard.frames.len(), 8001);
    assert_eq!(heard.frames[1].1.t_device_us, 5_001_000);
    let drift_ppm = heard.stats.drift_ppm;
    assert!((drift_ppm - 100.0).abs() < 1.0, "{drift_ppm} ppm");
    for ((_, frame), truth) in heard.frames.iter().zip(&heard.truth).skip(4000) {
        let off_ns = frame.t_host_ns as f64 - truth.t_s * 1e9;
        assert!(off_ns.abs() < 2e3, "{off_ns} ns at {}", truth.t_s);
    }
}

#[test]
fn a_seed_gives_the_same_bytes_again() {
    let bytes = |seed| {
        let params = RunParams {
            duration_s: Some(2.0),
            faults: vec!["bitflips=1e-4".parse().unwrap()],
            ..RunParams::default()
        };
        let mut link = RigLink::new(plain(seed), &params, |_| {}).unwrap();
        link.open().unwrap();
        let (mut all, mut buffer) = (Vec::new(), [0; 4096]);
        while let Ok(n) = link.read(&mut buffer, Duration::ZERO) {
            all.extend_from_slice(&buffer[..n]);
        }
        all
    };
    assert!(bytes(1).len() > 50_000);
    assert!(bytes(1) == bytes(1), "the same seed gives other bytes");
    assert!(bytes(1) != bytes(2));
}

#[test]
fn a_hand_presses_and_lets_go_and_the_device_stops_when_reported() {
    let mut device = device(None, RigDeviceParams::default(), 5);
    let handle = device.press_handle();
    let mut out = Vec::new();
    device.tick(usize::MAX, &mut out);
    assert!(device.truth().contacts.is_empty());
    handle.set(vec![Pressed::normal(1, Point3::new(0.05, 0.03, 0.0), 8.0)]);
    device.tick(usize::MAX, &mut out);
    assert!((device.truth().contacts[0].force_n - 8.0).abs() < 1e-12);
    handle.set(Vec::new());
    device.tick(usize::MAX, &mut out);
    assert!(device.truth().contacts.is_empty());
    let mut command = vec![0];
    let stop = hapdef_daq::hdp1::Command::Stop;
    hapdef_daq::hdp1::Encoder::new().command(stop, &mut command);
    device.answer(&command, device.next_t_s(), &mut out);
    out.clear();
    device.tick(usize::MAX, &mut out);
    assert!(out.is_empty(), "it goes on");
}

#[test]
fn what_finds_no_room_is_dropped_whole_and_counted() {
    let mut device = plain(6);
    let mut out = Vec::new();
    device.tick(usize::MAX, &mut out);
    let n = out.len();
    device.tick(n - 1, &mut out);
    assert_eq!(out.len(), n);
    assert_eq!((device.status().n_sent, device.status().n_tx_dropped), (1, 1));
    device.tick(n + 1, &mut out);
    assert_eq!((device.status().n_sent, device.truth().seq), (2, 2));
}

#[test]
fn what_can_not_be_is_refused() {
    let limb = plate();
    let largest = limb.largest_ue(30.0);
    let chain = LiveElectronics::new(electronics(1), 1000.0, &largest[..2]).unwrap();
    let made = RigDevice::new(limb, None, chain, RigDeviceParams::default());
    let error = made.err().unwrap().to_string();
    assert!(error.contains("one channel for each gauge"), "{error}");
    let faults = vec!["unplug=1+1".parse().unwrap()];
    let params = RunParams { faults, ..RunParams::default() };
    assert!(RigLink::new(plain(1), &params, |_| {}).is_err());
}
