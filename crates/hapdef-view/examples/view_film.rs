//! A moving picture of a live page as animated WebP, by a headless Chromium: some seconds of what the page has
//! seen, still by still at their own pace, however long Chromium takes for each.
//!
//! SCRIPT runs in the page first; what it gives is waited for.
//!
//! `cargo run --release --example view_film URL FILE WIDTHxHEIGHT SECONDS [SCRIPT]`

#![expect(clippy::print_stdout, reason = "says what the script gives")]

#[path = "../tests/it/support/chrome.rs"]
#[expect(dead_code, reason = "the browser tests use the rest")]
mod chrome;
#[path = "../tests/it/support/film.rs"]
mod film;

use std::time::Duration;

use chrome::{Chrome, Fault};
use film::{Still, film};

/// Longest that a limb may take to be solved before it is drawn.
const PATIENCE: Duration = Duration::from_secs(400);
/// Time that a still shows, ms.
const STEP_MS: u32 = 200;
/// Lets frames of the page be dropped: it keeps what it has seen, which would be forgotten after 30 s.
const CAN_BE_CUT: &str = "globalThis.isCut = false;
    globalThis.WebSocket = class extends WebSocket {
        set onmessage(take) {
            super.onmessage = (event) => { if (!isCut || typeof event.data === 'string') take(event); };
        }
    };";

fn main() -> Result<(), Fault> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [url, file, size, seconds, rest @ ..] = args.as_slice() else {
        return Err("expected URL FILE WIDTHxHEIGHT SECONDS [SCRIPT]".into());
    };
    let (width, height) = size.split_once('x').ok_or("expected WIDTHxHEIGHT")?;
    let program = chrome::find().ok_or("no Chromium: install it or name it in HAPDEF_CHROMIUM")?;
    let mut chrome = Chrome::start(&program, (width.parse()?, height.parse()?), true)?;
    chrome.before_pages(CAN_BE_CUT)?;
    chrome.open(url)?;
    chrome.wait_long_for("globalThis.hapdefView?.drawn > 0", PATIENCE)?;
    if let Some(script) = rest.first() {
        println!("{}", chrome.eval(script)?);
    }
    std::fs::write(file, film(&stills(&mut chrome, seconds.parse()?)?)?)?;
    Ok(())
}

/// What the page has seen in the last `seconds`.
fn stills(chrome: &mut Chrome, seconds: f64) -> Result<Vec<Still>, Fault> {
    chrome.eval("globalThis.isCut = true")?;
    let step_s = 1e-3 * f64::from(STEP_MS);
    let n = (seconds / step_s).ceil() as u32;
    (0..n).rev().map(|i| still(chrome, f64::from(i) * step_s)).collect()
}

/// What the page showed so long ago.
fn still(chrome: &mut Chrome, ago_s: f64) -> Result<Still, Fault> {
    chrome.eval(&format!(
        "new Promise((done) => {{
            const [time, drawn] = [document.getElementById('time'), hapdefView.drawn];
            time.value = {};
            time.dispatchEvent(new Event('input'));
            const look = () => (hapdefView.drawn > drawn ? done(true) : requestAnimationFrame(look));
            look();
        }})",
        -ago_s
    ))?;
    Ok(Still { webp: chrome.picture("webp")?, for_ms: STEP_MS })
}
