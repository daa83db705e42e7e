//! `--json`: one document on standard output and nothing else, with what the words say.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use hapdef_mesh::write_glb;
use serde_json::Value;

use crate::deck::BAR;
use crate::shell_limb_common::bottle;

fn hapdef(words: &[&str], folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hapdef"));
    command.args(words).arg("--json").current_dir(folder);
    command
}

/// The one document that it prints.
#[track_caller]
fn document(words: &[&str], folder: &Path) -> Value {
    let output = hapdef(words, folder).output().unwrap();
    assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn a_limb_from_its_surface_to_its_print() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_glb(&folder.join("bottle.glb"), &bottle(), None).unwrap();
    let new = ["new", "bottle.glb", "--yes", "--gauges", "4", "--edge", "12", "-o", "limb"];
    let made = document(&new, folder);
    let unit = made["guesses"].as_array().unwrap().iter().find(|guess| guess["what"] == "unit");
    assert!(!unit.unwrap()["why"].as_str().unwrap().is_empty(), "{made}");
    assert!(folder.join(made["scene"].as_str().unwrap()).is_file(), "{made}");

    let checked = document(&["check", "limb"], folder);
    assert_eq!(checked["n_gauges"], 4, "{checked}");
    assert!(checked["n_clamped_nodes"].as_u64().unwrap() > 0, "{checked}");
    assert_eq!(checked["is_calibrated"], false);

    let probed = document(&["probe", "limb", "presses.csv", "--presses", "3"], folder);
    assert_eq!([&probed["n_presses"], &probed["n_gauges"]], [3, 4]);
    assert_eq!(fs::read_to_string(folder.join("presses.csv")).unwrap().lines().count(), 4);

    let printed = document(&["print", "limb"], folder);
    assert_eq!(printed["places"].as_array().unwrap().len(), 4, "{printed}");
    assert!(printed["volume_m3"].as_f64().unwrap() > 1e-6, "{printed}");
    assert!(folder.join(printed["stl"].as_str().unwrap()).is_file());

    a_device_and_its_recording(folder);
}

/// The virtual rig on a port, and a recording of it.
fn a_device_and_its_recording(folder: &Path) {
    let words = ["rig", "limb", "--tcp", "127.0.0.1:0", "--seconds", "4"];
    let mut rig = hapdef(&words, folder).stdout(Stdio::piped()).spawn().unwrap();
    let lines = std::io::BufReader::new(rig.stdout.take().unwrap());
    let mut lines = serde_json::Deserializer::from_reader(lines).into_iter::<Value>();
    let port = lines.next().unwrap().unwrap()["port"].as_str().unwrap().to_owned();
    let source = if port.starts_with("tcp:") { port } else { format!("tcp:{port}") };
    let words = ["record", "--source", &source, "--seconds", "1", "-o", "press.mcap"];
    let recorded = document(&words, folder);
    assert!(recorded["n_frames"].as_u64().unwrap() > 100, "{recorded}");
    assert_eq!([&recorded["n_restarts"], &recorded["n_refused"]], [0, 0]);
    let happened = lines.next().unwrap().unwrap();
    assert!(happened["n_frames"].as_u64().unwrap() > 1000, "{happened}");
    assert!(lines.next().is_none() && rig.wait().unwrap().success());
}

#[test]
fn a_deck_solved() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("bar.inp"), BAR).unwrap();
    let solved = document(&["deck", "bar.inp", "--vtu", "bar.vtu"], folder.path());
    assert_eq!(solved["load_n"], serde_json::json!([0.0, 0.0, 1000.0]));
    // 1100 kg/m³ in a sixth of a cubic metre
    assert!((solved["mass_kg"].as_f64().unwrap() - 1100.0 / 6.0).abs() < 1e-9, "{solved}");
    assert!(solved["relative_residual"].as_f64().unwrap() < 1e-8, "{solved}");
    assert_eq!(solved["vtu"], "bar.vtu");
    assert!(solved["against"].is_null(), "{solved}");
}
