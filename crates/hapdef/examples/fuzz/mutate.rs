//! Seeded damage: new inputs from those of the corpus.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng;

/// Longest input.
const MAX_LEN: usize = 1 << 16;
/// Changes to an input at most.
const MAX_CHANGES: u64 = 8;
/// Numbers that readers stumble over, as text.
const WORDS: [&str; 12] = [
    "0",
    "-1",
    "1e999",
    "NaN",
    "null",
    "4294967296",
    "18446744073709551615",
    "-0.0",
    "1e-320",
    "[]",
    "{}",
    "\"\"",
];

/// One of the seeds, changed in a few places.
pub fn mutated(seeds: &[Vec<u8>], rng: &mut ChaCha8Rng) -> Vec<u8> {
    let seed = |rng: &mut ChaCha8Rng| &seeds[below(rng, seeds.len())];
    let mut bytes = seed(rng).clone();
    for _ in 0..1 + rng.next_u64() % MAX_CHANGES {
        let other = seed(rng).clone();
        change(&mut bytes, &other, rng);
    }
    bytes.truncate(MAX_LEN);
    bytes
}

fn change(bytes: &mut Vec<u8>, other: &[u8], rng: &mut ChaCha8Rng) {
    let at = below(rng, bytes.len() + 1);
    let len = 1 + below(rng, 16);
    let end = (at + len).min(bytes.len());
    match rng.next_u64() % 10 {
        0 => bytes.truncate(at),
        1 => drop(bytes.drain(at..end)),
        2 => {
            let piece = bytes[at..end].to_vec();
            let times = 1 + below(rng, 20);
            bytes.splice(at..at, piece.repeat(times));
        }
        3 => {
            let from = below(rng, other.len() + 1);
            let to = (from + 1 + below(rng, 200)).min(other.len());
            bytes.splice(at..end, other[from..to].iter().copied());
        }
        4 => {
            let value = interesting(rng).to_le_bytes();
            let width = [1, 2, 4, 8][below(rng, 4)];
            bytes.splice(at..(at + width).min(bytes.len()), value[..width].iter().copied());
        }
        5 => word(bytes, at, rng),
        6 => bytes.splice(at..at, (0..len).map(|_| rng.next_u64() as u8)).for_each(drop),
        7 => bytes[at..end].fill(rng.next_u64() as u8),
        _ => {
            if let Some(byte) = bytes.get_mut(at) {
                *byte ^= 1 << (rng.next_u64() % 8);
            }
        }
    }
}

/// Puts a word in place of the next number.
fn word(bytes: &mut Vec<u8>, at: usize, rng: &mut ChaCha8Rng) {
    let is_number = |b: &u8| b.is_ascii_digit() || b"+-.eE".contains(b);
    let Some(start) = bytes[at..].iter().position(u8::is_ascii_digit) else {
        return;
    };
    let start = at + start;
    let len = bytes[start..].iter().take_while(|b| is_number(b)).count();
    let word = WORDS[below(rng, WORDS.len())];
    bytes.splice(start..start + len, word.bytes());
}

fn interesting(rng: &mut ChaCha8Rng) -> u64 {
    let near = 1u64.checked_shl(below(rng, 64) as u32).unwrap_or(0);
    match rng.next_u64() % 4 {
        0 => near,
        1 => near.wrapping_sub(1),
        2 => near.wrapping_neg(),
        _ => rng.next_u64(),
    }
}

fn below(rng: &mut ChaCha8Rng, n: usize) -> usize {
    (rng.next_u64() % n.max(1) as u64) as usize
}
