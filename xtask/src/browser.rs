//! Pages in a headless Chromium: the browser itself, the tests that need it, the page's speed.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, anyhow};

use crate::fixtures::DEMO;
use crate::tool::{Running, cargo, release_binary, release_example, results, root, run, shown};

/// Where a Chromium is found, as the tests look for it.
const PLACES: [&str; 3] =
    ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];

/// How to get one by hand.
const ADVICE: &str = "as root: apt-get update && apt-get install -y --no-install-recommends chromium; or \
    name one in HAPDEF_CHROMIUM";

/// `cargo xtask browser`; without a Chromium it says so and does nothing.
pub(crate) fn test() -> Result<()> {
    if wish()? == "skip" {
        return Ok(());
    }
    let mut command = cargo(&["test", "--release", "--test", "it"]);
    command.args(["--", "browser", "--nocapture"]);
    run(command.env("HAPDEF_BROWSER", "require"))
}

/// What the tests are told by `HAPDEF_BROWSER`: that there is a Chromium, which is installed where that
/// is allowed, or that there is none; then it says why. In CI it must be possible to install it.
pub(crate) fn wish() -> Result<&'static str> {
    if std::env::var("HAPDEF_BROWSER").is_ok_and(|wish| wish == "skip") {
        println!("browser tests skipped: HAPDEF_BROWSER=skip");
        return Ok("skip");
    }
    if found().is_some() {
        return Ok("require");
    }
    let installed = match why_not_installed() {
        Some(reason) => Err(anyhow!(reason)),
        None => install(),
    };
    let reason = match installed {
        Ok(()) => return Ok("require"),
        Err(error) if std::env::var("CI").is_ok_and(|ci| ci == "true") => return Err(error),
        Err(error) => format!("{error:#}"),
    };
    println!("browser tests skipped: no Chromium, and {reason}; {ADVICE}");
    Ok("skip")
}

/// A Chromium on this machine.
pub(crate) fn found() -> Option<PathBuf> {
    if let Some(path) = std::env::var_os("HAPDEF_CHROMIUM") {
        return Some(PathBuf::from(path));
    }
    PLACES.map(PathBuf::from).into_iter().find(|path| path.exists())
}

/// Why this command may not install one.
fn why_not_installed() -> Option<&'static str> {
    let says = |program: &str, word: &str| {
        let output = Command::new(program).arg(word).output().ok()?;
        Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    if says("apt-get", "--version").is_none() {
        return Some("there is no apt-get");
    }
    match says("id", "-u").as_deref() {
        Some("0") => None,
        _ => Some("only root installs one"),
    }
}

fn install() -> Result<()> {
    let words: [&[&str]; 2] =
        [&["update"], &["install", "-y", "--no-install-recommends", "chromium"]];
    for words in words {
        let mut command = Command::new("apt-get");
        command.args(words).stdout(Stdio::null());
        run(command.env("DEBIAN_FRONTEND", "noninteractive"))?;
    }
    Ok(())
}

/// A program that opens an address: the desktop's, else one that loads it once in a headless Chromium.
pub(crate) fn opener() -> Result<Option<PathBuf>> {
    let has = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    if cfg!(target_os = "macos") {
        return Ok(Some("open".into()));
    }
    if has("DISPLAY") || has("WAYLAND_DISPLAY") {
        return Ok(in_path("xdg-open"));
    }
    found().map(|_| release_example("view_shot")).transpose()
}

fn in_path(program: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    let places = std::env::split_paths(&path).map(|folder| folder.join(program));
    places.into_iter().find(|place| place.exists())
}

/// `cargo xtask bench view`: the page's speed with the scene's simulated rig.
pub(crate) fn bench(scene: Option<&Path>, seed: u64, rest: &[String]) -> Result<()> {
    if wish()? == "skip" {
        for name in ["frame_main_ms", "fps"] {
            println!("METRIC:view.{name}:skipped:no Chromium");
        }
        return Ok(());
    }
    let speed = release_example("view_speed")?;
    let served = Served::start(scene)?;
    let mut command = Command::new(speed);
    command.arg(&served.url).args(["--seed", &seed.to_string()]);
    command.arg("--metrics").arg(results().join("metrics.json"));
    run(command.args(rest))
}

/// The live page of a scene's simulated rig, while this is there.
pub(crate) struct Served {
    _program: Running,
    pub(crate) url: String,
}

impl Served {
    /// Of the bundled limb without a scene.
    pub(crate) fn start(scene: Option<&Path>) -> Result<Self> {
        let bundled = root().join(DEMO);
        let mut command = Command::new(release_binary("hapdef")?);
        command.arg("live").arg(scene.unwrap_or(&bundled));
        command.args(["--sim", "--view", "--view-port", "0"]);
        command.arg("--results").arg(results());
        command.stdout(Stdio::null()).stderr(Stdio::piped());
        let mut child = command.spawn().with_context(|| format!("starting {}", shown(&command)))?;
        let url = child.stderr.take().and_then(page_address);
        let url = url.with_context(|| format!("{} gave no address", shown(&command)))?;
        Ok(Self { _program: Running(child), url })
    }
}

/// The address that the program says; a thread reads on.
fn page_address(stderr: std::process::ChildStderr) -> Option<String> {
    let mut lines = BufReader::new(stderr).lines().map_while(Result::ok);
    let url = lines.find_map(|line| {
        let url = line.strip_prefix("live page: ").map(str::to_owned);
        if url.is_none() {
            eprintln!("{line}");
        }
        url
    });
    std::thread::spawn(move || lines.for_each(|line| eprintln!("{line}")));
    url
}
