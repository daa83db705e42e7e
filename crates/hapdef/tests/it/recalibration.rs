//! Gains that drift, followed by known touches: on the simulated rig, and in the files that are kept.

use std::path::{Path, PathBuf};

use hapdef::touch::{
    Calibration, DeclaredForce, DeclaredTouch, JournalEntry, Recalibrator, TouchAssumptions,
    make_bundle, touch_estimator,
};
use hapdef::{Limb, Profile, Progress, Run};
use hapdef_inverse::{ScanSites, TouchZero};

#[path = "../../examples/recalibration/study.rs"]
mod study;

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin").join(name)
}

/// The demo's limb with a calibration of its own, as it was pressed.
struct Pressed {
    run: Run,
    limb: Limb,
    /// The calibration's file.
    path: PathBuf,
    pressed: Calibration,
}

fn pressed(folder: &Path) -> Pressed {
    let scene = fixture("demo.json");
    let run = Run::new(&scene, Profile::quick(), folder, 2, Progress::silent()).unwrap();
    let limb = Limb::load(&run.scene, &run.scene_dir).unwrap();
    let path = folder.join("calibration.json");
    let pressed = Calibration::read(&fixture("demo_calibration.json.gz"), &limb).unwrap();
    pressed.write(&path).unwrap();
    Pressed { run, limb, path, pressed }
}

/// Simulated: contacts of gauges whose gains drift by up to 6 % are found as well as before after 30 known touches,
/// and every touch that is declared in a wrong place is refused.
#[test]
fn contacts_are_found_again_after_known_touches() {
    let out = tempfile::tempdir().unwrap();
    let rows = study::study(&fixture("demo.json"), out.path(), 60).unwrap();
    rows.iter().for_each(|row| println!("{row}"));
    let row = |name: &str| rows.iter().find(|row| row.name == name).unwrap();
    let off_mm = |name: &str| row(name).scores[0].median_mm;
    for n in ["10", "30", "100"] {
        let without = format!("none, at touch {n}");
        assert!(row(n).gain_error < 0.7 * row(&without).gain_error, "{n} touches");
        assert!(off_mm(n) < 0.7 * off_mm(&without), "{n} touches");
    }
    for n in ["30", "100"] {
        assert!(row(n).gain_error < 0.01, "{n} touches: {}", row(n).gain_error);
        assert!(off_mm(n) < 1.5 * off_mm("no drift"), "{n} touches: {} mm", off_mm(n));
        let sds = row(n).gain_error_sds.unwrap();
        assert!((0.4..2.0).contains(&sds), "{n} touches: {sds}");
    }
    let [wrong, right, taken] = row("100").n_refused;
    assert_eq!((wrong, taken), (10, 0));
    assert!(right <= 2, "{right} of 90 good touches refused");
}

/// Touches by the calibrated map itself, with `gain` on every gauge.
fn touches(calibration: &Calibration, run: &Run, limb: &Limb, gain: f64) -> Vec<DeclaredTouch> {
    let spec = run.scene.estimator.superposition();
    let estimator = calibration.estimator(&run.scene, &spec, limb).unwrap();
    let map = estimator.map();
    let sites = ScanSites::farthest(map.skin(), 12).unwrap();
    let touch = |(i, point): (usize, &hapdef_inverse::SkinPoint)| DeclaredTouch {
        from: format!("touch {i}"),
        t_s: Some(60.0 * i as f64),
        position_m: map.skin().position(point).into(),
        force: DeclaredForce::Normal(15.0),
        position_sd_m: 0.0,
        force_sd_n: 0.1,
        readings_ue: map.normal(point).iter().map(|g| g * 15.0 * (1.0 + gain)).collect(),
        zero: TouchZero::Tared,
    };
    sites.points().iter().enumerate().map(touch).collect()
}

