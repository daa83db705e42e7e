//! The runtime over sources in memory: what it computes, what it loses, how it ends.

mod converter;
mod late;
mod priority;
use crate::support::endless;
mod stand_ins;
use crate::support;

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use endless::Endless;
use hapdef_daq::source::{LinkFault, LinkState, ReplaySource};
use hapdef_daq::{Frame, Message};
use hapdef_live::estimator::{SearchPlace, TouchWanted};
use hapdef_live::{
    Delivery, FnSink, GaugeHealth, Live, LiveBuilder, LiveError, LiveEvent, LiveParams, TouchPhase,
    Wants,
};
use stand_ins::{Asked, Probe};
use support::world::World;
use support::{N_GAUGES, bundle, messages, pressed, taken};

fn replay(messages: Vec<Message>) -> LiveBuilder {
    let source = ReplaySource::new("memory", messages.into_iter(), 0.0);
    Live::builder(source).params(LiveParams {
        tare_s: 0.0,
        is_recorded: true,
        is_lossless: true,
        ..LiveParams::default()
    })
}

#[test]
fn what_no_sink_wants_is_not_computed() {
    let world = World::new(N_GAUGES, 400, 5);
    let readings = pressed(&world, 100, 1);
    let run = |wants: Wants| {
        let asked = Asked::default();
        let live = replay(messages(&readings))
            .estimator(asked.clone())
            .sink(FnSink::new("probe", wants, |_| ()).with_delivery(Delivery::Queue(8)))
            .start()
            .unwrap();
        let health = live.wait().unwrap();
        assert_eq!(health.n_frames, 100);
        assert_eq!(health.n_estimated, asked.n.load(Ordering::Relaxed) as u64);
        let wanted = asked.wanted.lock().unwrap().first().copied();
        (health.n_conditioned, health.n_estimated, wanted)
    };
    let plain = TouchWanted::default();
    let all = TouchWanted { uncertainty: true, alternatives: true };
    assert_eq!(run(Wants::NOTHING), (0, 0, None));
    assert_eq!(run(Wants::RAW), (0, 0, None));
    assert_eq!(run(Wants::TARED), (100, 0, None));
    assert_eq!(run(Wants::CONTACTS), (100, 100, Some(plain)));
    assert_eq!(run(Wants::ALL), (100, 100, Some(all)));
}

/// Frames whose contacts come too late are counted, and the time of the stage that took it is reported.
#[test]
fn a_slow_estimator_misses_the_deadline() {
    let world = World::new(N_GAUGES, 400, 5);
    let readings = pressed(&world, 30, 1);
    let takes = Duration::from_millis(3);
    let run = |deadline: Duration| {
        let slow = Asked { takes, ..Asked::default() };
        let params = LiveParams {
            tare_s: 0.0,
            is_recorded: true,
            is_lossless: true,
            deadline,
            ..LiveParams::default()
        };
        let sink = FnSink::new("probe", Wants::CONTACTS, |_| ());
        let live = replay(messages(&readings))
            .params(params)
            .estimator(slow)
            .sink(sink.with_delivery(Delivery::Queue(8)));
        live.start().unwrap().wait().unwrap()
    };
    let late = run(Duration::from_millis(1));
    assert_eq!(late.n_deadline_missed, 30);
    let times = late.total;
    assert_eq!((times.estimate.n, times.compute.n), (30, 30));
    let takes_us = 0.97 * takes.as_secs_f64() * 1e6;
    assert!(times.estimate.p50_us >= takes_us, "{times:?}");
    assert!(times.compute.p50_us >= times.estimate.p50_us, "{times:?}");
    assert!(times.conditioning.p50_us < takes_us, "{times:?}");
    assert_eq!(run(Duration::from_secs(60)).n_deadline_missed, 0);
}

#[test]
fn contacts_without_an_estimator_are_refused() {
    let sink = FnSink::new("robot", Wants::CONTACTS, |_| ());
    let refused = replay(Vec::new()).sink(sink).start();
    let error = refused.map(|_| ()).unwrap_err();
    assert!(matches!(&error, LiveError::NoEstimator { sink } if sink == "robot"), "{error}");
}

