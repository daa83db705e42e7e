//! A device of 64 × i32 at 1 kHz on a pty: acquired, computed with, recorded.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use hapdef_daq::clock::{HostClock, SystemClock};
use hapdef_daq::hdp1::SampleFormat;
use hapdef_daq::record::{RecordParams, Recording, record};
use hapdef_daq::source::{SerialLink, SerialParams, StreamParams, StreamSource};
use hapdef_daq::{AcquireParams, Fanout, Message, Receiver, acquire};

use crate::proc::{rss_mib, thread_cpu};
use crate::support::{Device, is_right, pty};

const N_CHANNELS: usize = 64;
/// Time from one packet to the next while the device makes up for time in which it was not run.
const CATCHING_UP: Duration = Duration::from_micros(500);
/// What the device keeps when the port does not take it, as the firmware does.
const DEVICE_QUEUE: usize = 32 << 10;

/// When the device sent its last packets, ns on the host's clock, by their number.
static SENT_NS: [AtomicU64; 4096] = [const { AtomicU64::new(0) }; 4096];

/// How the stream went.
#[derive(Debug)]
#[allow(dead_code, reason = "it is printed as a whole")]
pub struct Stream {
    pub n_sent: u64,
    pub sent_hz: f64,
    pub n_received: u64,
    pub n_recorded: u64,
    /// Packets lost on the link, dropped by the device or by a queue of the host.
    pub n_lost: u64,
    pub n_wrong: u64,
    pub n_unaccounted: u64,
    /// Of the lost ones, those that did not fit into the device's own queue.
    pub n_dropped_by_device: u64,
    /// Longest time that the device's thread was kept from running, and their sum.
    pub device_held_up: [Duration; 2],
    pub n_missed_by_stalled_viewer: u64,
    pub rss_growth_mib: f64,
    pub reader_cpu_pct: f64,
    pub recorder_cpu_pct: f64,
    pub round_trip_us: u64,
    /// From the device's write to the computing thread, µs: median and 99th percentile.
    pub latency_us: [f64; 2],
}

pub fn run(duration: Duration, realtime_priority: Option<u8>) -> Stream {
    let (master, path) = pty();
    let stop = Arc::new(AtomicBool::new(false));
    let theirs = Arc::clone(&stop);
    let device = std::thread::spawn(move || play(&master, &theirs));
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("soak.mcap");
    let link = SerialLink::new(&path, SerialParams::default());
    let params = AcquireParams { n_receivers: 2, realtime_priority, ..AcquireParams::default() };
    let source = StreamSource::new(link, StreamParams::default());
    let (acquisition, mut receivers) = acquire(source, params).unwrap();
    let recorder = record(receivers.remove(1), &file, RecordParams::default()).unwrap();
    let mut compute = receivers.remove(0);

    // Memory is compared when the rings of 8192 frames have been around once.
    let warm = (duration / 5).max(Duration::from_secs(9)).min(duration);
    let began = Instant::now();
    let mut seen = consume(&mut compute, warm);
    let (rss, reader, writer) =
        (rss_mib(), thread_cpu("hapdef-reader"), thread_cpu("hapdef-record"));
    let start = Instant::now();
    seen.add(&consume(&mut compute, duration - warm));
    let passed = start.elapsed().as_secs_f64();
    let share = |name, before| 100.0 * (thread_cpu(name) - before).as_secs_f64() / passed;
    let (reader_cpu_pct, recorder_cpu_pct) =
        (share("hapdef-reader", reader), share("hapdef-record", writer));
    let rss_growth_mib = rss_mib() - rss;
    stop.store(true, Ordering::Release);
    let sent_s = began.elapsed().as_secs_f64();
    let played = device.join().unwrap();
    let n_sent = played.n_packets;
    seen.add(&consume(&mut compute, Duration::from_millis(300)));
    let stats = acquisition.stop();
    let recorded = recorder.finish().unwrap();
    if let Some(fault) = &stats.realtime_fault {
        println!("no real-time priority: {fault}");
    }
    let source = stats.source;
    let n_lost = source.losses.n_lost + compute.n_dropped() + recorded.n_dropped;
    let (n_read, n_read_wrong) = read_back(&file);
    assert_eq!(n_read, recorded.n_frames);
    Stream {
        n_sent,
        sent_hz: n_sent as f64 / sent_s,
        n_received: seen.n_frames,
        n_recorded: recorded.n_frames,
        n_lost,
        n_wrong: seen.n_wrong + n_read_wrong,
        n_unaccounted: n_sent.abs_diff(seen.n_frames + source.losses.n_lost + compute.n_dropped()),
        n_dropped_by_device: played.n_dropped,
        device_held_up: [played.worst_late, played.all_late],
        n_missed_by_stalled_viewer: seen.n_missed,
        rss_growth_mib,
        reader_cpu_pct,
        recorder_cpu_pct,
        round_trip_us: source.round_trip_ns / 1000,
        latency_us: seen.latency_us(),
    }
}

