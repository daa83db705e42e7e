//! One seed gives one result, on one and on two threads: datasets, nets, scores, tables and verdicts.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread;

use hapdef_mesh::{ShinParams, shin, write_inp};
use serde_json::{Value, json};

/// The bundled limb in coarse elements, without its holes.
fn scene(folder: &Path) -> PathBuf {
    let params = ShinParams {
        panel_cells: (2, 2),
        n_rib_layers: 1,
        holes: Vec::new(),
        ..ShinParams::default()
    };
    let limb = shin(&params).unwrap();
    write_inp(&folder.join("limb.inp"), &limb.deck).unwrap();
    let bundled = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin/scene.json");
    let text = fs::read_to_string(bundled).unwrap();
    let mut scene: Value = serde_json::from_str(&text).unwrap();
    scene["geometry"]["solid_deck"] = json!("limb.inp");
    let path = folder.join("scene.json");
    fs::write(&path, scene.to_string()).unwrap();
    path
}

/// Runs the whole pipeline with few samples and steps, F_R in modes; returns the bytes of what it left, without
/// the records that hold times.
fn results(scene: &Path, threads: &str) -> BTreeMap<PathBuf, Vec<u8>> {
    let out = tempfile::tempdir().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_hapdef-repro"))
        .arg("repro")
        .arg(scene)
        .args(["--profile", "quick", "--singles", "100", "--multis", "50"])
        .args(["--steps", "3", "--other-steps", "20", "--seed", "7"])
        .args(["--output-modes", "16", "--output-scale", "one"])
        .args(["--threads", threads, "--results"])
        .arg(out.path())
        .env("RAYON_NUM_THREADS", threads)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut found = BTreeMap::new();
    collect(&out.path().join("cache"), &out.path().join("cache"), &mut found);
    let report = fs::read(out.path().join("shin/report/report.json")).unwrap();
    let report: Value = serde_json::from_slice(&report).unwrap();
    assert!(report["tables"].as_array().unwrap().len() >= 8, "too few tables in the report");
    let mut metrics = report["metrics"].as_array().unwrap().iter();
    let wall = metrics.find(|m| m["name"] == "repro.wall_s").unwrap();
    assert!(wall["value"].as_f64().is_some(), "the cache was empty: {wall}");
    for part in ["tables", "claims"] {
        found.insert(part.into(), report[part].to_string().into_bytes());
    }
    found
}

/// Every dataset, table and net below `folder`.
fn collect(root: &Path, folder: &Path, found: &mut BTreeMap<PathBuf, Vec<u8>>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(root, &path, found);
        } else if path.extension().is_some_and(|e| e == "safetensors") {
            found.insert(path.strip_prefix(root).unwrap().to_path_buf(), fs::read(&path).unwrap());
        }
    }
}

#[test]
fn one_seed_one_result_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let scene = &scene(folder.path());
    let [one, two] = thread::scope(|scope| {
        let [one, two] = ["1", "2"].map(|threads| scope.spawn(move || results(scene, threads)));
        [one, two].map(|run| run.join().unwrap())
    });
    assert!(one.len() >= 16, "found {:?}", one.keys());
    assert!(one.keys().eq(two.keys()), "{:?} against {:?}", one.keys(), two.keys());
    for (name, bytes) in &one {
        assert!(*bytes == two[name], "{} differs", name.display());
    }
}
