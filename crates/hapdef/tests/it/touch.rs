//! Contacts on the bundled limb through the estimator that a scene chooses.

use std::path::{Path, PathBuf};

use hapdef::scene::{SuperpositionSpec, read_scene};
use hapdef::touch::{
    Calibration, LayoutParams, LayoutStudy, LimitsRequest, PressQuality, Touch, TouchEstimator,
    UncertainParams, UncertainResponse, limits, response_map, study_layouts, superposition,
    touch_estimator,
};
use hapdef::{Limb, Profile, Progress, Run};
use hapdef_inverse::{LimitParams, OtherLoads, Press, SkinPoint};
use hapdef_sim::GaugeStrain;

fn placed() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin/placed.json")
}

fn run_in(out: &Path) -> Run {
    Run::new(&placed(), Profile::quick(), out, 2, Progress::silent()).unwrap()
}

/// Two contacts pressed on the map itself are found where they are; nothing but the response is
/// computed, so the cache stays empty.
#[test]
fn a_superposition_scene_finds_two_contacts_and_computes_no_more() {
    let out = tempfile::tempdir().unwrap();
    let run = run_in(out.path());
    let limb = Limb::load(&run.scene, &run.scene_dir).unwrap();
    let map = response_map(&limb, run.scene.contact.tip_radius_m, 2).unwrap();
    let skin = map.skin();
    let press = |face: usize, force_n: f64| {
        let point = SkinPoint::new(skin, face, [0.5, 0.3, 0.2]).unwrap();
        let readings: Vec<f64> = map.normal(&point).iter().map(|g| g * force_n).collect();
        (skin.position(&point), force_n, readings)
    };
    let truth = [press(100, 20.0), press(1200, 8.0)];
    let readings: Vec<f64> = (0..10).map(|g| truth[0].2[g] + truth[1].2[g]).collect();
    let mut estimator = touch_estimator(&run, &limb).unwrap();
    let mut touch = Touch::default();
    estimator.estimate(&readings, &mut touch).unwrap();
    assert_eq!(estimator.name(), "superposition");
    assert_eq!(touch.contacts.len(), 2, "{touch:?}");
    for (found, (position, force_n, _)) in touch.contacts.iter().zip(&truth) {
        let miss_mm = (found.position_m - position).norm() * 1e3;
        assert!(miss_mm < 2.0, "{miss_mm} mm off");
        assert!((found.force_n - force_n).abs() < 1.0, "{} N", found.force_n);
        assert!(found.uncertainty.unwrap().position_sd_m() > 0.0);
    }
    estimator.estimate(&[0.0; 10], &mut touch).unwrap();
    assert!(touch.contacts.is_empty());
    assert!(!out.path().join("cache").exists());
}

#[test]
fn frames_of_another_length_and_nan_are_refused() {
    let out = tempfile::tempdir().unwrap();
    let run = run_in(out.path());
    let limb = Limb::load(&run.scene, &run.scene_dir).unwrap();
    let map = response_map(&limb, 0.0, 2).unwrap();
    let hapdef::scene::EstimatorSpec::Superposition(spec) = run.scene.estimator.clone() else {
        panic!("placed.json chooses superposition")
    };
    let mut estimator = superposition(&run.scene, &spec, map).unwrap();
    let mut touch = Touch::default();
    assert!(estimator.estimate(&[0.0; 9], &mut touch).is_err());
    let mut nan = [0.0; 10];
    nan[3] = f64::NAN;
    let error = estimator.estimate(&nan, &mut touch).unwrap_err();
    assert!(error.to_string().contains('3'), "{error}");
}

/// Halving the noise halves every bound, where there is one.
#[test]
fn bounds_are_proportional_to_the_noise() {
    let out = tempfile::tempdir().unwrap();
    let run = run_in(out.path());
    let limb = Limb::load(&run.scene, &run.scene_dir).unwrap();
    let request = |noise_ue| LimitsRequest {
        noise_ue,
        n_sites: 200,
        n_partners: 2,
        carried: LimitParams { n_draws: 20, ..LimitParams::default() },
    };
    let of = |noise_ue| {
        let map = response_map(&limb, 0.002, 2).unwrap();
        limits(map, OtherLoads::default(), &request(noise_ue)).unwrap()
    };
    let (fine, coarse) = (of(1.0), of(2.0));
    for (a, b) in fine.single_m.iter().zip(&coarse.single_m) {
        assert!(a.is_infinite() && b.is_infinite() || (b / a - 2.0).abs() < 1e-6);
    }
    assert!(fine.blind_nodes.len() <= coarse.blind_nodes.len());
    assert!(fine.carried[0].is_carried);
}

