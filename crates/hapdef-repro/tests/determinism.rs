//! One seed gives one result, on one and on two threads: datasets, nets, scores, tables and verdicts.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Runs the whole pipeline with few samples and steps; returns the bytes of what it left, without
/// the records that hold times.
fn results(threads: &str) -> BTreeMap<PathBuf, Vec<u8>> {
    let out = tempfile::tempdir().unwrap();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin/scene.json");
    let output = Command::new(env!("CARGO_BIN_EXE_hapdef-repro"))
        .arg("repro")
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
            "7",
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
    let report = fs::read(out.path().join("shin/report/report.json")).unwrap();
    let report: serde_json::Value = serde_json::from_slice(&report).unwrap();
    assert!(
        report["tables"].as_array().unwrap().len() >= 8,
        "too few tables in the report"
    );
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
            found.insert(
                path.strip_prefix(root).unwrap().to_path_buf(),
                fs::read(&path).unwrap(),
            );
        }
    }
}

#[test]
fn one_seed_one_result_on_any_number_of_threads() {
    let one = results("1");
    let two = results("2");
    assert!(one.len() >= 16, "found {:?}", one.keys());
    assert!(
        one.keys().eq(two.keys()),
        "{:?} against {:?}",
        one.keys(),
        two.keys()
    );
    for (name, bytes) in &one {
        assert!(*bytes == two[name], "{} differs", name.display());
    }
}
