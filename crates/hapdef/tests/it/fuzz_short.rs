//! Every reader on some hundred damaged inputs; `cargo xtask fuzz` takes as long as you like.

#[path = "../../examples/fuzz/driver.rs"]
mod driver;
#[path = "../../examples/fuzz/mutate.rs"]
mod mutate;
#[path = "../../../../fuzz/src/targets.rs"]
mod targets;

use std::path::Path;
use std::process::Command;

use driver::{corpus, fuzz};

/// Memory of all readers together, whatever the damage claims; a few small files are the input.
const MOST_MIB: u64 = 1024;

/// Set in the process of its own in which the readers' memory is measured.
const CHILD: &str = "HAPDEF_CHILD_FUZZES";

#[test]
fn no_reader_panics_or_takes_much_memory() {
    if std::env::var_os(CHILD).is_some() {
        return read_damaged();
    }
    let own_name = "fuzz_short::no_reader_panics_or_takes_much_memory";
    let mut child = Command::new(std::env::current_exe().unwrap());
    child.args(["--exact", own_name, "--nocapture"]).env(CHILD, "1");
    let output = child.output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && text.contains("1 passed"), "{text}");
}

fn read_damaged() {
    let home = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus");
    let failures = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fuzz");
    for target in targets::TARGETS {
        let seeds = corpus(&home.join(target.name));
        let outcome = fuzz(target, &seeds, 1, |n, _| n >= 400, &failures);
        println!("{}: {outcome:?}", target.name);
        assert_eq!(outcome.n_panics, 0, "{}", target.name);
    }
    if let Some(peak) = peak_mib() {
        println!("at most {peak} MiB");
        assert!(peak < MOST_MIB, "{peak} MiB");
    }
}

/// The most memory that the process has held, MiB; none where the system doesn't tell.
fn peak_mib() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib / 1024)
}