/// Presses on a limb whose gauges read 3 % more or less: the calibration finds it, comes back from
/// its file as it was, and is refused where a number is missing.
#[test]
fn a_calibration_corrects_the_map_and_survives_its_file() {
    let out = tempfile::tempdir().unwrap();
    let mut run = run_in(out.path());
    // the presses are on the map of the scene's own mesh
    if let hapdef::scene::EstimatorSpec::Superposition(spec) = &mut run.scene.estimator {
        spec.map_refinements = 0;
    }
    let limb = Limb::load(&run.scene, &run.scene_dir).unwrap();
    let map = response_map(&limb, run.scene.contact.tip_radius_m, 2).unwrap();
    let gain = |gauge: usize| if gauge.is_multiple_of(2) { 1.03 } else { 0.97 };
    let press = |i: usize| {
        let face = (37 * i) % map.skin().n_faces();
        let point = SkinPoint::new(map.skin(), face, [0.4, 0.4, 0.2]).unwrap();
        let force_n = 5.0 + (i % 25) as f64;
        let read = |(gauge, g): (usize, f64)| g * force_n * gain(gauge);
        let readings = map.normal(&point).into_iter().enumerate().map(read);
        Press { point, force_n, readings: readings.collect() }
    };
    let presses: Vec<Press> = (0..60).map(press).collect();
    let quality = PressQuality { noise_ue: 1.0, position_sd_m: 0.0, force_sd_n: 0.0 };
    let (calibration, info) = Calibration::fit(&run, &limb, &presses, &quality, 200).unwrap();
    assert_eq!(info.n_used, 60);
    assert!(calibration.relative_error_before > 0.02);
    assert!(
        calibration.relative_error < 0.3 * calibration.relative_error_before,
        "{} after {}",
        calibration.relative_error,
        calibration.relative_error_before
    );
    let packed = out.path().join("calibration.json.gz");
    let path = out.path().join("calibration.json");
    for path in [&packed, &path] {
        calibration.write(path).unwrap();
        let read = Calibration::read(path, &limb).unwrap();
        assert_eq!(read.adjoint_ue_per_n, calibration.adjoint_ue_per_n);
        assert_eq!(read.site_error, calibration.site_error);
    }
    let size = |path: &Path| std::fs::metadata(path).unwrap().len();
    assert!(2 * size(&packed) < size(&path));
    let read = Calibration::read(&path, &limb).unwrap();
    let spec = SuperpositionSpec::default();
    let estimator = read.estimator(&run.scene, &spec, &limb).unwrap();
    let found = estimator.estimate(&presses[7].readings).unwrap();
    let truth = map.skin().position(&presses[7].point);
    assert!((found.contacts[0].position_m - truth).norm() < 1e-3);
    let short = Calibration { n_sites: 199, ..read };
    short.write(&path).unwrap();
    let error = Calibration::read(&path, &limb).unwrap_err().to_string();
    assert!(error.contains("site_error"), "{error}");
}

/// What a calibration rests on is solved once for a layout of gauges, and kept in 32 bits.
#[test]
fn a_response_is_solved_once_for_each_layout() {
    let out = tempfile::tempdir().unwrap();
    let run = run_in(out.path());
    let limb = Limb::load(&run.scene, &run.scene_dir).unwrap();
    let params = UncertainParams {
        tip_radius_m: run.scene.contact.tip_radius_m,
        refinements: 0,
        n_stiffness: 2,
        n_threads: 2,
    };
    let [sites, others] = [&limb.sites[..4], &limb.sites[3..]].map(|sites| {
        let place = |site| {
            GaugeStrain::with_params(&limb.mesh, &limb.boundary.faces, site, &limb.gauge_params)
        };
        (sites, sites.iter().map(|site| place(site).unwrap()).collect::<Vec<_>>())
    });
    let kept = |(sites, gauges): &(&[_], Vec<_>)| {
        UncertainResponse::kept(&run, &limb, sites, gauges, &params).unwrap()
    };
    let n_stages = || {
        let files = std::fs::read_dir(out.path().join("cache")).unwrap();
        files.filter(|file| file.as_ref().unwrap().path().is_dir()).count()
    };
    let (first, made_s) = kept(&sites);
    let (again, told_s) = kept(&sites);
    assert_eq!((made_s.to_bits(), n_stages()), (told_s.to_bits(), 1));
    let solved = UncertainResponse::solve(&limb, sites.0, &sites.1, &params).unwrap();
    assert_eq!(solved.stiffness_modes.len(), 2);
    let maps = |response: &UncertainResponse| {
        let UncertainResponse { map, gauge_modes, stiffness_modes } = response.clone();
        [map].into_iter().chain(gauge_modes).chain(stiffness_modes).collect::<Vec<_>>()
    };
    for ((first, again), solved) in maps(&first).iter().zip(maps(&again)).zip(maps(&solved)) {
        let (first, solved) = (first.nodal(), solved.nodal());
        assert_eq!(first, again.nodal());
        let largest = solved.iter().fold(0.0_f64, |most, v| most.max(v.amax()));
        let off = first.iter().zip(&solved).fold(0.0_f64, |most, (a, b)| most.max((a - b).amax()));
        assert!(off < 1e-7 * largest, "{off} of {largest}");
    }
    let (other, _) = kept(&others);
    assert_eq!((other.map.n_gauges(), n_stages()), (others.0.len(), 2));
}