/// A sink that never comes back loses frames, and nobody else does.
#[test]
fn a_stalled_sink_holds_up_nobody() {
    for delivery in [Delivery::Latest, Delivery::Queue(16)] {
        let (unblock, blocked) = std::sync::mpsc::channel::<()>();
        let stalled = Probe::new(delivery, move |_| {
            // until the test ends
            let _ = blocked.recv();
            Ok(())
        });
        let n_seen = Arc::new(AtomicUsize::new(0));
        let seen = Arc::clone(&n_seen);
        let good = Probe::new(Delivery::Queue(1024), move |frame| {
            assert_eq!(frame.n_skipped_before, 0);
            seen.fetch_add(1, Ordering::Relaxed);
            Ok(())
        });
        let live = Live::builder(Endless::new(N_GAUGES)).sink(stalled).sink(good);
        let live = live.start().unwrap();
        std::thread::sleep(Duration::from_millis(700));
        let start = Instant::now();
        let health = live.stop().unwrap();
        let took = start.elapsed();
        drop(unblock);
        let n = health.n_frames;
        println!("{delivery:?}: {n} frames, stop took {took:?}");
        assert!(n > 300 && health.n_dropped == 0 && health.n_lost == 0, "{health}");
        assert_eq!(n_seen.load(Ordering::Relaxed) as u64, n);
        let [stalled, good] = &health.sinks[..] else { panic!("{health:?}") };
        assert!(stalled.is_stuck && !good.is_stuck);
        let n_waiting = if delivery == Delivery::Latest { 1 } else { 15 };
        assert!(stalled.n_skipped + 1 + n_waiting >= n, "{stalled:?}");
        assert!(took < Duration::from_secs(4), "{took:?}");
    }
}

/// A slow sink receives the exact number of frames it has not seen, and what was lost among them.
#[test]
fn skipped_frames_are_counted_with_their_losses() {
    let world = World::new(N_GAUGES, 400, 5);
    let mut stream = messages(&pressed(&world, 600, 1));
    for (i, message) in stream.iter_mut().enumerate() {
        if let Message::Frame(frame) = message {
            frame.n_lost_before = (i % 3) as u32;
        }
    }
    let n_lost: u64 = (1..=600).map(|i| i % 3).sum();
    for delivery in [Delivery::Latest, Delivery::Queue(4)] {
        let sums = Arc::new(Mutex::new((0u64, 0u64)));
        let to = Arc::clone(&sums);
        let slow = Probe::new(delivery, move |frame| {
            let mut sums = to.lock().unwrap();
            sums.0 += 1 + u64::from(frame.n_skipped_before);
            sums.1 += u64::from(frame.n_lost_before);
            std::thread::sleep(Duration::from_micros(300));
            Ok(())
        });
        let source = ReplaySource::new("memory", stream.clone().into_iter(), 0.0);
        let params = LiveParams { tare_s: 0.0, ..LiveParams::default() };
        let live = Live::builder(source).params(params).sink(slow).start().unwrap();
        let health = live.wait().unwrap();
        let (n, lost) = *sums.lock().unwrap();
        assert_eq!((health.n_frames, health.n_lost), (600, n_lost));
        assert!(health.sinks[0].n_skipped > 100, "{:?}", health.sinks[0]);
        if delivery == Delivery::Latest {
            // the last frame is always shown
            assert_eq!((n, lost), (600, n_lost));
        } else {
            assert!(n <= 600 && lost <= n_lost, "{n} {lost}");
        }
    }
}

#[test]
fn restarts_and_reconnects_are_passed_on() {
    let world = World::new(N_GAUGES, 400, 5);
    let mut stream = messages(&pressed(&world, 50, 1));
    let name = "port".to_owned();
    stream.insert(0, Message::Link(LinkState::Open));
    let away = LinkState::Away(LinkFault::Disconnected { name });
    stream.splice(20..20, [Message::Link(away), Message::Link(LinkState::Open)]);
    stream.insert(40, Message::Restarted);
    let asked = Asked::default();
    let probe = Probe { wants: Wants::ALL, ..Probe::new(Delivery::Queue(8), |_| Ok(())) };
    let (events, is_finished) = (Arc::clone(&probe.events), Arc::clone(&probe.is_finished));
    let live = replay(stream).estimator(asked.clone()).sink(probe);
    let health = live.start().unwrap().wait().unwrap();
    assert_eq!((health.n_restarts, health.n_reconnects), (1, 1));
    assert_eq!(asked.n_over.load(Ordering::Relaxed), 2);
    let names: Vec<&str> = taken(&events)
        .iter()
        .map(|event| match event {
            LiveEvent::Link(LinkState::Open) => "open",
            LiveEvent::Link(_) => "away",
            LiveEvent::Hello(_) => "hello",
            LiveEvent::Restarted => "restarted",
            LiveEvent::Health(_) => "health",
            _ => "other",
        })
        .collect();
    assert_eq!(names, ["open", "hello", "away", "open", "restarted", "health"]);
    assert!(is_finished.load(Ordering::Acquire));
}

