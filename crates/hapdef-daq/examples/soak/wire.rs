//! Seeded damage to the wire, HELLOs and all.

use hapdef_daq::faults::{Fault, Injector};
use hapdef_daq::hdp1::{Decoder, Event, SampleFormat};

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
}

const FAULTS: [Fault; 7] = [
    Fault::BitFlips { rate: 1e-6 },
    Fault::BitFlips { rate: 1e-5 },
    Fault::BitFlips { rate: 1e-4 },
    Fault::DroppedBytes { rate: 1e-4 },
    Fault::DuplicatedBytes { rate: 1e-4 },
    Fault::Bursts {
        rate: 1e-4,
        len: 16,
    },
    Fault::Holes {
        rate: 2e-6,
        len: 4096,
    },
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
    }
    all
}

fn send(fault: Fault, n_frames: u32, seed: u64) -> Wire {
    let mut device = Device::new(10, SampleFormat::I16);
    let mut decoder = Decoder::new();
    let mut injector = Injector::new(fault, seed);
    let mut one = Wire::default();
    let (mut packet, mut wire) = (Vec::new(), Vec::new());
    for i in 0..n_frames {
        packet.clear();
        wire.clear();
        device.tick(&mut packet);
        // Both ends are undamaged, so that they are known.
        if i == 0 || i + 3 >= n_frames {
            wire.extend(&packet);
        } else {
            one.n_hit += u64::from(injector.pass(&packet, &mut wire));
        }
        decoder.push(&wire, &mut |event| {
            if let Event::Data(data) = event {
                let is_right = data.bits(0).eq(samples(data.header.seq, 10));
                one.n_wrong += u64::from(!is_right);
                one.n_received += 1;
                one.n_lost += u64::from(data.n_lost_before);
            }
        });
    }
    one.n_sent = u64::from(n_frames);
    one.n_unaccounted = one.n_sent.abs_diff(one.n_received + one.n_lost);
    one
}
