//! `hapdef shell`: what it writes, what it refuses, and real limbs.

use crate::shell_limb_common;

use std::path::Path;
use std::process::{Command, Output};

use hapdef_mesh::write_glb;
use shell_limb_common::{fixture, tube};

use crate::support::{is_long_run, shared, surface};

fn hapdef(words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hapdef")).arg("shell").args(words).output().unwrap()
}

fn said(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[track_caller]
fn refused(words: &[&str], expected: &[&str]) -> String {
    let output = hapdef(words);
    let text = said(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{text}");
    for words in expected {
        assert!(text.contains(words), "{words:?} is not in: {text}");
    }
    said(&output.stdout)
}

#[test]
fn the_command_reads_a_tube_and_writes_its_files() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("tube.glb");
    write_glb(&file, &tube(0.12), None).unwrap();
    let out = folder.path().join("out");
    let [file, out] = [&file, &out].map(|p| p.to_str().unwrap().to_owned());
    let words = [
        &file, "--unit", "m", "--wall", "measured", "--gauges", "3", "--edge", "5", "--solid",
        "--out", &out,
    ];
    let output = hapdef(&words);
    assert!(output.status.success(), "{}", said(&output.stderr));
    let table = said(&output.stdout);
    assert!(table.contains("best gauge"), "{table}");
    assert!(!table.contains("use the solid: "), "{table}");
    for name in [
        "scene.json",
        "skin.glb",
        "wall.txt",
        "response.glb",
        "thickness.glb",
        "response.safetensors",
        "shell-report.html",
        "shell-report.json",
    ] {
        assert!(Path::new(&out).join(name).exists(), "{name}");
    }
    let json = std::fs::read(Path::new(&out).join("response.json")).unwrap();
    let json: serde_json::Value = serde_json::from_slice(&json).unwrap();
    assert_eq!(json["limb"]["gauges"].as_array().unwrap().len(), 3);
    let skin = surface(&Path::new(&out).join("response.glb"));
    assert_eq!(json["limb"]["model"]["n_nodes"], skin.vertices().len());
    let checked =
        Command::new(env!("CARGO_BIN_EXE_hapdef")).arg("check").arg(&out).output().unwrap();
    assert!(checked.status.success(), "{}", said(&checked.stderr));
}

#[test]
fn inspect_counts_crossing_triangles() {
    let file = fixture("shin_skin.glb");
    let inspected = |more: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_hapdef"))
            .arg("inspect")
            .arg(&file)
            .args(more)
            .output();
        said(&output.unwrap().stdout)
    };
    let table = inspected(&[]);
    assert!(table.contains("crossing pairs      0\n"), "{table}");
    let json: serde_json::Value = serde_json::from_str(&inspected(&["--json"])).unwrap();
    assert_eq!(json["n_crossing_pairs"], 0);
    assert_eq!(json["crossings_m"].as_array().unwrap().len(), 0);
}

#[test]
fn without_a_unit_the_guess_is_told() {
    let file = fixture("shin_skin.glb");
    let file = file.to_str().unwrap();
    refused(&[file, "--wall", "1"], &["0.1100 units long: m (0.110 m)", "--unit"]);
    refused(&[file, "--unit", "m"], &["--wall"]);
    refused(&[file, "--unit", "m", "--wall", "0"], &["above 0"]);
}

/// A skin without a second wall has no thickness to measure.
#[test]
fn an_open_skin_is_no_solid() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let file = fixture("shin_skin.glb");
    let words = [file.to_str().unwrap(), "--unit", "m", "--wall", "measured", "--out", out];
    let said = refused(&words, &["a closed solid is wanted", "open edges", "252.898 cm3"]);
    assert!(said.contains("no part of the surface"), "{said}");
}

#[test]
fn a_wall_that_does_not_fit_asks_for_the_middle() {
    let file = fixture("shin_skin.glb");
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let words =
        [file.to_str().unwrap(), "--unit", "m", "--wall", "90", "--edge", "2.75", "--out", out];
    refused(&words, &["folds", "--side middle"]);
}

#[track_caller]
fn runs_through(file: &str) {
    let Some(path) = shared(&format!("inputs/limbs/{file}")) else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let words = [
        path.to_str().unwrap(),
        "--unit",
        "m",
        "--wall",
        "2",
        "--json",
        "--out",
        folder.path().to_str().unwrap(),
    ];
    let output = hapdef(&words);
    assert!(output.status.success(), "{}", said(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let limb = &report["limb"];
    let best = limb["median_best_ue_per_n"].as_f64().unwrap();
    println!("{file}: {best:.1} µε/N, {}", limb["model"]);
    assert!(best > 1.0);
    assert_eq!(limb["gauges"].as_array().unwrap().len(), 10);
    assert!(limb["model"]["worst_backward_error"].as_f64().unwrap() < 1e-11);
}

#[test]
fn kinova_forearm_runs_through() {
    runs_through("kinova_forearm.glb");
}

#[test]
fn alexander_shin_runs_through() {
    if !is_long_run() {
        return;
    }
    runs_through("alexander_left_shin.glb");
}

#[test]
fn hyq_lower_leg_runs_through() {
    runs_through("hyq_lowerleg.glb");
}

/// A surface that is no oriented body has no wall that could be measured; one of a given thickness is put
/// into its wrapped skin, if that is faithful.
#[track_caller]
fn dirty(file: &str, cause: &[&str], wrapped: Result<&str, &str>) {
    let Some(path) = shared(&format!("inputs/limbs/{file}")) else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let [path, out] = [path.as_path(), folder.path()].map(|p| p.to_str().unwrap());
    refused(&[path, "--unit", "m", "--wall", "measured", "--out", out], cause);
    let words = [path, "--unit", "m", "--wall", "2", "--gauges", "4", "--out", out];
    match wrapped {
        Err(why) => drop(refused(&words, &[why])),
        Ok(why) => {
            let output = hapdef(&words);
            let text = said(&output.stdout);
            assert!(output.status.success(), "{}", said(&output.stderr));
            assert!(text.contains("wrapped, as it can't be taken as it is") && text.contains(why));
        }
    }
}

#[test]
fn go2_calf_is_wrapped() {
    let cause = ["open edges", "non-manifold edges", "volume 166.102 cm3"];
    dirty("go2_calf.glb", &cause, Ok("volume 166.102 cm3"));
}

#[test]
fn poppy_part_is_refused() {
    let cause = ["7 non-manifold edges", "2 non-manifold vertices", "volume 38.874 cm3"];
    dirty("poppy_r_shin_part.glb", &cause, Err("not faithful"));
}
