//! The measuring chain against closed forms.

use hapdef_rig::ElectronicsParams;
use hapdef_rig::live::{BridgeParams, CreepTerm, LiveElectronics, LiveElectronicsParams};

const RATE_HZ: f64 = 1000.0;

/// 32 bits over ±1500 µε and no noise: what remains is what the test adds.
fn quiet() -> LiveElectronicsParams {
    LiveElectronicsParams::new(ElectronicsParams {
        noise_ue: 0.0,
        adc_bits: 32,
        headroom: 1.5,
        seed: 3,
    })
}

fn chain(params: LiveElectronicsParams, n: usize) -> LiveElectronics {
    LiveElectronics::new(params, RATE_HZ, &vec![1000.0; n]).unwrap()
}

/// Readings of channel 0 for a constant strain, µε.
fn readings(chain: &mut LiveElectronics, strain_ue: f64, n: usize) -> Vec<f64> {
    let mut codes = vec![0; chain.n_channels()];
    let strain = vec![strain_ue; chain.n_channels()];
    (0..n)
        .map(|i| {
            chain.sample(i as f64 / RATE_HZ, &strain, &mut codes);
            f64::from(codes[0]) * chain.resolution_ue(0)
        })
        .collect()
}

fn sd(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt()
}

#[test]
fn noise_has_its_spread_and_no_memory() {
    let mut params = quiet();
    params.converter.noise_ue = 4.0;
    let values = readings(&mut chain(params, 1), 100.0, 40_000);
    // Standard error of a standard deviation: 4 / √80000 = 0.014.
    assert!((sd(&values) - 4.0).abs() < 0.05, "{}", sd(&values));
    let mean = values.iter().sum::<f64>() / 4e4;
    assert!((mean - 100.0).abs() < 0.08, "{mean}");
    let pairs = values.windows(2);
    let lag_1: f64 = pairs.map(|w| (w[0] - mean) * (w[1] - mean)).sum::<f64>() / 4e4 / 16.0;
    assert!(lag_1.abs() < 0.02, "correlation {lag_1}");
}

/// One-sided spectral density at `f_hz`, mean over pieces of `n` samples with Hann's window, µε²/Hz
/// (Welch, IEEE Trans. Audio Electroacoust. 15(2), 1967).
fn density(values: &[f64], n: usize, f_hz: f64) -> f64 {
    use std::f64::consts::TAU;
    let window: Vec<f64> = (0..n).map(|i| 0.5 - 0.5 * (TAU * i as f64 / n as f64).cos()).collect();
    let power: f64 = window.iter().map(|w| w * w).sum();
    let pieces = values.chunks_exact(n);
    let n_pieces = pieces.len() as f64;
    let one = |piece: &[f64]| {
        let mean = piece.iter().sum::<f64>() / n as f64;
        let (mut re, mut im) = (0.0, 0.0);
        for (i, (value, weight)) in piece.iter().zip(&window).enumerate() {
            let (sin, cos) = (TAU * f_hz * i as f64 / RATE_HZ).sin_cos();
            re += weight * (value - mean) * cos;
            im += weight * (value - mean) * sin;
        }
        2.0 * (re * re + im * im) / (RATE_HZ * power)
    };
    pieces.map(one).sum::<f64>() / n_pieces
}

/// 1/f from 1 Hz to 100 Hz: density times frequency is the square of what was asked for, and no piece
/// of the band has more than 10 % too much or too little.
#[test]
fn flicker_goes_with_one_over_f() {
    let mut params = quiet();
    params.flicker_ue = 2.0;
    let values = readings(&mut chain(params.clone(), 1), 0.0, 600_000);
    let mut all = Vec::new();
    for octave in 0..7 {
        let from_hz = 2_f64.powi(octave);
        // 8 frequencies of an octave in 150 pieces or more: a standard error of about 4 %
        let n = if octave < 3 { 4000 } else { 1000 };
        let frequencies = (0..8).map(|i| from_hz * 2_f64.powf((f64::from(i) + 0.5) / 8.0));
        let each = frequencies.map(|f_hz| density(&values, n, f_hz) * f_hz);
        let mean = each.sum::<f64>() / 8.0;
        println!("{from_hz} Hz: {mean:.3} µε²");
        all.push(mean);
    }
    for (octave, mean) in all.iter().enumerate() {
        assert!((mean / 4.0 - 1.0).abs() < 0.1, "octave {octave}: {mean} µε²");
    }
    let again = readings(&mut chain(params, 1), 0.0, 1000);
    assert_eq!(again, values[..1000]);
}

