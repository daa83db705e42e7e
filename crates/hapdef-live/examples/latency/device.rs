//! A device of 64 channels on a pseudo-terminal or by TCP, the first of them the gauges of a bundle.

use std::net::TcpListener;
use std::os::fd::OwnedFd;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use hapdef_daq::clock::{HostClock, SystemClock};
use hapdef_daq::hdp1::{Channel, Encoder, FrameFlags, Hello, SampleFormat};
use hapdef_live::Bundle;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const N_CHANNELS: usize = 64;

/// µε per count.
const SCALE: f32 = 1.0 / 64.0;

/// Frames of a press: it comes in 40 ms, stays, and goes after 600 ms; nothing for 400 ms.
const PERIOD: usize = 1000;
const RISE: usize = 40;
const HOLD: usize = 600;

/// Presses before they repeat.
const N_PRESSES: usize = 16;

/// What the device keeps when the port does not take it.
const DEVICE_QUEUE: usize = 32 << 10;

/// When the device sent its last packets, ns on the host's clock, by their number.
pub static SENT_NS: [AtomicU64; 4096] = [const { AtomicU64::new(0) }; 4096];

/// What it says of itself.
pub fn hello(bundle: &Bundle) -> Hello {
    let mut hello = Hello::plain(N_CHANNELS, SampleFormat::I32, 1000);
    for (i, channel) in hello.channels.iter_mut().enumerate() {
        let name = bundle.info.gauges.get(i).map(|gauge| gauge.name.clone());
        let name = name.unwrap_or_else(|| format!("x{i}"));
        *channel = Channel::quarter_bridge(&name, SCALE);
    }
    hello.seal();
    hello
}

/// Counts of every channel, frame by frame: one and two presses at a time on the bundle's own map,
/// with its noise.
pub fn readings(bundle: &Bundle, seed: u64) -> Vec<Vec<i32>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let map = bundle.map();
    let points: Vec<_> = bundle.skin().node_points().into_iter().flatten().collect();
    let mut frames = Vec::with_capacity(N_PRESSES * PERIOD);
    for press in 0..N_PRESSES {
        let contacts: Vec<(Vec<f64>, f64)> = (0..1 + press % 2)
            .map(|_| {
                let point = points[rng.random_range(0..points.len())];
                (map.normal(&point), rng.random_range(5.0..25.0))
            })
            .collect();
        for index in 0..PERIOD {
            let start = PERIOD - HOLD;
            let share = (index.saturating_sub(start) as f64 / RISE as f64).min(1.0);
            let count = |channel: usize| {
                let noise: f64 = StandardNormal.sample(&mut rng);
                let pressed = contacts
                    .iter()
                    .map(|(g, force_n)| g.get(channel).map_or(0.0, |g| g * force_n * share));
                let value = pressed.sum::<f64>() + bundle.info.settings.noise_ue * noise;
                (value / f64::from(SCALE)).round() as i32
            };
            frames.push((0..N_CHANNELS).map(count).collect());
        }
    }
    frames
}

/// Between the device and its host.
pub struct Wire {
    /// What the host opens.
    pub address: String,
    /// What gives the device's end of it, as soon as there is a host.
    pub end: Box<dyn FnOnce() -> OwnedFd + Send>,
}

/// A connection on this machine: what is written is there at once.
pub fn tcp() -> Wire {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let end = Box::new(move || {
        let (host, _) = listener.accept().unwrap();
        host.set_nonblocking(true).unwrap();
        host.set_nodelay(true).unwrap();
        host.into()
    });
    Wire { address, end }
}

/// A pseudo-terminal: what is written is handed on by a thread of the kernel, as with every serial port.
pub fn pty() -> Wire {
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
    grantpt(&master).unwrap();
    unlockpt(&master).unwrap();
    let name = ptsname(&master, Vec::new()).unwrap();
    rustix::io::ioctl_fionbio(&master, true).unwrap();
    Wire { address: name.into_string().unwrap(), end: Box::new(move || master) }
}

/// A packet every millisecond, from when the host has opened the port and said something until it
/// is stopped. A board is never kept from running: when this thread was, it does not make up for it
/// by a burst.
pub fn play(master: &OwnedFd, hello: &Hello, frames: &[Vec<i32>], stop: &AtomicBool) {
    let (mut encoder, mut queue, mut packet) = (Encoder::new(), Vec::new(), Vec::new());
    let mut asked = [0; 256];
    let is_asked = |asked: &mut [u8]| rustix::io::read(master, asked).is_ok_and(|n| n > 0);
    while !is_asked(&mut asked) && !stop.load(Ordering::Acquire) {
        std::thread::sleep(Duration::from_millis(1));
    }
    let start = Instant::now();
    let mut due = start;
    for seq in 0_usize.. {
        if stop.load(Ordering::Acquire) {
            break;
        }
        packet.clear();
        let t_us = start.elapsed().as_micros() as u64;
        if seq % 1000 == 0 || is_asked(&mut asked) {
            packet.push(0);
            encoder.hello(hello, t_us, &mut packet).unwrap();
        }
        let (flags, counts) = (FrameFlags::default(), &frames[seq % frames.len()]);
        SENT_NS[seq % SENT_NS.len()].store(SystemClock.now_ns(), Ordering::Relaxed);
        encoder.data(hello, t_us, flags, counts, &mut packet).unwrap();
        if queue.len() + packet.len() <= DEVICE_QUEUE {
            queue.extend(&packet);
        }
        if let Ok(n) = rustix::io::write(master, &queue) {
            queue.drain(..n);
        }
        due += Duration::from_millis(1);
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
        let late = due.elapsed();
        if late > Duration::from_millis(1) {
            due += late;
        }
    }
}
