//! Hand-solved, exact and degenerate cases.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use hapdef_report::ArgumentError;

use super::*;

fn uniform(rng: &mut ChaCha8Rng) -> f32 {
    (rng.next_u32() >> 8) as f32 / (1 << 24) as f32 * 2.0 - 1.0
}

fn fit(x: &[f32], y: &[f32], p: usize, q: usize) -> (LinearRegression, LinearInfo) {
    let mut sums = LinearAccumulator::new(p, q);
    sums.add_block(x, y).unwrap();
    sums.solve(&LinearParams::default()).unwrap()
}

/// y = 1, 3, 2 at x = 0, 1, 2: slope ½, intercept 3/2 (least squares by hand).
#[test]
fn three_points_by_hand() {
    let (line, info) = fit(&[0.0, 1.0, 2.0], &[1.0, 3.0, 2.0], 1, 1);
    assert!((line.coefficient(0, 0) - 0.5).abs() < 1e-14, "{}", line.coefficient(0, 0));
    let mut at = [0.0];
    line.predict(&[0.0], &mut at).unwrap();
    assert!((at[0] - 1.5).abs() < 1e-6, "{at:?}");
    assert_eq!((info.rank, info.n_samples), (1, 3));
}

/// Ridge on one standardised input: slope = cov·s⁻¹/(1 + ridge)·s⁻¹, here ½/(1 + 1) = ¼.
#[test]
fn ridge_by_hand() {
    let mut sums = LinearAccumulator::new(1, 1);
    sums.add_block(&[0.0, 1.0, 2.0], &[1.0, 3.0, 2.0]).unwrap();
    let params = LinearParams { ridge: 1.0, ..LinearParams::default() };
    let (line, info) = sums.solve(&params).unwrap();
    assert!((line.coefficient(0, 0) - 0.25).abs() < 1e-14, "{}", line.coefficient(0, 0));
    assert!(info.normal_residual < 1e-14, "{info:?}");
}

/// Linear data with offsets of 1e3 and scales of 1e-6 come back exactly, in blocks or at once.
#[test]
fn linear_data_are_exact_and_blocks_agree() {
    let (n, p, q) = (300, 7, 300);
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let a: Vec<f64> = (0..p * q).map(|_| f64::from(uniform(&mut rng))).collect();
    let x: Vec<f32> = (0..n * p).map(|_| 1e-6 * uniform(&mut rng)).collect();
    let y: Vec<f32> = (0..n * q)
        .map(|k| {
            let (i, j) = (k / q, k % q);
            let s: f64 = (0..p).map(|l| f64::from(x[i * p + l]) * 1e6 * a[l * q + j]).sum();
            (s + 0.5) as f32
        })
        .collect();
    let (whole, info) = fit(&x, &y, p, q);
    assert_eq!(info.rank, p);
    let mut sums = LinearAccumulator::new(p, q);
    for i in 0..4 {
        sums.add_block(&x[i * 75 * p..(i + 1) * 75 * p], &y[i * 75 * q..(i + 1) * 75 * q]).unwrap();
    }
    let (blocks, _) = sums.solve(&LinearParams::default()).unwrap();
    for (line, name) in [(&whole, "whole"), (&blocks, "blocks")] {
        for l in 0..p {
            for j in 0..q {
                let found = line.coefficient(l, j) * 1e-6;
                let e = (found - a[l * q + j]).abs();
                assert!(e < 1e-6, "{name} coefficient {l},{j}: {found} vs {}", a[l * q + j]);
            }
        }
    }
    let mut out = vec![0.0; n * q];
    whole.predict(&x, &mut out).unwrap();
    let worst = out.iter().zip(&y).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(worst < 1e-6, "worst prediction error {worst}");
}

/// A duplicated and a constant input: rank 1, the minimum-norm solution shares the slope equally.
#[test]
fn collinear_inputs_share_the_slope() {
    let x: Vec<f32> = (0..50).flat_map(|i| [i as f32, i as f32, 7.7]).collect();
    let y: Vec<f32> = (0..50).map(|i| 3.0 * i as f32 + 1.0).collect();
    let (line, info) = fit(&x, &y, 3, 1);
    assert_eq!((info.rank, info.n_constant_inputs), (1, 1));
    let c = [line.coefficient(0, 0), line.coefficient(1, 0), line.coefficient(2, 0)];
    assert!((c[0] - 1.5).abs() < 1e-12 && (c[1] - 1.5).abs() < 1e-12, "{c:?}");
    assert_eq!(c[2], 0.0);
    assert!(info.normal_residual < 1e-12, "{info:?}");
}

/// The residual of a least-squares fit is orthogonal to every input and has mean zero.
#[test]
fn residual_is_orthogonal_to_the_inputs() {
    let (n, p) = (200, 5);
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let x: Vec<f32> = (0..n * p).map(|_| uniform(&mut rng) + 100.0).collect();
    let y: Vec<f32> = (0..n).map(|i| x[i * p].sin() + uniform(&mut rng)).collect();
    let (line, _) = fit(&x, &y, p, 1);
    let mut out = vec![0.0; n];
    line.predict(&x, &mut out).unwrap();
    for j in 0..p {
        let dot: f64 =
            (0..n).map(|i| f64::from(y[i] - out[i]) * f64::from(x[i * p + j] - 100.0)).sum::<f64>()
                / n as f64;
        assert!(dot.abs() < 1e-6, "input {j}: mean residual product {dot}");
    }
}

#[test]
fn one_and_two_threads_agree_to_the_bit() {
    let (n, p, q) = (600, 20, 700);
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let x: Vec<f32> = (0..n * p).map(|_| uniform(&mut rng)).collect();
    let y: Vec<f32> = (0..n * q).map(|_| uniform(&mut rng)).collect();
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let (line, _) = fit(&x, &y, p, q);
            let mut out = vec![0.0; n * q];
            line.predict(&x, &mut out).unwrap();
            out
        })
    };
    assert!(run(1) == run(2), "predictions differ between one and two threads");
}

#[test]
fn what_cannot_be_regressed_is_refused() {
    let mut sums = LinearAccumulator::new(2, 1);
    let refused = sums.add_block(&[1.0, f32::NAN], &[1.0]);
    assert!(
        matches!(refused, Err(ReproError::RowNotFinite { row: 0, column: 1, .. })),
        "{refused:?}"
    );
    assert!(matches!(sums.add_block(&[1.0], &[1.0]), Err(ReproError::NotWholeRows { .. })));
    assert!(matches!(
        sums.add_block(&[1.0, 2.0], &[]),
        Err(ReproError::Argument(ArgumentError::Shape { .. }))
    ));
    assert_eq!(sums.n_samples(), 0);
    let params = LinearParams::default();
    assert!(matches!(sums.solve(&params), Err(ReproError::TooFewSamples { found: 0, .. })));
    sums.add_block(&[1.1, 2.0, 1.1, 2.0, 1.1, 2.0], &[1.0, 2.0, 3.0]).unwrap();
    assert!(matches!(sums.solve(&params), Err(ReproError::NoVariance { n_inputs: 2, .. })));
    let bad = LinearParams { ridge: -1.0, ..params };
    assert!(matches!(
        sums.solve(&bad),
        Err(ReproError::Argument(ArgumentError::Parameter { what: "ridge", .. }))
    ));
}
