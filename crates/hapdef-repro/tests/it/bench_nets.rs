//! `hapdef-repro bench-nets` without Python: every metric is printed, measured or skipped.

use std::process::Command;

#[test]
fn every_metric_is_there_without_python() {
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_hapdef-repro"))
        .args(["bench-nets", "--skip-trained", "--rounds", "1", "--results"])
        .arg(folder.path())
        .args(["--python", "/no/such/python"])
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{text}");
    for (name, is_skipped) in [
        ("nets.infer_f32_vs_ort", true),
        ("nets.infer_int8_vs_ort", true),
        ("nets.infer_int8_p99_us", false),
        ("nets.infer_floor_ratio", false),
        ("nets.reduced_p50_us", true),
        ("nets.reduced_error_ratio", true),
    ] {
        let start = format!("METRIC:{name}:");
        let line = text.lines().find_map(|line| line.strip_prefix(&start));
        let line = line.unwrap_or_else(|| panic!("no {name} in {text}"));
        assert_eq!(line.starts_with("skipped:"), is_skipped, "{name}: {line}");
    }
    let json = std::fs::read(folder.path().join("bench-nets-inference.json")).unwrap();
    let rows: serde_json::Value = serde_json::from_slice(&json).unwrap();
    let of = |path: &str| {
        let rows = rows.as_array().unwrap();
        let row = rows.iter().find(|row| row["path"] == path).unwrap();
        row["relative_error"].as_f64().unwrap()
    };
    assert!(of("f32") < 1e-5, "{}", of("f32"));
    assert!(of("int8") < 5e-2);
}