/// What `hapdef place` recommends fits its wall wherever it is glued within the margin.
#[test]
fn recommended_gauges_fit_when_glued_off_their_place() {
    let out = tempfile::tempdir().unwrap();
    let run = run_in(out.path());
    let limb = Limb::load(&run.scene, &run.scene_dir).unwrap();
    let study = |margin_m| {
        let params = LayoutParams {
            n_gauges: 6,
            n_positions: 60,
            n_axes: 2,
            n_sites: 100,
            margin_m,
            compares: false,
            other_counts: Vec::new(),
            ..LayoutParams::default()
        };
        study_layouts(&run, &limb, &params).unwrap()
    };
    let margin_m = 1.5e-3;
    let (free, kept) = (study(0.0), study(margin_m));
    assert!(kept.n_refused > free.n_refused);
    let gauge_at = |position, axis| {
        let site = run.scene.gauges.site(position, axis);
        GaugeStrain::with_params(&limb.mesh, &limb.boundary.faces, &site, &limb.gauge_params)
    };
    let best = kept.layouts.last().unwrap();
    assert_eq!(best.gauges.len(), 6);
    for placed in &best.gauges {
        // as a scene has it, to the micrometre: where walls meet, less decides which one it is on
        let written = placed.position_m.map(|x| (x * 1e6).round() / 1e6);
        assert_eq!(written, placed.position_m);
        let (position, axis) = (placed.position_m, placed.axis);
        let normal = gauge_at(position, axis).unwrap().normal();
        let across = normal.cross(&axis);
        for side in [axis, -axis, across, -across] {
            let moved = gauge_at(position + side * margin_m, axis).unwrap();
            assert!(moved.normal().dot(&normal) > 0.5, "{placed:?}: {side:?}");
        }
    }
}

/// With `beside_loads` `hapdef place` puts gauges where contacts are found beside them, not where they would be without:
/// by the bounds beside them, better than by chance.
#[test]
fn recommended_gauges_tell_contacts_from_the_scenes_loads() {
    let out = tempfile::tempdir().unwrap();
    let plain = run_in(out.path());
    let moving = read_scene(&placed().with_file_name("moving.json")).unwrap();
    let mut moved = run_in(out.path());
    moved.scene.loads = moving.loads;
    let params = LayoutParams {
        n_positions: 60,
        n_axes: 2,
        n_sites: 100,
        beside_loads: true,
        n_random: 5,
        compares: false,
        other_counts: Vec::new(),
        ..LayoutParams::default()
    };
    let [plain, moved] = [plain, moved].map(|run| {
        let limb = Limb::load(&run.scene, &run.scene_dir).unwrap();
        study_layouts(&run, &limb, &params).unwrap()
    });
    assert_eq!((plain.n_loads, moved.n_loads), (0, 9));
    let score = |study: &LayoutStudy, name: &str| {
        study.layouts.iter().find(|layout| layout.name == name).unwrap().score
    };
    let own = "the scene's own";
    assert!(score(&moved, own).single_mean_m > score(&plain, own).single_mean_m);
    let best = moved.layouts.last().unwrap();
    let random = score(&moved, "random, median of 5");
    assert!(best.score.single_mean_m < random.single_mean_m, "{:?}, {random:?}", best.score);
    assert!(best.score.pair_p95_m < random.pair_p95_m, "{:?}, {random:?}", best.score);
    assert_ne!(best.gauges, plain.layouts.last().unwrap().gauges);
}
