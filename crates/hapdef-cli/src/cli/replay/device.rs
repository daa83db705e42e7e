//! A device that plays a recording.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use hapdef_cli::shown;
use hapdef_contact::printable;
use hapdef_daq::Message;
use hapdef_daq::hdp1::{Command, Decoder, Event};
use hapdef_daq::record::Recording;
use hapdef_daq::source::{FrameSource, ReplaySource, SourceStatus};

use super::packets::Packets;
use super::wire::Wire;

const PAUSE: Duration = Duration::from_micros(500);
/// Time that a host has to read the last bytes.
const LAST_READ: Duration = Duration::from_secs(2);

/// Plays `file` to the host on `wire` as soon as there is one.
pub(super) fn play(file: &Path, speed: f64, wire: impl Wire, stop: &AtomicBool) -> Result<()> {
    println!("{}", wire.name());
    let mut device = Device {
        wire,
        packets: Packets::new(rate_mhz(file)?),
        decoder: Decoder::new(),
        waiting: Vec::new(),
        said_hello: Instant::now(),
        has_host: false,
    };
    while !device.has_host && !stop.load(Ordering::Relaxed) {
        device.answer()?;
        std::thread::sleep(PAUSE);
    }
    let messages = Recording::open(file)?.messages();
    let mut source = ReplaySource::new(&shown(file).to_string(), messages, speed);
    let mut status = SourceStatus::Open;
    while status == SourceStatus::Open && !stop.load(Ordering::Relaxed) {
        let mut fault = None;
        status = source.poll(PAUSE, &mut |message| {
            if let Message::Link(state) = &message {
                eprintln!("{}", printable(&state.to_string()));
            }
            fault = device.take(message, stop).err().or(fault.take());
        });
        if let Some(fault) = fault {
            return Err(fault);
        }
        device.turn(stop)?;
    }
    device.finish(stop);
    let n_frames = source.stats().n_frames;
    eprintln!(
        "played {n_frames} frames; {} packets were incomplete and left out",
        device.packets.n_incomplete()
    );
    Ok(())
}

struct Device<W> {
    wire: W,
    packets: Packets,
    decoder: Decoder,
    /// Bytes that the host has not taken yet.
    waiting: Vec<u8>,
    said_hello: Instant,
    has_host: bool,
}

impl<W: Wire> Device<W> {
    fn take(&mut self, message: Message, stop: &AtomicBool) -> Result<()> {
        self.packets.take(message, &mut self.waiting)?;
        self.turn(stop)
    }

    /// Answers, repeats HELLO every second and sends what waits; it waits for a host that does not
    /// read, so that nothing is lost.
    fn turn(&mut self, stop: &AtomicBool) -> Result<()> {
        loop {
            self.answer()?;
            if self.said_hello.elapsed() >= Duration::from_secs(1) {
                self.said_hello = Instant::now();
                self.packets.say_hello(&mut self.waiting)?;
            }
            self.send();
            if self.waiting.is_empty() || stop.load(Ordering::Relaxed) {
                return Ok(());
            }
            std::thread::sleep(PAUSE);
        }
    }

    fn send(&mut self) {
        let n = self.wire.write(&self.waiting);
        self.waiting.drain(..n);
    }

    fn answer(&mut self) -> Result<()> {
        let bytes = self.wire.read();
        if self.wire.is_new_host() {
            // What was begun for another host must not be ended for this one.
            self.waiting.clear();
        }
        let mut commands = Vec::new();
        self.decoder.push(&bytes, &mut |event| {
            if let Event::Command(command) = event {
                commands.push(command);
            }
        });
        for command in commands {
            self.has_host = true;
            match command {
                Command::GetHello => self.packets.say_hello(&mut self.waiting)?,
                Command::Ping { host_ns } => self.packets.pong(host_ns, &mut self.waiting),
                Command::Start | Command::Stop => {}
            }
        }
        Ok(())
    }

    /// Gives the host time to read what was sent last.
    fn finish(&mut self, stop: &AtomicBool) {
        let start = Instant::now();
        while !self.waiting.is_empty() && start.elapsed() < LAST_READ {
            if stop.load(Ordering::Relaxed) {
                return;
            }
            self.send();
            std::thread::sleep(PAUSE);
        }
        // What the kernel holds is lost for the host when this end closes.
        std::thread::sleep(Duration::from_millis(200));
    }
}

/// Frames per 1000 s, by the recorded times: devices that send lines name no rate.
fn rate_mhz(file: &Path) -> Result<u32> {
    let messages = Recording::open(file)?.with_first_chunk()?.messages();
    let times: Vec<u64> = messages
        .filter_map(|message| match message {
            Message::Frame(frame) => Some(frame.t_host_ns),
            _ => None,
        })
        .take(200)
        .collect();
    let [first, .., last] = times[..] else {
        bail!("{}: has fewer than two readings", shown(file));
    };
    let span_s = last.saturating_sub(first) as f64 * 1e-9;
    let rate_mhz = 1e3 * (times.len() - 1) as f64 / span_s.max(1e-9);
    Ok(rate_mhz.round().clamp(1.0, f64::from(u32::MAX)) as u32)
}
