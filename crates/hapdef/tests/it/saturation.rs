//! A press beyond the full scale of the virtual rig's converter, whose bits are fewer than its numbers'.

#[path = "../../../hapdef-rig/tests/it/live_support/mod.rs"]
mod live_support;

use std::sync::mpsc::channel;

use hapdef_daq::source::{StreamParams, StreamSource};
use hapdef_live::{Delivery, FnSink, GaugeHealth, Live, LiveParams, Wants};
use hapdef_rig::ElectronicsParams;
use hapdef_rig::live::{
    LiveElectronics, Play, PressEvent, PressScript, RigDevice, RigDeviceParams, RigLink, RunParams,
    ScriptedContact,
};
use live_support::{N_GAUGES, electronics, plate};

/// The plate with a converter of 12 bits, pressed with three times its full scale from 1.5 s to 4 s.
fn device() -> RigDevice {
    let events = vec![
        PressEvent::Arrive {
            at_s: 1.5,
            for_s: 0.05,
            position_m: [0.09, 0.05, 0.0],
            force_n: 150.0,
            shear_n: [0.0; 3],
        },
        PressEvent::Leave { at_s: 4.0, for_s: 0.05 },
    ];
    let script = PressScript::new(vec![ScriptedContact { id: 1, events }]);
    let limb = plate();
    let play = Play::new(&script, &limb).unwrap();
    let mut params = electronics(1);
    params.converter = ElectronicsParams { adc_bits: 12, ..params.converter };
    let device = RigDeviceParams::default();
    let largest = limb.largest_ue(30.0);
    let electronics = LiveElectronics::new(params, device.rate_hz, &largest).unwrap();
    RigDevice::new(limb, Some(play), electronics, device).unwrap()
}

#[test]
fn gauges_beyond_their_converter_are_told_and_left_out() {
    let params = RunParams { duration_s: Some(6.0), ..RunParams::default() };
    let link = RigLink::new(device(), &params, |_| {}).unwrap();
    let clock = link.clock();
    let stream = StreamParams { clock: clock.clone(), ..StreamParams::default() };
    let (sender, frames) = channel();
    let sink = FnSink::new("test", Wants::TARED, move |frame| {
        let gauges = frame.gauges.iter().zip(&frame.tared_ue);
        let gauges: Vec<(GaugeHealth, f64)> = gauges.map(|(h, y)| (*h, *y)).collect();
        sender.send((frame.t_device_us, gauges)).unwrap();
    });
    let live = Live::builder(StreamSource::new(link, stream))
        .params(LiveParams { is_lossless: true, clock, ..LiveParams::default() })
        .sink(sink.with_delivery(Delivery::Queue(64)))
        .start()
        .unwrap();
    let health = live.wait().unwrap();
    assert_eq!((health.n_frames, health.n_lost), (6000, 0));
    let mut n_pressed = 0;
    for (t_us, gauges) in frames {
        assert_eq!(gauges.len(), N_GAUGES);
        let n_out = gauges.iter().filter(|g| g.0 == GaugeHealth::Saturated).count();
        match t_us {
            // The device tells which channels they are each second, at 2 s for the first time.
            2_001_000..4_000_000 => {
                assert!(n_out > 0, "{t_us} µs: {gauges:?}");
                let mut left_out = gauges.iter().filter(|g| g.0 == GaugeHealth::Saturated);
                assert!(left_out.all(|g| g.1 == 0.0), "{t_us} µs: {gauges:?}");
                n_pressed += 1;
            }
            ..1_500_000 | 5_000_000.. => assert_eq!(n_out, 0, "{t_us} µs: {gauges:?}"),
            _ => {}
        }
    }
    assert!(n_pressed > 1900, "{n_pressed}");
}
