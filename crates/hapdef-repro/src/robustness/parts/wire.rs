//! The decoder on damaged streams, numbers at their ends, and what no device sends.

use hapdef_daq::faults::{Fault, Injector};
use hapdef_daq::hdp1::{Decoder, Encoder, Event, FrameFlags, Hello, MAX_CHANNELS, SampleFormat};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::error::ReproError;
use crate::robustness::table::Trials;

/// Packets of a stream, and channels of each.
const N_PACKETS: u32 = 20_000;
const N_CHANNELS: usize = 10;

/// What came of a stream.
#[derive(Default)]
struct Heard {
    n_right: u64,
    n_wrong: u64,
    n_lost: u64,
    /// Packets from the first delivered one to the last.
    n_seen: u64,
}

pub(super) fn add(rows: &mut Trials<u64>) {
    let damages = [
        ("1 bit in 10,000 flips", Fault::BitFlips { rate: 1e-4 }),
        ("1 bit in 100 flips", Fault::BitFlips { rate: 1e-2 }),
        ("1 byte in 1,000 vanishes", Fault::DroppedBytes { rate: 1e-3 }),
        ("1 byte in 1,000 comes twice", Fault::DuplicatedBytes { rate: 1e-3 }),
        ("bursts of 64 random bytes", Fault::Bursts { rate: 1e-4, len: 64 }),
        ("holes of 5,000 bytes", Fault::Holes { rate: 1e-5, len: 5000 }),
    ];
    for (extreme, fault) in damages {
        rows.accurate(extreme, ("wrong frames", 0.0), move |seed| {
            Ok(through(fault, 64, 0, *seed)?.n_wrong as f64)
        });
        let unaccounted = ("frames up to the last seen that are in no count", 0.0);
        rows.accurate(extreme, unaccounted, move |seed| {
            let heard = through(fault, 64, 0, *seed)?;
            let n_counted = heard.n_right + heard.n_wrong + heard.n_lost;
            Ok(heard.n_seen.abs_diff(n_counted) as f64)
        });
    }
    let none = Fault::BitFlips { rate: 0.0 };
    for (extreme, piece, first) in [
        ("bytes come one at a time", 1, 0),
        ("bytes come 1 MB at a time", 1 << 20, 0),
        ("numbers pass 2³²", 64, u32::MAX - N_PACKETS / 2),
    ] {
        rows.accurate(extreme, ("frames missing or wrong", 0.0), move |seed| {
            let heard = through(none, piece, first, *seed)?;
            Ok((u64::from(N_PACKETS) - heard.n_right + heard.n_wrong + heard.n_lost) as f64)
        });
    }
    rows.accurate("10 MB of random bytes", ("frames", 0.0), |seed| noise(*seed));
    let extreme = "as many channels as may be, samples at the ends of 32 bits";
    rows.accurate(extreme, ("samples that differ", 0.0), |_| ends());
}

/// The samples of packet `seq`.
fn sample(seq: u32, channel: usize) -> i32 {
    (seq.wrapping_mul(0x9e37_79b9) ^ (channel as u32).wrapping_mul(0x85eb_ca6b)).cast_signed()
}

/// A stream from number `first` on, damaged, in pieces of `piece` bytes.
fn through(fault: Fault, piece: usize, first: u32, seed: u64) -> Result<Heard, ReproError> {
    let hello = Hello::plain(N_CHANNELS, SampleFormat::I32, 1000);
    let (mut encoder, mut injector) = (Encoder::new(), Injector::new(fault, seed.wrapping_add(7)));
    let mut stream = vec![0];
    encoder.hello(&hello, 0, &mut stream)?;
    encoder.set_seq(first);
    for i in 0..N_PACKETS {
        let seq = first.wrapping_add(i);
        let mut packet = Vec::new();
        if i % 1000 == 999 {
            encoder.hello(&hello, u64::from(i) * 1000, &mut packet)?;
        }
        let samples: Vec<i32> = (0..N_CHANNELS).map(|c| sample(seq, c)).collect();
        let flags = FrameFlags::from_bits(0);
        encoder.data(&hello, u64::from(i) * 1000, flags, &samples, &mut packet)?;
        injector.pass(&packet, &mut stream);
    }
    let (mut decoder, mut heard) = (Decoder::new(), Heard::default());
    let mut first_seen = None;
    for bytes in stream.chunks(piece) {
        decoder.push(bytes, &mut |event| {
            if let Event::Data(data) = event {
                let seq = data.header.seq;
                let is_right = data.bits(0).enumerate().all(|(c, bits)| bits == sample(seq, c));
                *if is_right { &mut heard.n_right } else { &mut heard.n_wrong } += 1;
                let from = *first_seen.get_or_insert(seq);
                heard.n_seen = u64::from(seq.wrapping_sub(from)) + 1;
            }
        });
    }
    heard.n_lost = decoder.losses().n_lost;
    Ok(heard)
}

fn noise(seed: u64) -> Result<f64, ReproError> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed.wrapping_add(3));
    let mut bytes = vec![0; 10_000_000];
    rng.fill_bytes(&mut bytes);
    let mut n_frames = 0;
    Decoder::new().push(&bytes, &mut |event| {
        n_frames += u32::from(!matches!(event, Event::Rejected(_)));
    });
    Ok(f64::from(n_frames))
}

fn ends() -> Result<f64, ReproError> {
    let hello = Hello::plain(MAX_CHANNELS, SampleFormat::I32, 1000);
    let turns = [i32::MIN, i32::MAX, -1, 0, 1];
    let samples: Vec<i32> = turns.into_iter().cycle().take(MAX_CHANNELS).collect();
    let (mut encoder, mut stream) = (Encoder::new(), vec![0]);
    encoder.hello(&hello, 0, &mut stream)?;
    let flags = FrameFlags::from_bits(0);
    encoder.data(&hello, 1000, flags, &samples, &mut stream)?;
    let mut n_same = 0;
    Decoder::new().push(&stream, &mut |event| {
        if let Event::Data(data) = event {
            n_same += data.bits(0).zip(&samples).filter(|(a, b)| a == *b).count();
        }
    });
    Ok((MAX_CHANNELS - n_same) as f64)
}
