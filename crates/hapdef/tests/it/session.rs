//! A guided calibration of the bundled limb, pressed by the virtual rig: no port, no clock, the same
//! every time.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use hapdef::scene::{EstimatorSpec, SuperpositionSpec};
use hapdef::session::{
    CalibrationSession, HeldPress, SessionEvent, SessionParams, write_press_table,
};
use hapdef::touch::{PressQuality, response_map};
use hapdef::{Limb, Profile, Progress, Run, VirtualRigParams, virtual_device};
use hapdef_daq::Message;
use hapdef_daq::source::{FrameSource, StreamParams, StreamSource};
use hapdef_inverse::{ResponseMap, SkinPoint};
use hapdef_rig::live::{LiveLimb, LiveSurface, PressHandle, Pressed, RigLink, RunParams};
use nalgebra::Point3;

const N_PRESSES: usize = 20;
const FORCE_N: f64 = 15.0;

fn placed() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin/placed.json")
}

/// How the limb differs from the one that is drawn: each gauge's gain, and a swell along the limb.
fn swell(gauge: usize, x: &Point3<f64>) -> f64 {
    1.0 + 0.02 * (gauge as f64 - 4.5) / 4.5 + 0.1 * (x.y * 40.0 + gauge as f64).sin()
}

fn other_limb(limb: &Limb, map: &ResponseMap) -> LiveLimb {
    let n_gauges = limb.gauges.len();
    let place = |node| limb.skin.nodes.partition_point(|other| *other < node) as u32;
    let surface = LiveSurface {
        nodes: limb.surface_points(),
        faces: limb.skin.faces.iter().map(|f| f.nodes.map(place)).collect(),
        inward: limb.directions.clone(),
    };
    let nodal = map.nodal();
    let columns = nodal.iter().enumerate().map(|(i, column)| {
        let (node, gauge) = (i / n_gauges, i % n_gauges);
        column * swell(gauge, &surface.nodes[node])
    });
    let columns = columns.collect();
    LiveLimb::new(surface, n_gauges, columns).unwrap()
}

/// Does as it is told, but lets go of the second press at once the first time.
struct Prober {
    handle: PressHandle,
    n_early: usize,
    n_told: usize,
    held: Vec<HeldPress>,
}

impl Prober {
    fn obey(&mut self, event: &SessionEvent) {
        match event {
            SessionEvent::Press(asked) => {
                assert_eq!(asked.index, self.held.len());
                self.press(asked.position_m, asked.force_n);
            }
            SessionEvent::Touched if self.held.len() == 1 && self.n_early == 0 => {
                self.n_early += 1;
                self.handle.set(Vec::new());
            }
            SessionEvent::LetGo => self.n_told += 1,
            SessionEvent::Held(held) => {
                self.held.push(*held);
                self.handle.set(Vec::new());
            }
            _ => {}
        }
    }

    fn press(&self, position_m: Point3<f64>, force_n: f64) {
        self.handle.set(vec![Pressed::normal(1, position_m, force_n)]);
    }
}

/// Runs the session to its end; its frames are those of the virtual rig.
fn guide(session: &mut CalibrationSession, link: RigLink, prober: &mut Prober) -> usize {
    let clock = link.clock();
    let params = StreamParams { clock, ..StreamParams::default() };
    let mut source = StreamSource::new(link, params);
    let (mut hello, mut frames, mut n_frames) = (None, Vec::new(), 0);
    let mut asked = None;
    loop {
        source.poll(Duration::ZERO, &mut |message| match message {
            Message::Frame(frame) => frames.push(frame),
            Message::Hello(said) => hello = Some(said),
            _ => {}
        });
        for frame in frames.drain(..) {
            let mut readings = [0.0; 64];
            let n = frame.scaled(hello.as_ref().unwrap(), &mut readings);
            n_frames += 1;
            assert!(n_frames < 100_000, "the session goes on and on");
            if let Some(event) = session.frame(&readings[..n]).unwrap() {
                prober.obey(&event);
                if event == SessionEvent::LetGo {
                    asked = session.asked();
                }
                if event == SessionEvent::Done {
                    return n_frames;
                }
            }
            if let Some(again) = asked.take() {
                prober.press(again.position_m, again.force_n);
            }
        }
    }
}