#[derive(Default)]
struct Seen {
    n_frames: u64,
    n_wrong: u64,
    n_missed: u64,
    /// Packets by their latency in steps of 10 µs; the last counts all that took longer.
    latency: Vec<u64>,
}

impl Seen {
    fn latency_us(&self) -> [f64; 2] {
        let n: u64 = self.latency.iter().sum();
        [0.5, 0.99].map(|share| {
            let mut left = (share * n as f64) as u64;
            let at = self.latency.iter().position(|count| {
                let is_here = *count > left;
                left = left.saturating_sub(*count);
                is_here
            });
            at.map_or(f64::NAN, |at| 10.0 * (at as f64 + 0.5))
        })
    }

    fn add(&mut self, other: &Self) {
        self.n_frames += other.n_frames;
        self.n_wrong += other.n_wrong;
        self.n_missed += other.n_missed;
        self.latency.resize(other.latency.len(), 0);
        for (to, from) in self.latency.iter_mut().zip(&other.latency) {
            *to += from;
        }
    }
}

/// Receives, and passes frames on to a viewer that never looks.
fn consume(receiver: &mut Receiver, duration: Duration) -> Seen {
    let mut fanout = Fanout::new();
    let stalled = fanout.bounded(256);
    let deadline = Instant::now() + duration;
    let mut seen = Seen { latency: vec![0; 2000], ..Seen::default() };
    loop {
        let left = deadline.saturating_duration_since(Instant::now());
        if left.is_zero() {
            break;
        }
        if let Some(Message::Frame(frame)) = receiver.recv(left) {
            let sent_ns = SENT_NS[frame.seq as usize % SENT_NS.len()].load(Ordering::Relaxed);
            let took_us = SystemClock.now_ns().saturating_sub(sent_ns) / 1000;
            let last = seen.latency.len() - 1;
            seen.latency[last.min((took_us / 10) as usize)] += 1;
            seen.n_frames += 1;
            seen.n_wrong += u64::from(!is_right(&frame));
            fanout.publish(frame);
        }
    }
    seen.n_missed = stalled.n_dropped();
    seen
}

/// What the device has done.
#[derive(Clone, Copy, Default)]
struct Played {
    n_packets: u64,
    n_dropped: u64,
    /// Longest time that the device's thread was not run in its turn, and their sum.
    worst_late: Duration,
    all_late: Duration,
}

/// The device: a packet for every millisecond until it is stopped, never blocking. A board is never
/// kept from running; when this thread was, it makes up for it by packets of half a millisecond, not by a
/// burst that no board would send.
fn play(master: &std::os::fd::OwnedFd, stop: &AtomicBool) -> Played {
    let mut device = Device::new(N_CHANNELS, SampleFormat::I32);
    let (mut queue, mut packet, mut asked) = (Vec::new(), Vec::new(), [0; 256]);
    // The host opens the port and asks for a HELLO.
    while !rustix::io::read(master, &mut asked[..]).is_ok_and(|n| n > 0) {
        std::thread::sleep(Duration::from_millis(1));
    }
    let mut played = Played::default();
    let mut due = Instant::now();
    while !stop.load(Ordering::Acquire) {
        packet.clear();
        let slot = &SENT_NS[device.encoder.seq() as usize % SENT_NS.len()];
        slot.store(SystemClock.now_ns(), Ordering::Relaxed);
        device.tick(&mut packet);
        played.n_packets += 1;
        if let Ok(n) = rustix::io::read(master, &mut asked[..]) {
            device.answer(&asked[..n], &mut packet);
        }
        if queue.len() + packet.len() <= DEVICE_QUEUE {
            queue.extend(&packet);
        } else {
            played.n_dropped += 1;
        }
        send(master, &mut queue);
        let sent = Instant::now();
        due += Duration::from_millis(1);
        let next = due.max(sent + CATCHING_UP);
        std::thread::sleep(next.saturating_duration_since(Instant::now()));
        let late = next.elapsed();
        if late > Duration::from_millis(1) {
            played.all_late += late;
            played.worst_late = played.worst_late.max(late);
        }
    }
    while !queue.is_empty() {
        send(master, &mut queue);
        std::thread::sleep(Duration::from_millis(1));
    }
    played
}

fn send(master: &std::os::fd::OwnedFd, queue: &mut Vec<u8>) {
    if let Ok(n) = rustix::io::write(master, queue) {
        queue.drain(..n);
    }
}

fn read_back(file: &std::path::Path) -> (u64, u64) {
    let (mut n, mut n_wrong) = (0, 0);
    for message in Recording::open(file).unwrap().messages() {
        if let Message::Frame(frame) = message {
            n += 1;
            n_wrong += u64::from(!is_right(&frame));
        }
    }
    (n, n_wrong)
}
