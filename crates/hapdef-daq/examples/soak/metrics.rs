//! Figures as METRIC lines and in metrics.json.

use std::fs::File;
use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};

/// Prints each figure and, with a path, adds it to the array in that file.
pub fn report(figures: &[(&str, f64, &str)], seed: u64, path: Option<&Path>) {
    for (name, value, unit) in figures {
        println!("METRIC:{name}:{value}:{unit}");
    }
    let Some(path) = path else { return };
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).expect("a folder for metrics.json");
    }
    let held = File::create(path.with_extension("lock")).expect("a lock beside metrics.json");
    held.lock().expect("metrics.json is another's for a moment only");
    let mut all: Vec<Value> = match std::fs::read(path) {
        Ok(bytes) => serde_json::from_slice(&bytes).expect("metrics.json is an array"),
        Err(_) => Vec::new(),
    };
    let (commit, time) = (
        output("git", &["rev-parse", "--short", "HEAD"]),
        output("date", &["-u", "+%Y-%m-%dT%H:%M:%SZ"]),
    );
    for (name, value, unit) in figures {
        all.push(json!({
            "name": name, "value": value, "unit": unit,
            "commit": commit, "machine": machine(), "seed": seed, "time": time,
        }));
    }
    let whole = path.with_extension("json.partial");
    let text = serde_json::to_vec_pretty(&all).expect("figures are JSON");
    std::fs::write(&whole, text).expect("room for metrics.json");
    std::fs::rename(&whole, path).expect("metrics.json can be replaced");
}

fn machine() -> String {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("model name"));
    let name = line.and_then(|line| line.split_once(':'));
    format!("{}, {cores} cores", name.map_or("unknown processor", |(_, n)| n.trim()))
}

fn output(program: &str, words: &[&str]) -> String {
    let output = Command::new(program).args(words).output();
    let text = output.map(|o| String::from_utf8_lossy(&o.stdout).trim().to_owned());
    text.ok().filter(|t| !t.is_empty()).unwrap_or_else(|| "unknown".to_owned())
}