/// Root mean square of the error of `map` over that of the truth, at points all over the skin.
fn map_error(map: &ResponseMap, truth: &LiveLimb) -> f64 {
    let skin = map.skin();
    let (mut error, mut size) = (0.0, 0.0);
    for face in (0..skin.n_faces()).step_by(7) {
        let point = SkinPoint::new(skin, face, [0.4, 0.3, 0.3]).unwrap();
        let (at, _) = truth.nearest(&skin.position(&point)).unwrap();
        let mut right = vec![0.0; truth.n_gauges()];
        truth.add_strain_ue(&at, &truth.inward(&at), &mut right);
        for (g, r) in map.normal(&point).iter().zip(&right) {
            error += (g - r).powi(2);
            size += r * r;
        }
    }
    (error / size).sqrt()
}

/// Share of `points` within 12 mm of a press.
fn share_near_presses(points: &[Point3<f64>], session: &CalibrationSession) -> f64 {
    let rows = session.rows();
    let is_near = |x: &&Point3<f64>| rows.iter().any(|row| (row.position_m - **x).norm() <= 12e-3);
    points.iter().filter(is_near).count() as f64 / points.len() as f64
}

#[test]
fn a_session_asks_holds_and_improves_the_map() {
    let out = tempfile::tempdir().unwrap();
    let mut run = Run::new(&placed(), Profile::quick(), out.path(), 2, Progress::silent()).unwrap();
    run.scene.rig.electronics.adc_bits = 16;
    // The made-up limb is made from the map of the scene's own mesh.
    run.scene.estimator = EstimatorSpec::Superposition(SuperpositionSpec {
        map_refinements: 0,
        ..run.scene.estimator.superposition()
    });
    let limb = Limb::load(&run.scene, &run.scene_dir).unwrap();
    let drawn = response_map(&limb, run.scene.contact.tip_radius_m, 2).unwrap();
    let truth = Arc::new(other_limb(&limb, &drawn));
    let device = virtual_device(&run.scene, Arc::clone(&truth), &VirtualRigParams::default());
    let device = device.unwrap();
    let mut prober =
        Prober { handle: device.press_handle(), n_early: 0, n_told: 0, held: Vec::new() };
    let link = RigLink::new(device, &RunParams::default(), |_| {}).unwrap();
    let quality = PressQuality {
        noise_ue: run.scene.rig.electronics.noise_ue,
        position_sd_m: 0.0,
        force_sd_n: 0.0,
    };
    let params =
        SessionParams { n_stiffness: 4, ..SessionParams::new(N_PRESSES, FORCE_N, 1000.0, quality) };
    let mut session = CalibrationSession::new(&run, &limb, params).unwrap();
    let n_frames = guide(&mut session, link, &mut prober);
    assert_eq!(prober.held.len(), N_PRESSES);
    assert_eq!((prober.n_early, prober.n_told), (1, 1));
    // The readings kept are those of the presses.
    let mut worst = 0.0_f64;
    for row in session.rows() {
        let (at, off_m) = truth.nearest(&row.position_m).unwrap();
        assert!(off_m < 1e-4, "{off_m} m off the skin");
        let mut right = vec![0.0; truth.n_gauges()];
        truth.add_strain_ue(&at, &(truth.inward(&at) * row.force_n), &mut right);
        for (a, b) in row.readings_ue.iter().zip(&right) {
            worst = worst.max((a - b).abs());
        }
    }
    assert!(worst < 1.0, "{worst} µε, noise of a frame is 1 µε");
    let coverage = prober.held.iter().map(|held| held.progress.coverage);
    assert!(coverage.is_sorted(), "presses cover less and less");
    let progress = session.progress();
    let covered = share_near_presses(&limb.surface_points(), &session);
    let (before, after) = (map_error(&drawn, &truth), map_error(session.map(), &truth));
    println!(
        "{n_frames} frames; map {:.2} % off before, {:.2} % after {N_PRESSES} presses; {progress:?}",
        before * 100.0,
        after * 100.0
    );
    // Counted at sites spread evenly there, at the mesh's nodes here.
    assert!((progress.coverage - covered).abs() < 0.1, "{covered} of the nodes");
    assert!(after < 0.8 * before, "{before} before, {after} after");
    let table = out.path().join("presses.csv");
    write_press_table(&table, &session.rows()).unwrap();
    let text = std::fs::read_to_string(table).unwrap();
    assert!(text.starts_with("x_m,y_m,z_m,force_n,g0_ue,"), "{text}");
    assert_eq!(text.lines().count(), N_PRESSES + 1);
}
