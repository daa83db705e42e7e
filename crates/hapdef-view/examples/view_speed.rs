//! How long the page's own script works for a picture, and how many it draws in a second, in a headless
//! Chromium.
//!
//! `cargo xtask bench view` starts the program, runs this on its page and keeps the figures.

#![expect(clippy::print_stdout, reason = "a measurement that prints")]

#[path = "../tests/it/support/chrome.rs"]
#[expect(dead_code, reason = "the browser tests use the rest")]
mod chrome;

use std::io::stdout;
use std::path::Path;
use std::time::{Duration, Instant};

use chrome::{Chrome, Fault};
use hapdef_report::{MetricContext, MetricLog};

const USAGE: &str = "view_speed URL [--seconds N] [--seed N] [--metrics FILE]";
/// A laptop's window, CSS pixels.
const SIZE: (u32, u32) = (1440, 900);
/// Longest that the limb's deformation may take to be solved.
const PATIENCE: Duration = Duration::from_secs(400);
/// Time for which pictures are not counted yet.
const WARM: Duration = Duration::from_secs(3);
/// Between pictures of a screen of 60 Hz, ms.
const BUDGET_MS: f64 = 16.7;

/// What a while of drawing took.
struct Measured {
    script_ms: f64,
    fps: f64,
}

fn main() -> Result<(), Fault> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let value = |name: &str| words.iter().skip_while(|word| *word != name).nth(1);
    let url = words.first().expect(USAGE);
    let span = Duration::from_secs(value("--seconds").map_or(Ok(10), |v| v.parse())?);
    let seed = value("--seed").map_or(Ok(1), |v| v.parse())?;
    let program = chrome::find().ok_or("no Chromium: install it or name it in HAPDEF_CHROMIUM")?;
    let mut chrome = Chrome::start(&program, SIZE, true)?;
    chrome.open(url)?;
    chrome.wait_long_for("globalThis.hapdefView?.coloured > 0", PATIENCE)?;
    let nodes = chrome.eval("hapdefView.nodes")?;
    let coloured = chrome.eval("hapdefView.coloured")?;
    let renderer = chrome.eval(RENDERER)?;
    println!("{coloured} nodes with a displacement of {nodes} drawn; renderer: {renderer}");
    let plain = measure(&mut chrome, span)?;
    exaggerate(&mut chrome)?;
    let bent = measure(&mut chrome, span)?;
    for (what, found) in [("coloured", &plain), ("bent, too", &bent)] {
        println!(
            "{what}: {:.2} ms of script a picture, {:.1} pictures a second",
            found.script_ms, found.fps
        );
    }
    let is_met = bent.script_ms <= BUDGET_MS;
    let words = if is_met { "met" } else { "not met" };
    println!("script at most {BUDGET_MS} ms a picture, bent: {words}");
    let mut log = MetricLog::new(stdout(), MetricContext::here(seed));
    log.value("view.frame_main_ms", bent.script_ms, "ms")?;
    log.value("view.fps", bent.fps, "1/s")?;
    if let Some(path) = value("--metrics") {
        log.append_to(Path::new(path))?;
    }
    Ok(())
}

/// Who draws.
const RENDERER: &str = "(() => {
    const gl = document.createElement('canvas').getContext('webgl2');
    return gl.getParameter(gl.getExtension('WEBGL_debug_renderer_info').UNMASKED_RENDERER_WEBGL);
})()";

/// The costliest picture: every node moves, every normal is new.
fn exaggerate(chrome: &mut Chrome) -> Result<(), Fault> {
    chrome.eval(
        "document.getElementById('exaggerate').value = 0.5;
         document.getElementById('exaggerate').oninput()",
    )?;
    Ok(())
}

fn measure(chrome: &mut Chrome, span: Duration) -> Result<Measured, Fault> {
    std::thread::sleep(WARM);
    let mut look = || -> Result<(f64, f64, Instant), Fault> {
        let counts = chrome.eval("[hapdefView.workMs, hapdefView.drawn]")?;
        let (work_ms, drawn) = serde_json::from_value(counts)?;
        Ok((work_ms, drawn, Instant::now()))
    };
    let (work_ms, drawn, start) = look()?;
    std::thread::sleep(span);
    let (work_end_ms, drawn_end, end) = look()?;
    let n = drawn_end - drawn;
    if n < 1.0 {
        return Err("no picture was drawn".into());
    }
    Ok(Measured {
        script_ms: (work_end_ms - work_ms) / n,
        fps: n / end.duration_since(start).as_secs_f64(),
    })
}
