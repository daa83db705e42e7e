//! A simulated device, and a pty to speak through.

#![allow(dead_code, reason = "each test uses its part")]

pub mod damage;
pub mod recorded;

use std::os::fd::OwnedFd;
use std::time::{Duration, Instant};

use hapdef_daq::hdp1::{Command, Decoder, Encoder, Event, FrameFlags, Hello, Pong, SampleFormat};
use hapdef_daq::{Message, Receiver};

/// A device that sends samples anyone can compute from their number.
pub struct Device {
    pub hello: Hello,
    pub encoder: Encoder,
    decoder: Decoder,
    is_first: bool,
}

impl Device {
    pub fn new(n_channels: usize, format: SampleFormat) -> Self {
        Self {
            hello: Hello::plain(n_channels, format, 1000),
            encoder: Encoder::new(),
            decoder: Decoder::new(),
            is_first: true,
        }
    }

    /// The same device after a reset.
    pub fn reset(&mut self) {
        self.hello.boot_id += 1;
        self.encoder = Encoder::new();
        self.is_first = true;
    }

    pub fn say_hello(&mut self, out: &mut Vec<u8>) {
        out.push(0);
        self.encoder.hello(&self.hello, self.t_us(), out).unwrap();
    }

    /// The next packet; HELLO before every thousandth.
    pub fn tick(&mut self, out: &mut Vec<u8>) {
        let seq = self.encoder.seq();
        if seq.is_multiple_of(1000) {
            self.say_hello(out);
        }
        let first = std::mem::replace(&mut self.is_first, false);
        let flags = FrameFlags::from_bits(if first { 8 } else { 0 });
        let samples: Vec<i32> = samples(seq, self.hello.channels.len()).collect();
        let t_us = self.t_us();
        self.encoder.data(&self.hello, t_us, flags, &samples, out).unwrap();
    }

    /// Answers what the host says.
    pub fn answer(&mut self, bytes: &[u8], out: &mut Vec<u8>) {
        let mut commands = Vec::new();
        self.decoder.push(bytes, &mut |event| {
            if let Event::Command(command) = event {
                commands.push(command);
            }
        });
        let t_us = self.t_us();
        for command in commands {
            match command {
                Command::GetHello => self.say_hello(out),
                Command::Ping { host_ns } => {
                    let pong = Pong { host_ns, t_rx_us: t_us, t_us };
                    self.encoder.pong(pong, out);
                }
                _ => {}
            }
        }
    }

    fn t_us(&self) -> u64 {
        u64::from(self.encoder.seq()) * 1000
    }
}

/// Samples of packet `seq`.
pub fn samples(seq: u32, n: usize) -> impl Iterator<Item = i32> {
    (0..n as u32).map(move |i| {
        let mixed = (seq ^ i.wrapping_mul(0x9e37_79b9)).wrapping_mul(0x85eb_ca6b);
        i32::from((mixed >> 16) as u16 as i16)
    })
}

/// True if a frame has the samples of its number.
pub fn is_right(frame: &hapdef_daq::Frame) -> bool {
    let n = frame.bits().len();
    frame.bits().iter().copied().eq(samples(frame.seq, n))
}

/// The device's end of a pty and the path of the host's end.
pub fn pty() -> (OwnedFd, String) {
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
    grantpt(&master).unwrap();
    unlockpt(&master).unwrap();
    let name = ptsname(&master, Vec::new()).unwrap();
    rustix::io::ioctl_fionbio(&master, true).unwrap();
    (master, name.into_string().unwrap())
}

/// Waits for a message that `wanted` takes.
#[track_caller]
pub fn wait_for<T>(
    receiver: &mut Receiver,
    timeout: Duration,
    mut wanted: impl FnMut(&Message) -> Option<T>,
) -> T {
    let deadline = Instant::now() + timeout;
    loop {
        let left = deadline.saturating_duration_since(Instant::now());
        assert!(!left.is_zero(), "nothing of that kind within {timeout:?}");
        if let Some(message) = receiver.recv(left)
            && let Some(found) = wanted(&message)
        {
            return found;
        }
    }
}
