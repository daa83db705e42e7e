//! `hapdef recalibrate` as a person uses it, with touches by the limb's own map.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use hapdef::touch::Calibration;
use hapdef::{Limb, Profile, Progress, Run};
use hapdef_inverse::ScanSites;
use serde_json::Value;

const FORCE_N: f64 = 15.0;

fn hapdef(words: &[&str], folder: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hapdef"));
    command.args(words).current_dir(folder).output().unwrap()
}

#[track_caller]
fn done(words: &[&str], folder: &Path) -> String {
    let output = hapdef(words, folder);
    assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[track_caller]
fn refused(words: &[&str], folder: &Path, expected: &[&str]) {
    let output = hapdef(words, folder);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{words:?}: {said}");
    for word in expected {
        assert!(said.contains(word), "{word:?} is not in: {said}");
    }
}

/// The bundled limb with its calibration, in a folder of its own.
fn copied(folder: &Path) -> PathBuf {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin");
    for name in ["demo.json", "demo_calibration.json.gz", "shin.inp.gz", "shin_skin.glb"] {
        std::fs::copy(from.join(name), folder.join(name)).unwrap();
    }
    folder.join("demo.json")
}

/// Lines of touches all over the limb whose gauges read 2 % more than the map says: place, force, readings.
fn lines(scene: &Path) -> Vec<String> {
    let results = scene.with_file_name("results");
    let run = Run::new(scene, Profile::quick(), &results, 1, Progress::silent()).unwrap();
    let limb = Limb::load(&run.scene, &run.scene_dir).unwrap();
    let spec = run.scene.estimator.superposition();
    let path = run.scene_dir.join(spec.calibration.as_ref().unwrap());
    let calibration = Calibration::read(&path, &limb).unwrap();
    let estimator = calibration.estimator(&run.scene, &spec, &limb).unwrap();
    let map = estimator.map();
    let line = |point: &hapdef_inverse::SkinPoint| {
        let [x, y, z] = map.skin().position(point).into();
        let mut line = format!("{x},{y},{z},{FORCE_N}");
        map.normal(point).iter().for_each(|g| write!(line, ",{}", 1.02 * g * FORCE_N).unwrap());
        line
    };
    ScanSites::farthest(map.skin(), 8).unwrap().points().iter().map(line).collect()
}

fn header(leading: &str) -> String {
    let gauges: Vec<String> = (0..10).map(|i| format!("g{i}_ue")).collect();
    format!("{leading},{}\n", gauges.join(","))
}

#[test]
fn touches_are_taken_refused_recorded_and_undone() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let scene = copied(folder);
    let calibration = folder.join("demo_calibration.json.gz");
    let as_pressed = std::fs::read(&calibration).unwrap();
    let mut lines = lines(&scene);
    // the fifth is declared where the seventh was
    let [wrong, place] = [lines[4].clone(), lines[6].clone()];
    let split = |line: &str| line.splitn(4, ',').map(str::to_owned).collect::<Vec<_>>();
    lines[4] = [&split(&place)[..3], &split(&wrong)[3..]].concat().join(",");
    let table = header("x_m,y_m,z_m,force_n") + &lines.join("\n");
    std::fs::write(folder.join("touches.csv"), table).unwrap();

    let said = done(&["recalibrate", "demo.json", "touches.csv"], folder);
    assert!(said.contains("touches.csv: line 6: refused: 15.0 N at"), "{said}");
    assert!(said.contains("7 of 8 touches taken"), "{said}");
    assert!(said.contains("g0     +2.") || said.contains("g0     +1."), "{said}");
    let journal = folder.join("demo_calibration.json.gz.touches.jsonl");
    let entries = std::fs::read_to_string(&journal).unwrap();
    let entries: Vec<Value> = entries.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    assert_eq!(entries.len(), 8);
    assert_eq!([&entries[3]["is_accepted"], &entries[4]["is_accepted"]], [true, false]);
    assert_eq!(entries[0]["from"], "touches.csv: line 2");
    assert_eq!(entries[4]["gains_before"], entries[4]["gains_after"]);

    let bundle = done(&["bundle", "demo.json", "-o", "a.hapdef", "--json"], folder);
    assert!(bundle.contains("\"is_calibrated\":true"), "{bundle}");
    let undone = done(&["recalibrate", "demo.json", "--undo", "2", "--json"], folder);
    let undone: Value = serde_json::from_str(&undone).unwrap();
    assert_eq!([&undone["n_undone"], &undone["n_touches"]], [2, 5]);
    let undone = done(&["recalibrate", "demo.json", "--undo"], folder);
    assert!(undone.contains("5 touches undone, 0 left; the calibration is as it was"), "{undone}");
    assert_eq!(std::fs::read(&calibration).unwrap(), as_pressed);
    assert_eq!(std::fs::read_to_string(&journal).unwrap().lines().count(), 10);
}

#[test]
fn tables_name_what_they_have_and_are_refused_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let scene = copied(folder);
    let lines = lines(&scene);
    let table = |text: &str| std::fs::write(folder.join("touches.csv"), text).unwrap();
    let words = ["recalibrate", "demo.json", "touches.csv", "--json"];

    // an untouched frame first, times, and how well each is known
    let zero = format!("0,0.03,0.1,0,0,5,0{}", ",7".repeat(10));
    let touch = |i: usize| {
        let fields: Vec<f64> = lines[i].split(',').map(|f| f.parse().unwrap()).collect();
        let readings: String = fields[4..].iter().map(|y| format!(",{}", y + 7.0)).collect();
        let place = lines[i].splitn(4, ',').take(3).collect::<Vec<_>>().join(",");
        format!("{i},{place},{FORCE_N},0.3,0.2{readings}")
    };
    let leading = "t_s,x_m,y_m,z_m,force_n,position_sd_mm,force_sd_n";
    table(&(header(leading) + &[zero, touch(1), touch(2)].join("\n")));
    let taken: Value = serde_json::from_str(&done(&words, folder)).unwrap();
    assert_eq!([&taken["n_taken"], &taken["n_refused"]], [2, 0], "{taken}");
    assert!((taken["zeros_ue"][3].as_f64().unwrap() - 7.0).abs() < 1.5, "{taken}");
    assert_eq!(taken["touches"][1]["t_s"], 2.0);

    table(&(header("t_s,x_m,y_m,z_m,force_n") + "-5," + &lines[0]));
    refused(&words, folder, &["touches.csv: line 2", "expected touches in the order of time"]);
    table(&(header("x_m,y_m,z_m,force_n") + &lines[0].replacen("0.", "9.", 1)));
    refused(&words, folder, &["touches.csv: line 2", "m from the skin"]);
    table(&(header("x_m,y_m,z_m,fx_n") + &lines[0]));
    refused(&words, folder, &["touches.csv: names of columns", "fx_n, fy_n, fz_n, found"]);
    table(&(header("x_m,y_m,z_m,force_n") + "0,0,0,0" + &",1".repeat(10)));
    refused(&words, folder, &["touches.csv: expected touches, found frames of force 0 alone"]);
    refused(&["recalibrate", "demo.json"], folder, &["<TABLE>"]);
    refused(&["recalibrate", "demo.json", "--undo", "9"], folder, &["expected 9 touches to undo"]);
    let text = std::fs::read_to_string(&scene).unwrap();
    let without = text.replace("\"calibration\": \"demo_calibration.json.gz\",", "");
    std::fs::write(&scene, without).unwrap();
    refused(&words, folder, &["shin-demo: estimator.calibration", "hapdef calibrate"]);
}
