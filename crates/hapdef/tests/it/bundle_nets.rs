//! The runtime with a bundle's nets finds what the whole pipeline's nets find, bit for bit, through
//! the same wire.

use std::path::Path;
use std::sync::{Arc, mpsc::channel};

use hapdef::scene::{ContactRegion, RigMesh};
use hapdef::touch::{
    BundleRequest, EstimatorKind, SearchPlace, Touch, TouchEstimator, make_bundle, touch_estimator,
};
use hapdef::{Limb, Profile, Progress, Run, Schedule};
use hapdef_daq::hdp1::{Hello, SampleFormat};
use hapdef_daq::source::ReplaySource;
use hapdef_daq::{Frame, Message};
use hapdef_live::{Bundle, Delivery, FnSink, Live, LiveError, LiveGauge, LiveParams, Wants};

/// µε per count.
const SCALE: f32 = 1.0 / 1024.0;

/// Nets that have hardly learned anything: they find something, and that is enough.
fn brief() -> Profile {
    let quick = Profile::quick();
    let few = |schedule: Schedule| Schedule { steps: 20, ..schedule };
    Profile {
        n_single: 200,
        n_multi: 50,
        n_real_single: 200,
        n_pairs: 4,
        n_amplitudes: 4,
        transfer: few(quick.transfer),
        reconstruction: few(quick.reconstruction),
        sensitivity: few(quick.sensitivity),
        ..quick
    }
}

/// Contacts on a part of the skin, and a rig of the limb's own elements.
fn on_a_part(run: &mut Run) {
    if let ContactRegion::Radial { axial_range_m, .. } = &mut run.scene.contact.region {
        *axial_range_m = [0.09, 0.12];
    }
    let solid_deck = run.scene.geometry.shape.file().to_owned();
    run.scene.rig.mesh = RigMesh::Deck { solid_deck, refinements: 0 };
}

/// HELLO and frames of presses at some nodes of the skin.
fn messages(bundle: &Bundle) -> Vec<Message> {
    let map = bundle.map();
    let points: Vec<_> = bundle.skin().node_points().into_iter().flatten().collect();
    let mut hello = Hello::plain(map.n_gauges(), SampleFormat::I32, 1000);
    hello.channels.iter_mut().for_each(|c| c.scale = SCALE);
    hello.seal();
    let frame = |i: usize| {
        let [a, b] = [i * 37, i * 101 + 500].map(|at| map.normal(&points[at % points.len()]));
        let force_n = 3.0 + i as f64;
        let counts = a.iter().zip(&b).map(|(a, b)| {
            let reading_ue = (a + 0.5 * b) * force_n;
            (reading_ue / f64::from(SCALE)).round() as i32
        });
        let mut frame = Frame::new(i as u32, SampleFormat::I32, counts);
        frame.t_device_us = 1000 * i as u64;
        frame.t_host_ns = 1_000_000 * i as u64;
        Message::Frame(frame)
    };
    let hello = Message::Hello(Arc::new(hello));
    std::iter::once(hello).chain((0..24).map(frame)).collect()
}

/// What the runtime finds with an estimator.
fn found(bundle: &Bundle, estimator: Box<dyn TouchEstimator>) -> Vec<Touch> {
    let (sender, received) = channel();
    let sink = FnSink::new("test", Wants::ALL, move |frame| {
        sender.send(frame.touch.clone()).unwrap();
    });
    let gauges = bundle
        .info
        .gauges
        .iter()
        .map(|gauge| LiveGauge { name: gauge.name.clone(), scale: gauge.scale });
    let source = ReplaySource::new("memory", messages(bundle).into_iter(), 0.0);
    let live = Live::builder(source)
        .params(LiveParams {
            is_recorded: true,
            is_lossless: true,
            tare_s: 0.0,
            ..LiveParams::default()
        })
        .gauges(gauges.collect())
        .boxed_estimator(estimator)
        .sink(sink.with_delivery(Delivery::Queue(4)))
        .start()
        .unwrap();
    assert_eq!(live.wait().unwrap().n_refused, 0);
    received.iter().collect()
}

#[test]
fn a_bundles_nets_are_the_scenes() {
    let out = tempfile::tempdir().unwrap();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin/scene.json");
    let mut run = Run::new(&scene, brief(), out.path(), 2, Progress::silent()).unwrap();
    on_a_part(&mut run);
    let limb = Limb::load(&run.scene, &run.scene_dir).unwrap();
    let whole = touch_estimator(&run, &limb).unwrap();
    assert_eq!(whole.name(), "hapdefx");
    let text = std::fs::read_to_string(&scene).unwrap();
    let made = make_bundle(&run, &limb, text, &BundleRequest::default()).unwrap();
    let bundle = Bundle::from_bytes(&made.to_bytes().unwrap(), "test").unwrap();
    assert_eq!(bundle.info.estimator, EstimatorKind::Hapdefx);
    let expected = found(&bundle, whole);
    let n_contacts: usize = expected.iter().map(|touch| touch.contacts.len()).sum();
    assert!(expected.len() == 24 && n_contacts >= 24, "{n_contacts} contacts");
    let bundled = bundle.estimator(None, SearchPlace::Here).unwrap();
    assert_eq!(found(&bundle, bundled), expected);

    for name in bundle.nets.keys() {
        let mut less = bundle.clone();
        less.nets.remove(name);
        let error = less.paper_chain().err().unwrap();
        assert!(matches!(error, LiveError::NotABundle { .. }), "{error}");
        assert!(error.to_string().contains(name.as_str()), "{error}");
    }
}
