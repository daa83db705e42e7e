//! A moving picture of a live page as animated WebP, by a headless Chromium, as long as it took.
//!
//! SCRIPT runs in the page before the first still.
//!
//! `cargo run --release --example view_film URL FILE WIDTHxHEIGHT SECONDS [SCRIPT]`

#![expect(clippy::print_stdout, reason = "says what the script gives")]

#[path = "../tests/it/support/chrome.rs"]
#[expect(dead_code, reason = "the browser tests use the rest")]
mod chrome;
#[path = "../tests/it/support/film.rs"]
mod film;

use std::time::{Duration, Instant};

use chrome::{Chrome, Fault};
use film::{Still, film};

/// Longest that a limb may take to be solved before it is drawn.
const PATIENCE: Duration = Duration::from_secs(400);
/// Between stills; more where Chromium takes longer for one.
const STEP: Duration = Duration::from_millis(125);

fn main() -> Result<(), Fault> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [url, file, size, seconds, rest @ ..] = args.as_slice() else {
        return Err("expected URL FILE WIDTHxHEIGHT SECONDS [SCRIPT]".into());
    };
    let (width, height) = size.split_once('x').ok_or("expected WIDTHxHEIGHT")?;
    let length = Duration::from_secs_f64(seconds.parse()?);
    let program = chrome::find().ok_or("no Chromium: install it or name it in HAPDEF_CHROMIUM")?;
    let mut chrome = Chrome::start(&program, (width.parse()?, height.parse()?), true)?;
    chrome.open(url)?;
    chrome.wait_long_for("globalThis.hapdefView?.drawn > 0", PATIENCE)?;
    if let Some(script) = rest.first() {
        println!("{}", chrome.eval(script)?);
    }
    std::fs::write(file, film(&stills(&mut chrome, length)?)?)?;
    Ok(())
}

fn stills(chrome: &mut Chrome, length: Duration) -> Result<Vec<Still>, Fault> {
    let start = Instant::now();
    let mut stills = Vec::new();
    while start.elapsed() < length {
        let began = Instant::now();
        let webp = chrome.picture("webp")?;
        std::thread::sleep(STEP.saturating_sub(began.elapsed()));
        stills.push(Still { webp, for_ms: u32::try_from(began.elapsed().as_millis())? });
    }
    Ok(stills)
}
