//! One seed gives one result, on one and on two threads.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Runs the whole pipeline with few samples and steps; returns the bytes of what it left, without
/// the records that hold times.
fn results(threads: &str, seed: &str) -> BTreeMap<PathBuf, Vec<u8>> {
    let out = tempfile::tempdir().unwrap();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin/scene.json");
    let output = Command::new(env!("CARGO_BIN_EXE_hapdef"))
        .arg("eval")
        .arg(scene)
        .args([
            "--profile",
            "quick",
            "--singles",
            "200",
            "--multis",
            "50",
            "--steps",
            "3",
        ])
        .args([
            "--other-steps",
            "20",
            "--threads",
            threads,
            "--seed",
            seed,
            "--json",
            "--out",
        ])
        .arg(out.path())
        .env("RAYON_NUM_THREADS", threads)
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let mut found = BTreeMap::new();
    collect(
        &out.path().join("cache"),
        &out.path().join("cache"),
        &mut found,
    );
    let scores = String::from_utf8(output.stdout).unwrap();
    let record: serde_json::Value = serde_json::from_str(scores.lines().last().unwrap()).unwrap();
    found.insert("scores".into(), record["info"].to_string().into_bytes());
    found
}

fn collect(root: &Path, folder: &Path, found: &mut BTreeMap<PathBuf, Vec<u8>>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(root, &path, found);
        } else if path.extension().is_some_and(|e| e == "safetensors") {
            let bytes = blake3::hash(&fs::read(&path).unwrap()).as_bytes().to_vec();
            found.insert(path.strip_prefix(root).unwrap().to_path_buf(), bytes);
        }
    }
}

#[test]
fn one_seed_one_result_on_any_number_of_threads() {
    let one = results("1", "7");
    let two = results("2", "7");
    assert!(one.len() >= 16, "found {:?}", one.keys());
    assert_eq!(
        one.keys().collect::<Vec<_>>(),
        two.keys().collect::<Vec<_>>()
    );
    for (name, bytes) in &one {
        assert_eq!(bytes, &two[name], "{} differs", name.display());
    }
}
