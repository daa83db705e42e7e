//! `hapdef live --view` with a device by TCP: the page says whether it is simulated, and when it is away.

use crate::support::page;

use std::io::{BufRead, BufReader, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use hapdef_daq::hdp1::{Encoder, FrameFlags, Hello, SampleFormat};
use hapdef_inverse::SkinPoint;
use hapdef_live::Bundle;
use page::Program;
use serde_json::{Value, json};

/// µε per count.
const SCALE: f32 = 1.0 / 64.0;
/// Frames before it is pressed: nothing while it tares.
const N_UNTOUCHED: u32 = 1000;
const FORCE_N: f64 = 15.0;

/// A board with gauges that is pressed from its first second on; unplugged when dropped.
struct Board {
    address: SocketAddr,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Board {
    fn start(bundle: &Bundle, uid: [u8; 16]) -> Self {
        let point = SkinPoint::new(bundle.skin(), 700, [0.5, 0.3, 0.2]).unwrap();
        Self::of(bundle.map().normal(&point), uid)
    }

    /// One whose gauges read that many µε for a newton.
    fn of(unit_ue: Vec<f64>, uid: [u8; 16]) -> Self {
        let mut hello = Hello::plain(unit_ue.len(), SampleFormat::I32, 1000);
        hello.uid = uid;
        hello.channels.iter_mut().for_each(|c| c.scale = SCALE);
        hello.seal();
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let thread = std::thread::spawn(move || {
            let (mut host, _) = listener.accept().unwrap();
            drop(listener);
            let mut encoder = Encoder::new();
            for n in 0.. {
                if stopped.load(Ordering::Relaxed)
                    || !speak(&mut host, &mut encoder, &hello, &unit_ue, n)
                {
                    return;
                }
                std::thread::sleep(Duration::from_millis(1));
            }
        });
        Self { address, stop, thread: Some(thread) }
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        // It may still wait for its host.
        drop(TcpStream::connect(self.address));
        self.thread.take().unwrap().join().unwrap();
    }
}

/// Frame number `n`, after a HELLO each half a second; false when the host is gone.
fn speak(
    host: &mut TcpStream,
    encoder: &mut Encoder,
    hello: &Hello,
    unit_ue: &[f64],
    n: u32,
) -> bool {
    let t_us = 1000 * u64::from(n);
    let force_n = FORCE_N * (f64::from(n.saturating_sub(N_UNTOUCHED)) / 40.0).min(1.0);
    let wobble =
        |g: usize| 0.5 * ((12.9 * f64::from(n) + 78.2 * g as f64).sin() * 43_758.5).fract();
    let counts = unit_ue
        .iter()
        .enumerate()
        .map(|(g, unit)| ((unit * force_n + wobble(g)) / f64::from(SCALE)).round() as i32);
    let counts: Vec<i32> = counts.collect();
    let mut bytes = vec![0];
    if n.is_multiple_of(500) {
        encoder.hello(hello, t_us, &mut bytes).unwrap();
    }
    encoder.data(hello, t_us, FrameFlags::default(), &counts, &mut bytes).unwrap();
    host.write_all(&bytes).is_ok()
}

fn bundle(folder: &Path) -> (std::path::PathBuf, Bundle) {
    let path = folder.join("shin.hapdef");
    let made = Command::new(env!("CARGO_BIN_EXE_hapdef"))
        .arg("bundle")
        .arg(page::scene(folder))
        .arg("-o")
        .arg(&path)
        .output()
        .unwrap();
    assert!(made.status.success(), "{made:?}");
    let bundle = Bundle::read(&path).unwrap();
    (path, bundle)
}

#[test]
fn a_device_that_is_away_and_one_that_is_simulated_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let (path, bundle) = bundle(folder.path());
    let rig = Hello::RIG_UID;
    for (uid, is_simulated) in [(rig, true), (*b"a board of steel", false)] {
        let board = Board::start(&bundle, uid);
        let source = format!("tcp:{}", board.address);
        let out = folder.path().to_str().unwrap();
        let words = ["--source", &source, "--tare-s", "0.3", "--view-out", out];
        let program = Program::start(&path, &words, 0);
        let mut early = program.page();
        early.until("it is pressed", |frame| frame.contacts.len() == 1);
        assert_eq!(early.device["fault"], Value::Null);
        assert_eq!(early.device["simulated"], is_simulated);
        drop(board);
        early.until("its contacts are gone", |frame| frame.contacts.is_empty());
        let mut late = program.page();
        let is_named = |fault: &Value| {
            let fault = fault.as_str().unwrap();
            assert!(fault.contains(&source["tcp:".len()..]), "{fault}");
        };
        for page in [&early, &late] {
            assert_eq!(page.device["simulated"], is_simulated);
            is_named(&page.device["fault"]);
        }
        let frame = late.until("no frames come", |frame| frame.rate_hz == 0.0);
        assert!(frame.contacts.is_empty(), "{frame:?}");
        late.say(&json!({"cmd": "snapshot"}));
        let kept = late.hear("Kept in ");
        let text = std::fs::read_to_string(kept.strip_prefix("Kept in ").unwrap()).unwrap();
        let kept: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(kept["simulated"], is_simulated);
        is_named(&kept["device_fault"]);
    }
}

#[test]
fn another_number_of_channels_ends_it_at_once_with_both_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let (path, _) = bundle(folder.path());
    // Of eleven, ten that are called like the gauges would be taken.
    for n_channels in [7, 9] {
        let board = Board::of(vec![1.0; n_channels], *b"a board of steel");
        let source = format!("tcp:{}", board.address);
        let start = std::time::Instant::now();
        let ended = Command::new(env!("CARGO_BIN_EXE_hapdef"))
            .args(["live", path.to_str().unwrap(), "--source", &source, "--seconds", "60"])
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(2), "{said}");
        let both = format!("expected 10 gauges, the device has {n_channels} bridges");
        assert!(said.contains(&both), "{said}");
        assert!(start.elapsed() < Duration::from_secs(10), "{:?}", start.elapsed());
    }
}

/// Locked is what is touched: it was a gigabyte that the allocator had in store.
#[cfg(target_os = "linux")]
#[test]
fn real_time_takes_at_most_100_mb_more() {
    let folder = tempfile::tempdir().unwrap();
    let (path, bundle) = bundle(folder.path());
    let most_mb = |words: &[&str]| {
        let board = Board::start(&bundle, *b"a board of steel");
        let source = format!("tcp:{}", board.address);
        let mut live = Command::new(env!("CARGO_BIN_EXE_hapdef"))
            .args(["live", path.to_str().unwrap(), "--source", &source, "--json"])
            .args(words)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let lines = BufReader::new(live.stdout.take().unwrap()).lines();
        // Some of them pressed.
        assert_eq!(lines.take(1500).map(Result::unwrap).count(), 1500);
        let status = std::fs::read_to_string(format!("/proc/{}/status", live.id())).unwrap();
        live.kill().unwrap();
        live.wait().unwrap();
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
        line.trim().trim_end_matches(" kB").parse::<f64>().unwrap() / 1024.0
    };
    let (plain, realtime) = (most_mb(&[]), most_mb(&["--realtime", "50"]));
    assert!(realtime - plain <= 100.0, "{plain} MB, with real time {realtime} MB");
}
