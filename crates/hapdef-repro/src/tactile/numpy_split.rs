//! Which presses test: the permutation that the reference figures were made with, and others.
//!
//! NumPy's `default_rng(seed).permutation(n)` in few lines, so that our figures stand beside the
//! reference on the same presses: `SeedSequence` (M. E. O'Neill's seed_seq_fe, pcg-random.org,
//! "Developing a seed_seq Alternative", 2015) feeds PCG XSL-RR 128/64 (M. E. O'Neill, "PCG", HMC-CS-2014-0905,
//! 2014), and a Fisher–Yates shuffle draws its places by rejection under a mask.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Permutations of `0..n` for each of `sizes`, drawn one after the other by NumPy's
/// `default_rng(seed)`.
pub fn numpy_permutations(seed: u32, sizes: &[usize]) -> Vec<Vec<usize>> {
    let mut words = Pcg64::new(seed);
    let mut next = || words.next_u32();
    sizes.iter().map(|&n| shuffled(n, &mut next)).collect()
}

/// A permutation of `0..n` from the project's own generator.
pub fn seeded_permutation(seed: u64, n: usize) -> Vec<usize> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    shuffled(n, &mut || rng.next_u32())
}

/// Fisher–Yates from the end, places by rejection under the smallest mask.
fn shuffled(n: usize, next: &mut impl FnMut() -> u32) -> Vec<usize> {
    let mut all: Vec<usize> = (0..n).collect();
    for i in (1..n).rev() {
        let mask = usize::MAX >> i.leading_zeros();
        let place = loop {
            let word = next() as usize & mask;
            if word <= i {
                break word;
            }
        };
        all.swap(i, place);
    }
    all
}

/// NumPy's `PCG64` behind its 32-bit buffer.
struct Pcg64 {
    state: u128,
    increment: u128,
    upper: Option<u32>,
}

impl Pcg64 {
    const MULTIPLIER: u128 = 0x2360_ed05_1fc6_5da4_4385_df64_9fcc_f645;

    fn new(seed: u32) -> Self {
        let words = seed_sequence(seed);
        let wide = |high: u64, low: u64| u128::from(high) << 64 | u128::from(low);
        let mut made = Self { state: 0, increment: wide(words[2], words[3]) << 1 | 1, upper: None };
        made.step();
        made.state = made.state.wrapping_add(wide(words[0], words[1]));
        made.step();
        made
    }

    fn step(&mut self) {
        self.state = self.state.wrapping_mul(Self::MULTIPLIER).wrapping_add(self.increment);
    }

    fn next_u32(&mut self) -> u32 {
        if let Some(upper) = self.upper.take() {
            return upper;
        }
        self.step();
        let folded = (self.state >> 64) as u64 ^ self.state as u64;
        let word = folded.rotate_right((self.state >> 122) as u32);
        self.upper = Some((word >> 32) as u32);
        word as u32
    }
}

/// Four words of NumPy's `SeedSequence(seed)`.
fn seed_sequence(seed: u32) -> [u64; 4] {
    let mut constant = 0x43b0_d7e5_u32;
    let mut hashed = |value: u32| hash(value, &mut constant, 0x931e_8875);
    let mut pool = [seed, 0, 0, 0].map(&mut hashed);
    for source in 0..4 {
        for target in (0..4).filter(|&target| target != source) {
            let mixed = 0xca01_f9dd_u32
                .wrapping_mul(pool[target])
                .wrapping_sub(0x4973_f715_u32.wrapping_mul(hashed(pool[source])));
            pool[target] = mixed ^ mixed >> 16;
        }
    }
    let mut constant = 0x8b51_f9dd;
    let mut words = [0; 4];
    for (word, pair) in words.iter_mut().zip([[0, 1], [2, 3], [0, 1], [2, 3]]) {
        let [low, high] = pair.map(|i| u64::from(hash(pool[i], &mut constant, 0x58f3_8ded)));
        *word = high << 32 | low;
    }
    words
}

fn hash(value: u32, constant: &mut u32, multiplier: u32) -> u32 {
    let value = value ^ *constant;
    *constant = constant.wrapping_mul(multiplier);
    let value = value.wrapping_mul(*constant);
    value ^ value >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `g = numpy.random.default_rng(0); g.permutation(4805)[:8]`, twice, NumPy 2.
    #[test]
    fn the_permutations_are_numpys() {
        let drawn = numpy_permutations(0, &[4805, 4805]);
        let first = [4460, 4303, 3140, 3374, 1922, 1403, 2501, 1877];
        let second = [1329, 4050, 3974, 3544, 4073, 1055, 3923, 996];
        assert_eq!((&drawn[0][..8], &drawn[1][..8]), (&first[..], &second[..]));
        let mut sorted = drawn[1].clone();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..4805));
    }
}
