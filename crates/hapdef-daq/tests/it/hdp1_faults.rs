//! The fault table's rows for the wire: nothing wrong is delivered, every loss is counted.
//!
//! 30 000 packets for each fault here; HAPDEF_SOAK=1 sends 400 000.

use hapdef_daq::faults::{Fault, Injector};
use hapdef_daq::hdp1::{Decoder, Encoder, Event, FrameFlags, Hello, SampleFormat};

/// What came through.
#[derive(Debug, Default)]
struct Outcome {
    n_hit: u64,
    n_wrong: u64,
    n_received: u64,
    n_lost: u64,
    /// Undamaged packets in a row that were not delivered, at most.
    worst_relock: u64,
}

fn n_packets() -> u32 {
    if std::env::var_os("HAPDEF_SOAK").is_some() { 400_000 } else { 30_000 }
}

/// Samples that anyone can compute from the packet's number.
fn samples(seq: u32, n: usize) -> impl Iterator<Item = i32> {
    (0..n as u32).map(move |i| {
        let mixed = (seq ^ i.wrapping_mul(0x9e37_79b9)).wrapping_mul(0x85eb_ca6b);
        i32::from((mixed >> 16) as u16 as i16)
    })
}

fn send(fault: Fault, n_channels: usize, seed: u64) -> Outcome {
    let hello = Hello::plain(n_channels, SampleFormat::I16, 1000);
    let (mut encoder, mut decoder) = (Encoder::new(), Decoder::new());
    let mut injector = Injector::new(fault, seed);
    let mut outcome = Outcome::default();
    let (mut packet, mut wire) = (vec![0], Vec::new());
    assert!(encoder.hello(&hello, 0, &mut packet).is_ok());
    decoder.push(&packet, &mut |_| {});
    let mut waiting = 0;
    for seq in 0..n_packets() {
        // The first and the last packet are undamaged, so that both ends are known.
        let clean = seq == 0 || seq + 3 >= n_packets();
        packet.clear();
        wire.clear();
        let values: Vec<i32> = samples(seq, n_channels).collect();
        let flags = FrameFlags::default();
        assert!(encoder.data(&hello, u64::from(seq) * 1000, flags, &values, &mut packet).is_ok());
        let hit = !clean && injector.pass(&packet, &mut wire);
        if clean {
            wire.extend(&packet);
        }
        outcome.n_hit += u64::from(hit);
        let before = outcome.n_received;
        decoder.push(&wire, &mut |event| count(&event, n_channels, &mut outcome));
        waiting = if outcome.n_received > before || hit { 0 } else { waiting + 1 };
        outcome.worst_relock = outcome.worst_relock.max(waiting);
    }
    assert_eq!(decoder.losses().n_lost, outcome.n_lost);
    outcome
}

fn count(event: &Event<'_>, n_channels: usize, outcome: &mut Outcome) {
    if let Event::Data(data) = event {
        let seq = data.header.seq;
        let right = data.bits(0).eq(samples(seq, n_channels));
        let on_time = data.t_us(0) == u64::from(seq) * 1000;
        outcome.n_wrong += u64::from(!(right && on_time));
        outcome.n_received += 1;
        outcome.n_lost += u64::from(data.n_lost_before);
    }
}

#[track_caller]
fn check(fault: Fault) {
    for (n_channels, seed) in [(10, 1), (64, 2)] {
        let outcome = send(fault, n_channels, seed);
        let sent = u64::from(n_packets());
        assert_eq!(outcome.n_wrong, 0, "{fault:?}: {outcome:?}");
        assert_eq!(sent - outcome.n_received, outcome.n_lost, "{fault:?}: {outcome:?}");
        assert!(outcome.n_lost * 100 <= outcome.n_hit * 103, "{fault:?}: {outcome:?}");
        assert!(outcome.worst_relock <= 2, "{fault:?}: {outcome:?}");
        assert!(outcome.n_hit > 0, "{fault:?}: {outcome:?}");
    }
}

#[test]
fn bit_flips() {
    for rate in [1e-6, 1e-5, 1e-4] {
        check(Fault::BitFlips { rate });
    }
}

#[test]
fn dropped_bytes() {
    check(Fault::DroppedBytes { rate: 1e-4 });
}

#[test]
fn duplicated_bytes() {
    check(Fault::DuplicatedBytes { rate: 1e-4 });
}

#[test]
fn bursts() {
    check(Fault::Bursts { rate: 1e-4, len: 16 });
}

#[test]
fn holes() {
    check(Fault::Holes { rate: 2e-6, len: 4096 });
}

#[test]
fn garbage_is_no_frames() {
    let hello = Hello::plain(10, SampleFormat::I16, 1000);
    let (mut decoder, mut bytes) = (Decoder::new(), Vec::new());
    assert!(Encoder::new().hello(&hello, 0, &mut bytes).is_ok());
    decoder.push(&bytes, &mut |_| {});
    // 100 MB.
    let mut n_data = 0;
    for seed in 0..96 {
        bytes.clear();
        let fault = Fault::Bursts { rate: 0.5, len: 1 << 20 };
        Injector::new(fault, seed).pass(&vec![0x55; 1 << 20], &mut bytes);
        decoder.push(&bytes, &mut |event| {
            n_data += u32::from(matches!(event, Event::Data(_)));
        });
    }
    assert_eq!(n_data, 0);
    assert!(decoder.rejected().n_damaged > 1000);
}
