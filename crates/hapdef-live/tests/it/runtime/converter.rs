//! The noise of a converter's steps reaches the estimator.

use std::sync::Arc;

use hapdef_daq::{Frame, Message};
use hapdef_live::{Delivery, FnSink, LiveParams, Wants};

use super::replay;
use super::stand_ins::Asked;
use crate::support::{N_GAUGES, hello, messages};

/// Rounding to steps of h adds h²/12 to the variance (W. R. Bennett, Bell Syst. Tech. J. 27, 1948); the
/// estimator receives when the device is known, and again what the tare measures beyond that.
#[test]
fn the_converters_step_counts_as_noise() {
    const STEP_UE: f32 = 4.0;
    let assumed = 1.0_f64.hypot(f64::from(STEP_UE) / 12.0_f64.sqrt());
    let mut stream = messages(&vec![vec![0.0; N_GAUGES]; 400]);
    let mut coarse = hello(N_GAUGES);
    coarse.channels.iter_mut().for_each(|c| c.scale = STEP_UE);
    coarse.seal();
    stream[0] = Message::Hello(Arc::new(coarse));
    for (i, message) in stream.iter_mut().skip(1).enumerate() {
        if let Message::Frame(frame) = message {
            let mut counts = vec![0; N_GAUGES];
            // 5 steps up and down: a standard deviation of 20 µε
            counts[3] = if i % 2 == 0 { 5 } else { -5 };
            let us = frame.t_device_us;
            *frame = Frame::new(frame.seq, frame.format, counts);
            frame.t_device_us = us;
        }
    }
    let asked = Asked::default();
    let live = replay(stream)
        .params(LiveParams {
            tare_s: 0.2,
            is_recorded: true,
            is_lossless: true,
            ..LiveParams::default()
        })
        .estimator(asked.clone())
        .sink(FnSink::new("probe", Wants::CONTACTS, |_| ()).with_delivery(Delivery::Queue(8)))
        .start()
        .unwrap();
    live.wait().unwrap();
    let least_ue = asked.least_ue.lock().unwrap();
    assert_eq!(least_ue.len(), 2, "{least_ue:?}");
    assert_eq!(least_ue[0], [assumed; N_GAUGES]);
    assert!((least_ue[1][3] - 20.0).abs() < 0.1, "{least_ue:?}");
    assert!((0..N_GAUGES).all(|g| g == 3 || least_ue[1][g] == assumed));
}
