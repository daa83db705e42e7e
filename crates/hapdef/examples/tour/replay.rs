//! A recording, played into contacts by the runtime that runs on a robot.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::channel;
use std::time::Duration;

use anyhow::Result;
use hapdef_daq::hdp1::{Hello, SampleFormat};
use hapdef_daq::record::{RecordParams, Recording, record};
use hapdef_daq::source::ReplaySource;
use hapdef_daq::{AcquireParams, Frame, Message, acquire};
use hapdef_live::{Delivery, FnSink, Live, LiveParams, Wants};

use super::scene::Placed;

/// µε of a count.
const UE_PER_COUNT: f32 = 1.0 / 64.0;
/// Frames of the made-up recording, a millisecond each, and those before the press comes.
const N_FRAMES: u32 = 800;
const N_BEFORE: u32 = 300;

/// What a recording came to.
pub struct Played {
    pub n_frames: u64,
    pub n_touched: usize,
    /// Force of the last contact, N.
    pub last_n: f64,
}

/// Plays a recording of the bundled limb's gauges, a made-up one without a file: 15 N.
pub fn replay(file: Option<PathBuf>) -> Result<Played> {
    let placed = Placed::load()?;
    let made_up = std::env::temp_dir().join(format!("hapdef-tour-{}.mcap", std::process::id()));
    let path = match &file {
        Some(path) => path,
        None => {
            record_press(&placed, &made_up)?;
            &made_up
        }
    };
    let played = play(&placed, path);
    if file.is_none() {
        std::fs::remove_file(&made_up)?;
    }
    played
}

fn play(placed: &Placed, path: &Path) -> Result<Played> {
    let messages = Recording::open(path)?.messages();
    let source = ReplaySource::new("recording", messages, f64::INFINITY);
    let (sender, forces_n) = channel();
    let sink = FnSink::new("tour", Wants::CONTACTS, move |frame| {
        // Whoever plays listens until the end.
        let _ = sender.send(frame.touch.contacts.first().map(|c| c.force_n));
    });
    let params =
        LiveParams { is_recorded: true, is_lossless: true, tare_s: 0.2, ..LiveParams::default() };
    let live = Live::builder(source)
        .params(params)
        .estimator(placed.estimator()?)
        .sink(sink.with_delivery(Delivery::Queue(64)))
        .start()?;
    let n_frames = live.wait()?.n_frames;
    let touched: Vec<f64> = forces_n.iter().flatten().collect();
    Ok(Played {
        n_frames,
        n_touched: touched.len(),
        last_n: touched.last().copied().unwrap_or(0.0),
    })
}

/// Nothing, then 15 N that come in 40 ms and stay.
fn record_press(placed: &Placed, path: &Path) -> Result<()> {
    let (_, press_ue) = placed.press(700, 15.0)?;
    let mut hello = Hello::plain(press_ue.len(), SampleFormat::I32, 1000);
    hello.channels.iter_mut().for_each(|c| c.scale = UE_PER_COUNT);
    hello.seal();
    let frame = move |i: u32| {
        let share = (f64::from(i.saturating_sub(N_BEFORE)) / 40.0).min(1.0);
        let wobble = |g: usize| ((12.9 * f64::from(i) + 78.2 * g as f64).sin() * 43_758.5).fract();
        let readings = press_ue.iter().enumerate().map(|(g, ue)| ue * share + 0.5 * wobble(g));
        let counts = readings.map(|ue| (ue / f64::from(UE_PER_COUNT)).round() as i32);
        let mut frame = Frame::new(i, SampleFormat::I32, counts);
        frame.t_device_us = 1000 * u64::from(i);
        frame.t_host_ns = 1_000_000 * u64::from(i);
        Message::Frame(frame)
    };
    let hello = Message::Hello(Arc::new(hello));
    let messages = std::iter::once(hello).chain((0..N_FRAMES).map(frame));
    let source = ReplaySource::new("made up", messages, f64::INFINITY);
    let (acquisition, mut receivers) = acquire(source, AcquireParams::default())?;
    let params = RecordParams { min_free_bytes: 1 << 20, ..RecordParams::default() };
    let recorder = record(receivers.remove(0), path, params)?;
    while !acquisition.has_ended() {
        std::thread::sleep(Duration::from_millis(1));
    }
    recorder.finish()?;
    Ok(())
}

#[test]
fn a_recording_is_played_into_contacts() {
    let played = replay(None).unwrap();
    assert_eq!(played.n_frames, u64::from(N_FRAMES));
    // The press is there for 500 frames; the first ones are in the noise.
    assert!((480..=500).contains(&played.n_touched), "{}", played.n_touched);
    assert!((played.last_n - 15.0).abs() < 0.2, "{} N", played.last_n);
}
