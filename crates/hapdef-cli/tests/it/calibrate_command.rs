//! `hapdef calibrate --live` as a person uses it, the virtual rig pressed where it asks.

use crate::support::page;

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

const N_PRESSES: usize = 14;

/// Calibrates by guided presses of the virtual rig, which the docs' commands solve and keep.
fn calibrate(scene: &Path, table: &Path, result: &Path) -> Output {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    Command::new(env!("CARGO_BIN_EXE_hapdef"))
        .arg("calibrate")
        .args([scene, table, result])
        .args(["--live", "virtual", "--presses", &N_PRESSES.to_string()])
        .args(["--force-n", "15", "--json", "--results"])
        .arg(root.join("target/hapdef"))
        .output()
        .unwrap()
}

#[test]
fn it_guides_presses_writes_the_table_and_calibrates_once() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("presses.csv");
    let result = folder.path().join("calibration.json");
    let scene = page::scene(folder.path());
    let output = calibrate(&scene, &table, &result);
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{words}");
    for word in ["don't touch the limb", "press 14: 15 N at", "covered"] {
        assert!(words.contains(word), "{word:?} is not in: {words}");
    }
    let rows = std::fs::read_to_string(&table).unwrap();
    assert_eq!(rows.lines().count(), 1 + N_PRESSES);
    assert!(rows.starts_with("x_m,y_m,z_m,force_n,g0_ue"));
    let info: Value = serde_json::from_slice(&output.stdout).unwrap();
    let error = |key: &str| {
        let value = info[key].as_f64();
        value.unwrap_or_else(|| panic!("{key}: {info}"))
    };
    println!("{info}");
    assert!(error("relative_error") < error("relative_error_before"), "{info}");
    let kept: Value = serde_json::from_slice(&std::fs::read(&result).unwrap()).unwrap();
    assert_eq!(kept["n_presses"], N_PRESSES);

    // It tells people where to press: it can't be quiet.
    let words = ["calibrate", "scene.json", "table.csv", "out.json", "--live", "virtual", "-q"];
    let quiet = Command::new(env!("CARGO_BIN_EXE_hapdef")).args(words).output().unwrap();
    assert_eq!(quiet.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&quiet.stderr).contains("where to press"));

    // A table of presses may be a robot's: it is never overwritten.
    let refused = calibrate(&scene, &table, &result);
    let words = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!(refused.status.code(), Some(2), "{words}");
    assert!(words.contains("presses.csv: is there already"), "{words}");
    assert_eq!(std::fs::read_to_string(&table).unwrap(), rows);
}