/// ARDUINO DUE, gauge factor 2, 3.3 V: 1.65 µV/µε in front of the amplifier, so a step of 12 bits over
/// 3.3 V is 3.3 / 4096 / gain / 1.65e-6 µε.
#[test]
fn a_bridge_has_its_step() {
    for (gain, expected) in [(100.0, 4.883), (500.0, 0.977), (1000.0, 0.488)] {
        let bridge = BridgeParams { gauge_factor: 2.0, excitation_v: 3.3, gain, range_v: 3.3 };
        let mut params = quiet();
        params.converter.adc_bits = 12;
        params.bridge = Some(bridge);
        let mut chain = chain(params, 1);
        let step = chain.resolution_ue(0);
        assert!((step - expected).abs() < 1e-3, "gain {gain}: {step} µε");
        let mut seen = std::collections::BTreeSet::new();
        for i in 0..400 {
            let strain = f64::from(i) * step / 40.0;
            let value = readings(&mut chain, strain, 1)[0];
            // Strains here are small: a quarter bridge is linear to k ε / 2.
            assert!((value - strain).abs() <= step / 2.0 + 1e-4 * strain);
            seen.insert((value / step).round() as i64);
        }
        assert_eq!(seen, (0..=10).collect());
    }
}

#[test]
fn a_quarter_bridge_bends() {
    let mut params = quiet();
    params.bridge =
        Some(BridgeParams { gauge_factor: 2.0, excitation_v: 3.3, gain: 100.0, range_v: 3.3 });
    let mut chain = chain(params, 1);
    for strain in [5000.0, -5000.0, 200.0] {
        let value = readings(&mut chain, strain, 1)[0];
        let ratio = 2.0 * strain * 1e-6 / (4.0 + 2.0 * 2.0 * strain * 1e-6);
        let expected = ratio * 4.0 / 2.0 * 1e6;
        assert!((value - expected).abs() < 1e-4, "{value}, expected {expected}");
    }
}

#[test]
fn the_ends_of_the_range_hold_and_are_reported() {
    let mut params = quiet();
    params.converter.adc_bits = 12;
    let mut chain = chain(params, 2);
    let mut codes = [0; 2];
    chain.sample(0.0, &[1e5, 0.0], &mut codes);
    assert_eq!((codes, chain.saturated()), ([2047, 0], 1));
    chain.sample(0.001, &[0.0, -1e5], &mut codes);
    assert_eq!((codes, chain.saturated()), ([0, -2048], 2));
    chain.sample(0.002, &[1499.0, -1500.0], &mut codes);
    assert_eq!((codes, chain.saturated()), ([2047, -2048], 0));
}

#[test]
fn creep_is_exponential() {
    let mut params = quiet();
    let (share, time_s) = (0.05, 0.4);
    params.creep = vec![CreepTerm { share, time_s }];
    let mut chain = chain(params, 1);
    let loaded = readings(&mut chain, 1000.0, 1001);
    for i in [0, 100, 400, 1000] {
        let t_s = i as f64 / RATE_HZ;
        let expected = 1000.0 * (1.0 + share * (1.0 - (-t_s / time_s).exp()));
        let error = loaded[i] - expected;
        assert!(error.abs() < 1e-6, "{t_s} s: {} µε, expected {expected}", loaded[i]);
    }
    let left = 1000.0 * share * (1.0 - (-1.001_f64 / time_s).exp());
    let released = readings(&mut chain, 0.0, 401)[400];
    let expected = left * (-0.4_f64 / time_s).exp();
    assert!((released - expected).abs() < 1e-6, "{released}, expected {expected}");
}

#[test]
fn logarithmic_creep_grows_by_decades() {
    let terms = CreepTerm::logarithmic(0.01, 1e-3, 1e5);
    let crept = |t_s: f64| -> f64 {
        let grown = terms.iter().map(|t| t.share * (1.0 - (-t_s / t.time_s).exp()));
        grown.sum()
    };
    for t_s in [0.1, 1.0, 10.0, 100.0] {
        let decade = crept(10.0 * t_s) - crept(t_s);
        assert!((decade / 0.01 - 1.0).abs() < 0.01, "from {t_s} s: {decade}");
        let third = crept(2.0 * t_s) - crept(t_s);
        assert!((third / 0.01 - 2f64.log10()).abs() < 0.01, "{t_s} s: {third}");
    }
}