/// A gauge that sends NaN and one at the end of its range are left out; the contact stays.
#[test]
fn bad_gauges_are_left_out() {
    let world = World::new(N_GAUGES, 400, 5);
    let readings = pressed(&world, 900, 3);
    let mut stream = messages(&readings);
    for message in stream.iter_mut().skip(701) {
        if let Message::Frame(frame) = message {
            let mut counts = frame.bits().to_vec();
            counts[2] = i32::MAX;
            let (seq, us) = (frame.seq, frame.t_device_us);
            *frame = Frame::new(seq, frame.format, counts);
            frame.t_device_us = us;
        }
    }
    let last = Arc::new(Mutex::new(None));
    let to = Arc::clone(&last);
    let sink = FnSink::new("last", Wants::CONTACTS, move |frame| {
        *to.lock().unwrap() = Some(frame.clone());
    });
    let bundle = bundle(&world);
    let live = replay(stream)
        .bundle(&bundle)
        .params(LiveParams {
            tare_s: 0.2,
            is_recorded: true,
            is_lossless: true,
            ..LiveParams::default()
        })
        .estimator(bundle.tracking(SearchPlace::Here).unwrap())
        .sink(sink.with_delivery(Delivery::Queue(4)))
        .start()
        .unwrap();
    let health = live.wait().unwrap();
    let frame = last.lock().unwrap().take().unwrap();
    assert_eq!(frame.gauges[2], GaugeHealth::Saturated);
    assert_eq!(health.gauges, frame.gauges);
    assert_eq!(frame.phase, TouchPhase::Touched);
    assert_eq!(frame.touch.contacts.len(), 1, "{:?}", frame.touch);
    let contact = frame.touch.contacts[0];
    assert!((contact.force_n - 20.0).abs() < 1.0, "{contact:?}");
    assert_eq!(health.n_refused, 0, "{:?}", health.last_refusal);
}

#[test]
fn a_failing_sink_is_given_up_and_the_others_go_on() {
    let world = World::new(N_GAUGES, 400, 5);
    let bad = Probe::new(Delivery::Queue(8), |frame| {
        if frame.seq < 5 { Ok(()) } else { Err("the disk is full".into()) }
    });
    let n_seen = Arc::new(AtomicUsize::new(0));
    let seen = Arc::clone(&n_seen);
    let good = Probe::new(Delivery::Direct, move |_| {
        seen.fetch_add(1, Ordering::Relaxed);
        Ok(())
    });
    let stream = messages(&pressed(&world, 100, 1));
    let health = replay(stream).sink(bad).sink(good).start().unwrap().wait().unwrap();
    assert_eq!(n_seen.load(Ordering::Relaxed), 100);
    assert_eq!(health.sinks[0].failure.as_deref(), Some("the disk is full"));
    assert_eq!(health.sinks[1].n_frames, 100);
}

#[test]
fn another_device_is_refused_in_words() {
    let stream = messages(&vec![vec![0.0; 7]; 20]);
    let live = replay(stream)
        .estimator(Asked::default())
        .sink(FnSink::new("x", Wants::CONTACTS, |_| ()))
        .start()
        .unwrap();
    let health = live.wait().unwrap();
    assert_eq!((health.n_frames, health.n_unusable, health.n_estimated), (20, 20, 0));
    let fault = health.device_fault.unwrap();
    assert!(fault.contains("expected 10") && fault.contains('7'), "{fault}");
}

#[test]
fn it_stops_at_once_and_tares_again_on_command() {
    let probe = Probe { wants: Wants::TARED, ..Probe::new(Delivery::Queue(1024), |_| Ok(())) };
    let (events, is_finished) = (Arc::clone(&probe.events), Arc::clone(&probe.is_finished));
    let params = LiveParams { tare_s: 0.05, ..LiveParams::default() };
    let live = Live::builder(Endless::new(N_GAUGES)).params(params).sink(probe).start().unwrap();
    let control = live.control();
    std::thread::sleep(Duration::from_millis(300));
    control.tare();
    std::thread::sleep(Duration::from_millis(300));
    let start = Instant::now();
    let health = live.stop().unwrap();
    assert!(start.elapsed() < Duration::from_millis(500), "{:?}", start.elapsed());
    let n_tared = taken(&events).iter().filter(|event| matches!(event, LiveEvent::Tared)).count();
    assert_eq!(n_tared, 2, "{health}");
    assert!(is_finished.load(Ordering::Acquire));
    // dropping it stops it, too
    drop(Live::builder(Endless::new(N_GAUGES)).start().unwrap());
}
