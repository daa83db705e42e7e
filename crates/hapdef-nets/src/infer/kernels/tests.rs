//! Every level against sums in 64 bits, and against the others.

use super::*;
use crate::activation::Activation;
use crate::infer::panels::{Line, int8_lines};
use crate::infer::quantise::ByteScale;

/// Whole numbers that repeat only after long.
fn number(i: usize) -> usize {
    (i * i + 13 * i) % 7919
}

fn weight(output: usize, input: usize) -> i8 {
    number(output * 531 + input) as u8 as i8
}

/// Sums of inputs of `P` bytes, each 0 or `value`, against sums in 64 bits.
fn sums_are_exact<const P: usize>(n_in: usize, n_out: usize) {
    let values: Vec<usize> = (0..n_in).map(|i| number(i) % (1 << (8 * P))).collect();
    let active: Vec<usize> = (0..n_in).filter(|i| i % 3 != 1).collect();
    let n_filled = active.len().next_multiple_of(4);
    let mut rows: Vec<u32> = active.iter().map(|i| *i as u32).collect();
    rows.resize(n_filled, 0);
    let byte = |p: usize| {
        let mut bytes: Vec<u8> = active.iter().map(|i| (values[*i] >> (8 * p)) as u8).collect();
        bytes.resize(n_filled, 0);
        bytes
    };
    let (low, high) = (byte(0), byte(1));
    let x = ActiveBytes { rows: &rows, bytes: [&low, &high] };
    let panels = int8_lines([n_out, n_in], weight);
    for level in SimdLevel::available() {
        let mut out = vec![Line([7; 16]); n_out.div_ceil(64) * 4 * P];
        Isa::new(level).unwrap().bytes::<P>(&panels, x, &mut out);
        for o in 0..n_out {
            let line = |p: usize| out[o / 64 * 4 * P + 4 * p + o / 16 % 4].0[o % 16];
            let found: i64 = (0..P).map(|p| i64::from(line(p)) << (8 * p)).sum();
            let terms = active.iter().map(|i| i64::from(weight(o, *i)) * values[*i] as i64);
            assert_eq!(found, terms.sum::<i64>(), "{level:?} {n_in} {n_out} {P} {o}");
        }
    }
}

#[test]
fn sums_of_bytes_are_exact_on_every_level() {
    for (n_in, n_out) in [(1, 1), (5, 64), (33, 65), (200, 300), (40, 4200)] {
        sums_are_exact::<1>(n_in, n_out);
        sums_are_exact::<2>(n_in, n_out);
    }
}

#[test]
fn what_follows_the_sums_has_the_same_bits_on_every_level() {
    let wave = |i: usize| (0.37 * i as f32).sin();
    let sums: Vec<F32Line> =
        (0..9).map(|i| Line(std::array::from_fn(|l| wave(16 * i + l)))).collect();
    let whole: Vec<I32Line> =
        (0..24).map(|i| Line(std::array::from_fn(|l| number(16 * i + l) as i32 - 4000))).collect();
    let lines = |shift: usize| -> Vec<Sixteen<f32>> {
        (0..9).map(|i| std::array::from_fn(|l| wave(shift + 16 * i + l))).collect()
    };
    let (scales, bias) = (lines(5), lines(11));
    let row_sums: Vec<Sixteen<i32>> = vec![[3; 16]; 9];
    let inputs = ByteScale { scale: 0.013, offset: 128 };
    let bytes = ByteEnding { inputs, row_sums: &row_sums };
    for activation in [None, Some(Activation::Tanh), Some(Activation::Relu)] {
        let ending = Ending { scales: &scales, bias: &bias, activation };
        let at = |level: SimdLevel| {
            let isa = Isa::new(level).unwrap();
            let mut values = [[[0.0; 16]; 9]; 3];
            let [floats, one, two] = &mut values;
            let extents = [
                isa.finish(&sums, ending, floats),
                isa.finish_bytes::<1>(&whole[..12], bytes, ending, one),
                isa.finish_bytes::<2>(&whole, bytes, ending, two),
            ];
            let mut steps = [[0; 144]; 2];
            isa.to_steps::<1>(floats.as_flattened(), extents[0], &mut steps[0]);
            isa.to_steps::<2>(floats.as_flattened(), extents[0], &mut steps[1]);
            (values.as_flattened().as_flattened().to_vec(), steps)
        };
        let expected = at(SimdLevel::Portable);
        assert!(expected.0.iter().any(|v| *v != 0.0));
        for level in SimdLevel::available() {
            assert_eq!(at(level), expected, "{level:?} {activation:?}");
        }
    }
}