#[test]
fn touches_are_recorded_and_undone_and_what_is_used_follows() {
    let folder = tempfile::tempdir().unwrap();
    let Pressed { mut run, limb, path, pressed } = pressed(folder.path());
    let as_pressed = std::fs::read(&path).unwrap();
    let touches = touches(&pressed, &run, &limb, 0.02);
    let assumed = TouchAssumptions::default();
    let mut after = Vec::new();
    for touch in &touches {
        // opened anew each time, as the command does
        let mut recalibrator = Recalibrator::open(&path, &limb).unwrap();
        assert!(recalibrator.touch(touch, &assumed, 7).unwrap().is_accepted);
        recalibrator.write().unwrap();
        after.push(std::fs::read(&path).unwrap());
    }
    let read = Calibration::read(&path, &limb).unwrap();
    let since = read.since.clone().unwrap();
    assert_eq!(since.n_touches, touches.len());
    assert!(since.gains.iter().all(|gain| (gain - 0.02).abs() < 0.01), "{:?}", since.gains);

    // contacts and bundle have the gains
    if let hapdef::scene::EstimatorSpec::Superposition(spec) = &mut run.scene.estimator {
        spec.calibration = Some(path.clone());
    }
    let spec = run.scene.estimator.superposition();
    let now = read.estimator(&run.scene, &spec, &limb).unwrap();
    let bundle = make_bundle(&run, &limb, String::new(), &Default::default()).unwrap();
    assert_eq!(bundle.map().nodal(), now.map().nodal());
    assert!(bundle.calibration_json.unwrap().contains("\"n_touches\":12"));
    assert!(touch_estimator(&run, &limb).is_ok());

    // a touch that does not fit is recorded, too, and changes nothing
    let mut recalibrator = Recalibrator::open(&path, &limb).unwrap();
    let elsewhere =
        DeclaredTouch { position_m: touches[5].position_m, t_s: Some(1e4), ..touches[0].clone() };
    let refused = recalibrator.touch(&elsewhere, &assumed, 8).unwrap();
    assert!(!refused.is_accepted && refused.chi2 > refused.limit);
    recalibrator.write().unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), after[11]);

    // back by three, then by all
    let too_many = recalibrator.undo(Some(13), 9).unwrap_err().to_string();
    assert!(too_many.contains("expected 13 touches to undo, found 12"), "{too_many}");
    assert_eq!(recalibrator.undo(Some(3), 9).unwrap(), 3);
    recalibrator.write().unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), after[8]);
    let mut recalibrator = Recalibrator::open(&path, &limb).unwrap();
    assert_eq!(recalibrator.undo(None, 10).unwrap(), 9);
    recalibrator.write().unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), as_pressed);
    let journal = std::fs::read_to_string(recalibrator.journal_path()).unwrap();
    let entry = |line: &str| serde_json::from_str::<JournalEntry>(line).unwrap();
    let is_undo = |line: &str| matches!(entry(line), JournalEntry::Undo(_));
    assert_eq!(journal.lines().map(is_undo).filter(|is| *is).count(), 2);
    assert_eq!(journal.lines().count(), 15);
}

#[test]
fn a_journal_that_does_not_fit_is_refused_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let Pressed { run, limb, path, pressed } = pressed(folder.path());
    let touches = touches(&pressed, &run, &limb, 0.0);
    let assumed = TouchAssumptions::default();
    let mut recalibrator = Recalibrator::open(&path, &limb).unwrap();
    recalibrator.touch(&touches[1], &assumed, 1).unwrap();
    let early = recalibrator.touch(&touches[0], &assumed, 1).unwrap_err().to_string();
    assert!(early.contains("order of time") && early.contains("touch 0"), "{early}");
    recalibrator.write().unwrap();
    let journal = recalibrator.journal_path().to_owned();
    std::fs::write(&journal, "{\"kind\": \"touch\"}\n").unwrap();
    let broken = Recalibrator::open(&path, &limb).err().unwrap().to_string();
    assert!(broken.contains("line 1: expected a touch or an undo"), "{broken}");
    std::fs::remove_file(&journal).unwrap();
    let mut recalibrator = Recalibrator::open(&path, &limb).unwrap();
    let lost = recalibrator.touch(&touches[2], &assumed, 1).unwrap_err().to_string();
    assert!(lost.contains("expected the 1 touches") && lost.contains("--undo"), "{lost}");
    assert_eq!(recalibrator.undo(None, 2).unwrap(), 0);
    recalibrator.write().unwrap();
    assert!(Calibration::read(&path, &limb).unwrap().since.is_none());
    assert!(recalibrator.touch(&touches[2], &assumed, 3).unwrap().is_accepted);
}

#[test]
fn of_two_programs_at_once_neither_loses_the_others_touches() {
    let folder = tempfile::tempdir().unwrap();
    let Pressed { run, limb, path, pressed } = pressed(folder.path());
    let touches = touches(&pressed, &run, &limb, 0.02);
    let assumed = TouchAssumptions::default();
    let [mut first, mut second] = [(); 2].map(|()| Recalibrator::open(&path, &limb).unwrap());
    first.touch(&touches[0], &assumed, 1).unwrap();
    second.touch(&touches[1], &assumed, 1).unwrap();
    first.write().unwrap();
    let files = || [&path, first.journal_path()].map(|path| std::fs::read(path).unwrap());
    let written = files();
    let refused = second.write().unwrap_err().to_string();
    assert!(refused.contains("another program has recorded touches"), "{refused}");
    assert_eq!(files(), written);
    // The first goes on, and so does the second once it has read what the first wrote.
    first.touch(&touches[2], &assumed, 2).unwrap();
    first.write().unwrap();
    let mut second = Recalibrator::open(&path, &limb).unwrap();
    second.touch(&touches[3], &assumed, 3).unwrap();
    second.write().unwrap();
    assert_eq!(Calibration::read(&path, &limb).unwrap().since.unwrap().n_touches, 3);
    // Presses that were taken anew meanwhile stay, too.
    second.touch(&touches[4], &assumed, 4).unwrap();
    pressed.write(&path).unwrap();
    let refused = second.write().unwrap_err().to_string();
    assert!(refused.contains("calibrated anew"), "{refused}");
    assert!(Calibration::read(&path, &limb).unwrap().since.is_none());
}
