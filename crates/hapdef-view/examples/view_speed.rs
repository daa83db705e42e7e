//! How long the page's main thread works for a picture, and how many it draws in a second, in a headless
//! Chromium.
//!
//! `cargo xtask bench view` starts the program, runs this on its page and keeps the figures.

#![expect(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a measurement that prints, and ends where something is not as it has to be"
)]

#[path = "../tests/support/chrome.rs"]
#[expect(dead_code, reason = "the browser tests use the rest")]
mod chrome;
#[path = "../../hapdef-daq/examples/soak/metrics.rs"]
mod metrics;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use chrome::{Chrome, Fault};

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
    main_ms: f64,
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
            "{what}: main thread {:.2} ms a picture, {:.1} pictures a second",
            found.main_ms, found.fps
        );
    }
    let is_met = bent.main_ms <= BUDGET_MS;
    let words = if is_met { "met" } else { "not met" };
    println!("main thread at most {BUDGET_MS} ms a picture, bent: {words}");
    let figures = [
        ("view.frame_main_ms", bent.main_ms, "ms"),
        ("view.fps", bent.fps, "1/s"),
    ];
    let metrics = value("--metrics").map(PathBuf::from);
    metrics::report(&figures, seed, metrics.as_deref());
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
        let drawn = chrome.eval("hapdefView.drawn")?;
        let drawn = drawn.as_f64().ok_or("no count of pictures")?;
        Ok((chrome.busy_s()?, drawn, Instant::now()))
    };
    let (busy_s, drawn, start) = look()?;
    std::thread::sleep(span);
    let (busy_end_s, drawn_end, end) = look()?;
    let n = drawn_end - drawn;
    if n < 1.0 {
        return Err("no picture was drawn".into());
    }
    Ok(Measured {
        main_ms: 1e3 * (busy_end_s - busy_s) / n,
        fps: n / end.duration_since(start).as_secs_f64(),
    })
}
