//! The page with the whole program in the browser: the module, the folder of static files, their size and their test.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::fixtures::DEMO;
use crate::tool::{cargo, into_results, release_binary, results, root, run, target_dir};
use crate::{browser, metrics};

const TARGET: &str = "wasm32-unknown-unknown";
/// Most that the folder may have, bytes.
const MOST_BYTES: u64 = 5_000_000;
/// Crates of which no frame waits: made small, which takes half as long, too.
const SMALL: [&str; 9] = [
    "gltf",
    "gltf-json",
    "hapdef-daq",
    "hapdef-mesh",
    "hapdef-view",
    "mesh-loader",
    "roxmltree",
    "safetensors",
    "serde_json",
];
/// What the test prints.
const TIMES: [&str; 2] = ["wasm.frame_p50_us", "wasm.frame_p99_us"];

/// Arguments of `wasm`.
#[derive(clap::Args)]
pub(crate) struct WasmArgs {
    /// Another scene than the bundled one.
    scene: Option<PathBuf>,
    /// The folder to write; target/wasm/page if not given.
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Leaves out the test in a browser.
    #[arg(long)]
    untested: bool,
}

/// `cargo xtask wasm`.
pub(crate) fn make(args: &WasmArgs) -> Result<()> {
    let bundled = root().join(DEMO);
    let scene = args.scene.as_deref().unwrap_or(&bundled);
    let own = || target_dir().map(|target| target.join("wasm/page"));
    let out = args.out.clone().map_or_else(own, Ok)?;
    let is_made = make_page(scene, &out)?;
    if is_made && !args.untested { test(&out) } else { Ok(()) }
}

/// A step of CI.
pub(crate) fn check() -> Result<()> {
    make(&WasmArgs { scene: None, out: None, untested: false })
}

/// False where there is no compiler for it, which is said.
fn make_page(scene: &Path, out: &Path) -> Result<bool> {
    let rustc = rustc();
    if let Some(why) = why_not(&rustc) {
        println!("page in the browser skipped: {why}");
        for name in ["wasm.bytes"].into_iter().chain(TIMES) {
            println!("METRIC:{name}:skipped:no rustc for {TARGET}");
        }
        return Ok(false);
    }
    let module = module(&rustc)?;
    let mut command = Command::new(release_binary("hapdef")?);
    command.arg("page").arg(scene).arg("--module").arg(&module).arg("--out").arg(out);
    command.arg("--results").arg(results());
    run(&mut command)?;
    let n_bytes = bytes_below(out)?;
    let log = results().join("metrics.json");
    metrics::report(&[("wasm.bytes", n_bytes as f64, "B")], 0, Some(&log));
    ensure!(
        n_bytes <= MOST_BYTES,
        "{}: {n_bytes} bytes, expected {MOST_BYTES} at most",
        out.display()
    );
    Ok(true)
}

/// The compiler that makes the module: `HAPDEF_WASM_RUSTC`, else the one that made everything else.
fn rustc() -> PathBuf {
    let named = std::env::var_os("HAPDEF_WASM_RUSTC").or_else(|| std::env::var_os("RUSTC"));
    named.map_or_else(|| "rustc".into(), PathBuf::from)
}

/// Why a compiler makes no module.
fn why_not(rustc: &Path) -> Option<String> {
    let words = ["--print", "target-libdir", "--target", TARGET];
    let output = Command::new(rustc).args(words).current_dir(root()).output();
    let has_std = output.is_ok_and(|output| {
        let folder = String::from_utf8_lossy(&output.stdout).trim().to_owned();
        let files = fs::read_dir(folder).into_iter().flatten().flatten();
        files.into_iter().any(|file| file.file_name().to_string_lossy().starts_with("libstd-"))
    });
    (!has_std).then(|| {
        format!(
            "{} has no standard library for {TARGET}: rustup target add {TARGET}, or name a rustc that has it in \
             HAPDEF_WASM_RUSTC",
            rustc.display()
        )
    })
}

/// Builds the module; nothing of it is shared with other builds. It has no vector instructions: those that pulp would
/// take are the relaxed ones, which not every browser has.
fn module(rustc: &Path) -> Result<PathBuf> {
    let folder = target_dir()?.join("wasm");
    let words = ["rustc", "--quiet", "--package", "hapdef-wasm", "--lib", "--release"];
    let mut command = cargo(&words);
    command.args(["--target", TARGET, "--crate-type", "cdylib", "--target-dir"]).arg(&folder);
    for name in SMALL {
        command.args(["--config", &format!("profile.release.package.{name}.opt-level=\"s\"")]);
    }
    command.env("RUSTC", rustc).env("CARGO_PROFILE_RELEASE_PANIC", "abort");
    run(&mut command)?;
    Ok(folder.join(TARGET).join("release/hapdef_wasm.wasm"))
}

/// The folder in a browser beside the same session here; without a Chromium it says so.
fn test(folder: &Path) -> Result<()> {
    let wish = browser::wish()?;
    if wish == "skip" {
        TIMES.iter().for_each(|name| println!("METRIC:{name}:skipped:no Chromium"));
        return Ok(());
    }
    let folder = fs::canonicalize(folder).with_context(|| folder.display().to_string())?;
    // No package is named, as in `browser::test`: where tests were built this builds nothing.
    let mut command = cargo(&["test", "--quiet", "--release", "--test", "it"]);
    command.args(["--", "static_page::", "--nocapture"]);
    into_results(command.env("HAPDEF_BROWSER", wish).env("HAPDEF_PAGE", folder));
    run(&mut command)
}

fn bytes_below(folder: &Path) -> Result<u64> {
    let mut sum = 0;
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let entry = entry?;
        let metadata = entry.metadata()?;
        sum += if metadata.is_dir() { bytes_below(&entry.path())? } else { metadata.len() };
    }
    Ok(sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_compiler_that_is_not_there_makes_no_module_and_the_way_to_one_is_said() {
        let why = why_not(Path::new("no-such-rustc")).expect("a reason");
        assert!(why.contains("rustup target add wasm32-unknown-unknown"), "{why}");
    }

    #[test]
    fn bytes_of_files_below_are_counted() {
        let folder = target_dir().expect("a target").join("wasm-bytes-below");
        fs::create_dir_all(folder.join("in")).expect("a folder");
        fs::write(folder.join("a"), [0; 3]).expect("a file");
        fs::write(folder.join("in/b"), [0; 4]).expect("a file");
        assert_eq!(bytes_below(&folder).expect("a folder"), 7);
        fs::remove_dir_all(&folder).expect("a folder");
    }
}
