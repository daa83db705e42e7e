//! Seeded damage to a stream of packets: what cables and drivers do to it.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// One kind of damage; rates are chances per bit or per byte that one begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// Bits that flip.
    BitFlips {
        /// Chance per bit.
        rate: f64,
    },
    /// Bytes that vanish.
    DroppedBytes {
        /// Chance per byte.
        rate: f64,
    },
    /// Bytes that come twice.
    DuplicatedBytes {
        /// Chance per byte.
        rate: f64,
    },
    /// Runs of bytes that are replaced by random ones.
    Bursts {
        /// Chance per byte that one begins.
        rate: f64,
        /// Bytes of each.
        len: usize,
    },
    /// Runs of bytes that vanish.
    Holes {
        /// Chance per byte that one begins.
        rate: f64,
        /// Bytes of each.
        len: usize,
    },
}

/// Passes packets on, damaged; the same seed damages the same bytes.
#[derive(Clone, Debug)]
pub struct Injector {
    fault: Fault,
    rng: ChaCha8Rng,
    /// Bits or bytes until the next damage begins.
    wait: u64,
    /// Bytes of a burst or hole that are still to come.
    run: usize,
}

impl Injector {
    /// An injector of one kind of damage.
    #[must_use]
    pub fn new(fault: Fault, seed: u64) -> Self {
        let mut injector = Self { fault, rng: ChaCha8Rng::seed_from_u64(seed), wait: 0, run: 0 };
        injector.wait = injector.draw_wait();
        injector
    }

    /// Appends a packet to `out` as the cable hands it on: true if any of its bytes was hit.
    pub fn pass(&mut self, packet: &[u8], out: &mut Vec<u8>) -> bool {
        let mut hit = false;
        for &byte in packet {
            hit |= match self.fault {
                Fault::BitFlips { .. } => self.flip(byte, out),
                _ => self.byte(byte, out),
            };
        }
        hit
    }

    fn flip(&mut self, mut byte: u8, out: &mut Vec<u8>) -> bool {
        let mut hit = false;
        let mut at = 0;
        while self.wait < 8 - at {
            at += self.wait;
            byte ^= 1 << at;
            hit = true;
            at += 1;
            self.wait = self.draw_wait();
            if at == 8 {
                break;
            }
        }
        self.wait -= 8 - at;
        out.push(byte);
        hit
    }

    fn byte(&mut self, byte: u8, out: &mut Vec<u8>) -> bool {
        if self.run == 0 && self.wait > 0 {
            self.wait -= 1;
            out.push(byte);
            return false;
        }
        if self.run == 0 {
            self.wait = self.draw_wait();
            self.run = match self.fault {
                Fault::Bursts { len, .. } | Fault::Holes { len, .. } => len,
                _ => 1,
            };
        }
        self.run -= 1;
        match self.fault {
            Fault::DuplicatedBytes { .. } => out.extend([byte, byte]),
            Fault::Bursts { .. } => out.push(self.rng.next_u32().to_le_bytes()[0]),
            _ => {}
        }
        true
    }

    /// Units until the next damage: geometric, by inversion.
    fn draw_wait(&mut self) -> u64 {
        let (Fault::BitFlips { rate }
        | Fault::DroppedBytes { rate }
        | Fault::DuplicatedBytes { rate }
        | Fault::Bursts { rate, .. }
        | Fault::Holes { rate, .. }) = self.fault;
        let u = ((self.rng.next_u64() >> 11) as f64 + 0.5) * (0.5f64).powi(53);
        (u.ln() / (-rate).ln_1p()) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_kept_and_seeds_repeat() {
        let zeros = vec![0u8; 1_000_000];
        let (mut first, mut second) = (Vec::new(), Vec::new());
        let fault = Fault::BitFlips { rate: 1e-3 };
        Injector::new(fault, 5).pass(&zeros, &mut first);
        Injector::new(fault, 5).pass(&zeros, &mut second);
        let flipped: u32 = first.iter().map(|b| b.count_ones()).sum();
        // 8000 expected, standard deviation 89.
        assert!((7600..8400).contains(&flipped), "{flipped}");
        assert_eq!(first, second);
    }

    #[test]
    fn holes_have_their_length() {
        let mut out = Vec::new();
        let fault = Fault::Holes { rate: 1e-5, len: 4096 };
        let mut injector = Injector::new(fault, 1);
        let hits = (0..1000).filter(|_| injector.pass(&[7; 1000], &mut out));
        let n_hit = hits.count();
        let missing = 1_000_000 - out.len();
        assert!(missing > 0 && missing.is_multiple_of(4096), "{missing}");
        assert!((missing / 1000..=missing / 1000 + 2 * missing / 4096 + 2).contains(&n_hit));
    }
}
