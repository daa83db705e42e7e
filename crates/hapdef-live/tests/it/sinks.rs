//! The sinks that come along write what they say.

use crate::support;

use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use hapdef_daq::source::ReplaySource;
use hapdef_live::estimator::SearchPlace;
use hapdef_live::sinks::{CsvSink, JsonServer, JsonSink, TextSink};
use hapdef_live::{Contact, Live, LiveFrame, LiveParams, Phase, Sink};
use nalgebra::{Point3, Vector3};
use serde_json::Value;
use support::world::World;
use support::{N_GAUGES, bundle, messages, pressed};

/// A writer that others look at.
#[derive(Clone, Default)]
struct Shared(Arc<Mutex<Vec<u8>>>);

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl Shared {
    fn text(&self) -> String {
        String::from_utf8(self.0.lock().unwrap().clone()).unwrap()
    }
}

fn frame() -> LiveFrame {
    let mut frame = LiveFrame::new(3);
    frame.seq = 7;
    frame.t_device_us = 1_500_000;
    frame.touch.contacts.push(Contact {
        direction: Some(Vector3::new(0.0, 0.0, -1.0)),
        id: Some(4),
        phase: Some(Phase::Held),
        ..Contact::new(Point3::new(0.01, 0.02, 0.03), 12.5)
    });
    frame
}

/// Every frame of a stream, from the runtime to three files at once.
#[test]
fn a_stream_ends_up_in_text_json_and_table() {
    let world = World::new(N_GAUGES, 400, 5);
    let bundle = bundle(&world);
    let stream = messages(&pressed(&world, 700, 3));
    let [text, json, csv] = [(); 3].map(|()| Shared::default());
    let live = Live::builder(ReplaySource::new("memory", stream.into_iter(), 0.0))
        .bundle(&bundle)
        .params(LiveParams {
            tare_s: 0.1,
            is_recorded: true,
            is_lossless: true,
            ..LiveParams::default()
        })
        .estimator(bundle.tracking(SearchPlace::Here).unwrap())
        .sink(TextSink::lines(text.clone()))
        .sink(JsonSink::new(json.clone()))
        .sink(CsvSink::new(csv.clone()))
        .start()
        .unwrap();
    live.wait().unwrap();
    let lines = text.text();
    assert!(lines.contains("taring, touch nothing") && lines.contains("tared"), "{lines}");
    let (mut n_frames, mut last, mut n_health) = (0, Value::Null, 0);
    for line in json.text().lines() {
        let value: Value = serde_json::from_str(line).unwrap();
        if value.get("event").is_some() {
            n_health += usize::from(value["event"] == "health");
        } else {
            assert_eq!(value["seq"], n_frames);
            n_frames += 1;
            last = value;
        }
    }
    assert!(n_frames == 700 && n_health >= 1, "{n_frames} {n_health}");
    let contact = &last["contacts"][0];
    assert!((contact["force_n"].as_f64().unwrap() - 20.0).abs() < 1.0, "{last}");
    assert!(contact["position_sd_m"].as_f64().unwrap() > 0.0);
    assert_eq!(last["tared_ue"].as_array().unwrap().len(), N_GAUGES);
    let table = csv.text();
    let rows: Vec<Vec<&str>> = table.lines().map(|row| row.split(',').collect()).collect();
    assert_eq!(rows.len(), 701);
    assert!(rows.iter().all(|row| row.len() == rows[0].len()));
    let at = |name: &str| rows[0].iter().position(|n| *n == name).unwrap();
    assert_eq!(rows[700][at("n_contacts")], "1");
    assert_eq!([rows[700][at("phase")], rows[700][at("is_stale")]], ["touched", "0"]);
    let p_value: f64 = rows[700][at("p_value")].parse().unwrap();
    assert_eq!(Some(p_value), last["quality"]["p_value"].as_f64());
    let force: f64 = rows[700][at("force1_n")].parse().unwrap();
    assert_eq!(Some(force), contact["force_n"].as_f64());
}

#[test]
fn the_refreshed_line_is_wiped_before_another_is_said() {
    let out = Shared::default();
    let mut sink = TextSink::refreshed(out.clone());
    sink.frame(&frame()).unwrap();
    assert!(out.text().contains("\r     1.500 s #4 12.50 N at (10.0, 20.0, 30.0) mm"));
    let n = out.text().len();
    sink.event(&hapdef_live::LiveEvent::Tared).unwrap();
    let said = out.text().split_off(n);
    assert!(said.starts_with("\r  ") && said.ends_with("\rtared\n"), "{said:?}");
}

/// Reads lines until one says that lines were left out and one more; every number is there or
/// counted as left out. Returns how many were.
fn read_until_left_out(client: TcpStream) -> u64 {
    let (mut next, mut n_left_out, mut n_all) = (0, 0, 0);
    for line in BufReader::new(client).lines() {
        let value: Value = serde_json::from_str(&line.unwrap()).unwrap();
        if let Some(seq) = value["seq"].as_u64() {
            assert_eq!(seq, next + n_left_out);
            if n_all > 0 {
                break;
            }
            (next, n_left_out) = (seq + 1, 0);
        } else {
            let words = value["text"].as_str().unwrap().to_owned();
            n_left_out = words.split(' ').next().unwrap().parse().unwrap();
            n_all += n_left_out;
        }
    }
    n_all
}

/// A client that doesn't read misses whole lines and hears how many; the other one gets all.
#[test]
fn clients_are_served_each_at_its_own_pace() {
    let mut server = JsonServer::bind("tcp:127.0.0.1:0").unwrap();
    let address = server.address().strip_prefix("tcp:").unwrap().to_owned();
    let [fast, slow] = [(); 2].map(|()| TcpStream::connect(&address).unwrap());
    let n_frames = 40_000;
    let reader = std::thread::spawn(move || {
        let lines = BufReader::new(fast).lines();
        lines.take(n_frames).map(|line| line.unwrap().len()).sum::<usize>()
    });
    let mut frame = frame();
    let start = Instant::now();
    for seq in 0..n_frames as u32 {
        frame.seq = seq;
        server.frame(&frame).unwrap();
        // at the pace of a stream ten times as fast
        let due = Duration::from_micros(100 * u64::from(seq));
        std::thread::sleep(due.saturating_sub(start.elapsed()));
    }
    assert!(reader.join().unwrap() > 300 * n_frames);
    let late = std::thread::spawn(move || read_until_left_out(slow));
    while !late.is_finished() && start.elapsed() < Duration::from_secs(20) {
        frame.seq += 1;
        server.frame(&frame).unwrap();
        std::thread::sleep(Duration::from_micros(100));
    }
    assert!(late.is_finished() && late.join().unwrap() > 0);
}

#[test]
fn a_socket_is_gone_when_its_server_is() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("socket");
    let unix = JsonServer::bind(&format!("unix:{}", path.display())).unwrap();
    assert!(path.exists());
    drop(unix);
    assert!(!path.exists());
    let refused = JsonServer::bind("udp:9").map(|_| ()).unwrap_err().to_string();
    assert!(refused.contains("tcp:HOST:PORT"), "{refused}");
}
