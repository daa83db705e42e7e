//! Ten lines from a port to frames: here a device in memory takes the port's place.
//!
//! `cargo run --release --example capture`
//!
//! 1. A link carries bytes. For hardware: `SerialLink::new("/dev/serial/by-id/…", …)`.
//! 2. A source makes frames of them, and comes back when the link does.
//! 3. `acquire` reads on a thread of its own; frames wait in a ring.
//!
//! ```text
//! device → link → source → reader's thread → ring → this program
//! ```

#![allow(clippy::print_stdout, reason = "an example shows what it does")]
#![allow(dead_code, reason = "the test runs `capture` alone")]

use std::time::Duration;

use hapdef_daq::hdp1::{Encoder, FrameFlags, Hello, SampleFormat};
use hapdef_daq::source::{MemoryDevice, StreamParams, StreamSource, memory_link};
use hapdef_daq::{AcquireParams, DaqError, Message, acquire};

fn main() -> Result<(), DaqError> {
    let (n_frames, n_lost, mean_ue) = capture()?;
    println!("{n_frames} frames, {n_lost} lost, mean of G1 {mean_ue:.3} µε");
    Ok(())
}

/// Frames received, frames lost on the way, mean of the second gauge, µε.
pub fn capture() -> Result<(u64, u64, f64), DaqError> {
    let (link, device) = memory_link();
    let source = StreamSource::new(link, StreamParams::default());
    let (acquisition, mut receivers) = acquire(source, AcquireParams::default())?;
    while !device.is_open() {
        std::thread::sleep(Duration::from_millis(1));
    }
    play(&device)?;

    let (mut hello, mut strain_ue, mut sum) = (None, [0.0; 64], 0.0);
    while let Some(message) = receivers[0].recv(Duration::from_secs(1)) {
        match message {
            Message::Hello(new) => hello = Some(new),
            Message::Frame(frame) => {
                if let Some(hello) = &hello {
                    frame.scaled(hello, &mut strain_ue);
                    sum += strain_ue[1];
                }
            }
            _ => {}
        }
    }
    let stats = acquisition.stop().source;
    Ok((stats.n_frames, stats.losses.n_lost, sum / stats.n_frames as f64))
}

/// A second of a device at 1 kHz, of which three packets are lost on the cable.
fn play(device: &MemoryDevice) -> Result<(), DaqError> {
    let mut hello = Hello::plain(10, SampleFormat::I16, 1000);
    hello.channels[1].scale = 0.5;
    hello.seal();
    let mut encoder = Encoder::new();
    let mut bytes = Vec::new();
    encoder.hello(&hello, 0, &mut bytes)?;
    for ms in 0..1000 {
        let start = bytes.len();
        let samples: Vec<i32> = (0..10).map(|gauge| ms * gauge).collect();
        let t_us = u64::from(ms.unsigned_abs()) * 1000;
        encoder.data(&hello, t_us, FrameFlags::default(), &samples, &mut bytes)?;
        if [200, 201, 700].contains(&ms) {
            bytes.truncate(start);
        }
    }
    device.send(&bytes);
    device.end();
    Ok(())
}