#[test]
fn temperature_follows_its_profile_and_coefficients() {
    let mut params = quiet();
    params.temperature_ue_per_k = 1.2;
    params.temperature_c = vec![(0.0, 20.0), (2.0, 30.0), (3.0, 30.0)];
    assert!((params.temperature_at(0.5) - 22.5).abs() < 1e-12);
    assert!((params.temperature_at(9.0) - 30.0).abs() < 1e-12);
    let mut chain = chain(params, 8);
    let coefficients = chain.coefficients_ue_per_k().to_vec();
    assert!(coefficients.iter().all(|c| c.abs() <= 1.2));
    assert!(coefficients.iter().any(|c| c.abs() > 0.2));
    let mut codes = [0; 8];
    for (t_s, warmer_k) in [(0.0, 0.0), (0.5, 2.5), (2.5, 10.0)] {
        chain.sample(t_s, &[0.0; 8], &mut codes);
        for channel in 0..8 {
            let value = f64::from(codes[channel]) * chain.resolution_ue(channel);
            let expected = coefficients[channel] * warmer_k;
            assert!((value - expected).abs() < 1e-5, "{value}, expected {expected}");
        }
    }
}

#[test]
fn a_random_walk_grows_with_the_root_of_time() {
    let mut params = quiet();
    params.walk_ue_per_sqrt_s = 3.0;
    let n = 64;
    let mut chain = LiveElectronics::new(params, 100.0, &vec![1000.0; n]).unwrap();
    let mut codes = vec![0; n];
    let mut at_second: Vec<Vec<f64>> = Vec::new();
    for i in 0..=4000 {
        chain.sample(f64::from(i) / 100.0, &vec![0.0; n], &mut codes);
        if i % 100 == 0 {
            let value = |c: usize| f64::from(codes[c]) * chain.resolution_ue(c);
            at_second.push((0..n).map(value).collect());
        }
    }
    for step in [1, 4] {
        let pairs = (0..40 / step).map(|k| (&at_second[k * step], &at_second[(k + 1) * step]));
        let steps: Vec<f64> =
            pairs.flat_map(|(a, b)| a.iter().zip(b).map(|(a, b)| b - a)).collect();
        let expected = 3.0 * (step as f64).sqrt();
        // 2560 and 640 steps: standard errors 1.4 and 2.8 %.
        let found = sd(&steps);
        assert!((found / expected - 1.0).abs() < 0.09, "{found}, expected {expected}");
    }
}

#[test]
fn dead_and_swapped_channels() {
    let mut params = quiet();
    (params.dead, params.swapped) = (vec![2], vec![(0, 3)]);
    let mut chain = chain(params, 4);
    let mut codes = [0; 4];
    chain.sample(0.0, &[10.0, 20.0, 30.0, 40.0], &mut codes);
    let values: Vec<i64> =
        (0..4).map(|c| (f64::from(codes[c]) * chain.resolution_ue(c)).round() as i64).collect();
    assert_eq!(values, [40, 20, 0, 10]);
}

#[test]
fn a_seed_gives_the_same_codes_again() {
    let run = |seed| {
        let mut params = quiet();
        params.converter = ElectronicsParams { noise_ue: 1.0, seed, ..params.converter };
        (params.offset_ue, params.walk_ue_per_sqrt_s) = (50.0, 1.0);
        readings(&mut chain(params, 3), 10.0, 100)
    };
    assert_eq!(run(1), run(1));
    assert_ne!(run(1), run(2));
}

#[test]
fn values_out_of_range_are_refused() {
    let refused = |change: &dyn Fn(&mut LiveElectronicsParams), name: &str| {
        let mut params = quiet();
        change(&mut params);
        let error = LiveElectronics::new(params, RATE_HZ, &[1000.0]).unwrap_err();
        assert!(error.to_string().contains(name), "{error}");
    };
    refused(&|p| p.walk_ue_per_sqrt_s = -1.0, "walk_ue_per_sqrt_s");
    refused(&|p| p.flicker_ue = f64::NAN, "flicker_ue");
    refused(&|p| p.offset_ue = f64::NAN, "offset_ue");
    refused(&|p| p.dead = vec![1], "dead channel");
    refused(&|p| p.swapped = vec![(0, 1)], "swapped");
    refused(&|p| p.temperature_c = vec![(1.0, 20.0), (1.0, 21.0)], "temperature_c");
    let (share, time_s) = (0.1, 0.0);
    refused(&|p| p.creep = vec![CreepTerm { share, time_s }], "creep.time_s");
}
