//! A smooth function, two points by hand, and the thinning.

use super::*;

fn wave(n: usize, offset: f32) -> (Vec<f32>, Vec<f32>) {
    let x: Vec<f32> = (0..n)
        .flat_map(|i| {
            let t = i as f32 / n as f32 * 6.0 + offset;
            [1e-4 * t, 5.0 + (2.0 * t).cos()]
        })
        .collect();
    let y = x.chunks_exact(2).flat_map(|r| [100.0 * (1e4 * r[0]).sin(), r[1], 3.5]).collect();
    (x, y)
}

/// A smooth function is learnt between its samples; a constant output is returned as such.
#[test]
fn learns_a_wave() {
    let (x, y) = wave(120, 0.0);
    let params = SvrParams { gamma: 0.5, ..SvrParams::default() };
    let (svr, info) = Svr::train(&x, &y, 2, 3, &params).unwrap();
    assert_eq!((info.n_offered, info.n_trained), (120, 120));
    let (xt, yt) = wave(120, 0.025);
    let mut out = vec![0.0; yt.len()];
    svr.predict(&xt[..200], &mut out[..300]).unwrap();
    let worst = |j: usize| {
        out[..300]
            .chunks_exact(3)
            .zip(yt.chunks_exact(3))
            .map(|(a, b)| (a[j] - b[j]).abs())
            .fold(0.0, f32::max)
    };
    assert!(worst(0) < 2.0, "worst sine error {} of amplitude 100", worst(0));
    assert!(worst(1) < 0.02, "worst cosine error {} of amplitude 1", worst(1));
    assert!(worst(2) < 1e-6, "constant output off by {}", worst(2));
}

/// Two standardised points ±1 with labels ±1: by symmetry f(±1) = ±α(1 − e^(−4γ)) with α
/// below C, and the fit meets the labels to within ε and the solver's tolerance.
#[test]
fn two_points_by_hand() {
    let (svr, info) = Svr::train(&[0.0, 10.0], &[-3.0, 3.0], 1, 1, &SvrParams::default()).unwrap();
    assert_eq!(info.n_support, [2]);
    let mut out = [0.0; 3];
    svr.predict(&[0.0, 5.0, 10.0], &mut out).unwrap();
    assert!((out[0] + 3.0).abs() < 0.01 && (out[2] - 3.0).abs() < 0.01, "{out:?}");
    assert!(out[1].abs() < 1e-3, "{out:?}");
    let coef = svr.machines[0].sv_coef[0].iter().map(|c| c.abs()).fold(0.0, f64::max);
    let by_hand = 1.0 / (1.0 - (-0.5_f64).exp());
    assert!((coef - by_hand).abs() < 5e-3, "{coef} vs {by_hand}");
}

#[test]
fn thinning_is_seeded_and_reported() {
    let (x, y) = wave(50, 0.0);
    let params = SvrParams { max_samples: 20, seed: 7, ..SvrParams::default() };
    let (a, info) = Svr::train(&x, &y, 2, 3, &params).unwrap();
    assert_eq!((info.n_offered, info.n_trained, info.seed), (50, 20, 7));
    let (b, _) = Svr::train(&x, &y, 2, 3, &params).unwrap();
    let mut out = [vec![0.0; 150], vec![0.0; 150]];
    a.predict(&x, &mut out[0]).unwrap();
    b.predict(&x, &mut out[1]).unwrap();
    assert!(out[0] == out[1], "same seed, different machines");
    let picked = draw(50, 20, 7);
    assert!(picked.windows(2).all(|w| w[0] < w[1]) && picked[19] < 50, "{picked:?}");
    assert_ne!(picked, draw(50, 20, 8));
}

#[test]
fn bad_arguments_are_refused() {
    let bad = SvrParams { c: 0.0, ..SvrParams::default() };
    let error = Svr::train(&[0.0, 1.0], &[0.0, 1.0], 1, 1, &bad).unwrap_err();
    assert_eq!(error.to_string(), "SVR c = 0: must be finite and above 0");
    let ok = SvrParams::default();
    let error = Svr::train(&[0.0], &[0.0], 1, 1, &ok).unwrap_err();
    assert!(matches!(error, ReproError::TooFewSamples { found: 1, .. }), "{error}");
    let error = Svr::train(&[0.0, f32::INFINITY], &[0.0, 1.0], 1, 1, &ok).unwrap_err();
    assert!(matches!(error, ReproError::RowNotFinite { row: 1, column: 0, .. }), "{error}");
}
