//! A picture of a page, as PNG or WebP, by a headless Chromium.
//!
//! URL may be the path of a file. SCRIPT runs in the page before SECONDS pass. Without FILE it is enough that
//! a live page drew a contact, with colours, or that its program has ended.
//!
//! `cargo run --release --example view_shot URL [FILE [WIDTHxHEIGHT [dark|light [SECONDS [SCRIPT]]]]]`

#![expect(clippy::print_stdout, reason = "says what the script gives")]

#[path = "../tests/it/support/chrome.rs"]
#[expect(dead_code, reason = "the browser tests use the rest")]
mod chrome;

use std::path::Path;
use std::time::Duration;

use chrome::{Chrome, Fault};

/// Longest that a limb may take to be solved before there are readings.
const PATIENCE: Duration = Duration::from_secs(400);
/// A live page has drawn readings, any other is loaded and leads nowhere else.
const IS_DRAWN: &str = "location.href !== 'about:blank' && document.readyState === 'complete' \
    && !document.querySelector('meta[http-equiv=refresh]') \
    && (!document.getElementById('limb') || globalThis.hapdefView?.drawn > 0)";
/// A live page has drawn a contact on a coloured limb, or nothing will come any more.
const IS_TOUCHED: &str = "!document.getElementById('limb') \
    || document.getElementById('link').dataset.state === 'away' \
    || (hapdefView.arrows.length > 0 && hapdefView.coloured > 0)";

fn main() -> Result<(), Fault> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [url, rest @ ..] = args.as_slice() else {
        return Err("expected URL [FILE [WIDTHxHEIGHT [dark|light [SECONDS [SCRIPT]]]]]".into());
    };
    let (file, rest) = rest.split_first().map_or((None, rest), |(file, rest)| (Some(file), rest));
    let size = rest.first().map_or("1440x900", String::as_str);
    let (width, height) = size.split_once('x').ok_or("expected WIDTHxHEIGHT")?;
    let is_dark = rest.get(1).is_none_or(|scheme| scheme == "dark");
    let seconds: f64 = rest.get(2).map_or(Ok(6.0), |text| text.parse())?;
    let program = chrome::find().ok_or("no Chromium: install it or name it in HAPDEF_CHROMIUM")?;
    let mut chrome = Chrome::start(&program, (width.parse()?, height.parse()?), is_dark)?;
    if Path::new(url).exists() {
        let path = Path::new(url).canonicalize()?;
        chrome.open(&format!("file://{}", path.display()))?;
    } else {
        chrome.open(url)?;
    }
    chrome.wait_long_for(IS_DRAWN, PATIENCE)?;
    let Some(file) = file else {
        return chrome.wait_long_for(IS_TOUCHED, PATIENCE);
    };
    if let Some(script) = rest.get(3) {
        println!("{}", chrome.eval(script)?);
    }
    std::thread::sleep(Duration::from_secs_f64(seconds));
    let format = if file.ends_with(".webp") { "webp" } else { "png" };
    std::fs::write(file, chrome.picture(format)?)?;
    Ok(())
}
