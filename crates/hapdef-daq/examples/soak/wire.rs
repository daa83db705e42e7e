//! Seeded damage to the wire, HELLOs and all.

use hapdef_daq::faults::{Fault, Injector};
use hapdef_daq::hdp1::{Decoder, Event, SampleFormat};

use crate::proc::rss_mib;
use crate::support::{Device, samples};

/// What came through, over all kinds of damage.
#[derive(Debug, Default)]
#[allow(dead_code, reason = "it is printed as a whole")]
pub struct Wire {
    pub n_sent: u64,
    pub n_hit: u64,
    pub n_received: u64,
    pub n_lost: u64,
    pub n_wrong: u64,
    /// Packets that were neither delivered nor counted as lost, or both.
    pub n_unaccounted: u64,
    /// Packets lost for each one that was hit, at worst.
    pub worst_loss_ratio: f64,
    /// Undamaged packets in a row that were not delivered, at worst.
    pub worst_relock: u64,
}

/// What came of random bytes.
#[derive(Debug)]
#[allow(dead_code, reason = "it is printed as a whole")]
pub struct Garbage {
    pub n_mib: u32,
    /// DATA packets that were taken for such.
    pub n_wrong: u64,
    pub n_damaged: u64,
    pub rss_growth_mib: f64,
}

const FAULTS: [Fault; 7] = [
    Fault::BitFlips { rate: 1e-6 },
    Fault::BitFlips { rate: 1e-5 },
    Fault::BitFlips { rate: 1e-4 },
    Fault::DroppedBytes { rate: 1e-4 },
    Fault::DuplicatedBytes { rate: 1e-4 },
    Fault::Bursts { rate: 1e-4, len: 16 },
    Fault::Holes { rate: 2e-6, len: 4096 },
];

pub fn run(n_frames: u32, seed: u64) -> Wire {
    let mut all = Wire::default();
    for fault in FAULTS {
        let one = send(fault, n_frames, seed);
        println!("  {fault:?}: {one:?}");
        all.n_sent += one.n_sent;
        all.n_hit += one.n_hit;
        all.n_received += one.n_received;
        all.n_lost += one.n_lost;
        all.n_wrong += one.n_wrong;
        all.n_unaccounted += one.n_unaccounted;
        all.worst_loss_ratio = all.worst_loss_ratio.max(one.worst_loss_ratio);
        all.worst_relock = all.worst_relock.max(one.worst_relock);
    }
    all
}

/// Random bytes behind a HELLO.
pub fn garbage(n_mib: u32, seed: u64) -> Garbage {
    const MIB: usize = 1 << 20;
    let mut device = Device::new(10, SampleFormat::I16);
    let (mut decoder, mut bytes) = (Decoder::new(), Vec::with_capacity(4 * MIB));
    device.say_hello(&mut bytes);
    decoder.push(&bytes, &mut |_| {});
    let fault = Fault::Bursts { rate: 0.5, len: MIB };
    let (blank, mut n_wrong, mut warm_mib) = (vec![0x55; MIB], 0, rss_mib());
    for i in 0..n_mib {
        bytes.clear();
        Injector::new(fault, seed + u64::from(i)).pass(&blank, &mut bytes);
        decoder.push(&bytes, &mut |event| {
            n_wrong += u64::from(matches!(event, Event::Data(_)));
        });
        if i == 0 {
            warm_mib = rss_mib();
        }
    }
    Garbage {
        n_mib,
        n_wrong,
        n_damaged: decoder.rejected().n_damaged,
        rss_growth_mib: rss_mib() - warm_mib,
    }
}

fn send(fault: Fault, n_frames: u32, seed: u64) -> Wire {
    let mut device = Device::new(10, SampleFormat::I16);
    let mut decoder = Decoder::new();
    let mut injector = Injector::new(fault, seed);
    let mut one = Wire::default();
    let (mut packet, mut wire) = (Vec::new(), Vec::new());
    let mut n_waiting = 0;
    for i in 0..n_frames {
        packet.clear();
        wire.clear();
        device.tick(&mut packet);
        // Both ends are undamaged, so that they are known.
        let is_clean = i == 0 || i + 3 >= n_frames;
        let is_hit = !is_clean && injector.pass(&packet, &mut wire);
        if is_clean {
            wire.extend(&packet);
        }
        one.n_hit += u64::from(is_hit);
        let n_before = one.n_received;
        decoder.push(&wire, &mut |event| {
            if let Event::Data(data) = event {
                let is_right = data.bits(0).eq(samples(data.header.seq, 10));
                one.n_wrong += u64::from(!is_right);
                one.n_received += 1;
                one.n_lost += u64::from(data.n_lost_before);
            }
        });
        let is_settled = is_hit || one.n_received > n_before;
        n_waiting = if is_settled { 0 } else { n_waiting + 1 };
        one.worst_relock = one.worst_relock.max(n_waiting);
    }
    one.worst_loss_ratio = one.n_lost as f64 / one.n_hit.max(1) as f64;
    one.n_sent = u64::from(n_frames);
    one.n_unaccounted = one.n_sent.abs_diff(one.n_received + one.n_lost);
    one
}
