//! Standardisers: against the two-pass formula, and their own inverse.

use hapdef_data::{DataError, Standardiser, StandardiserFit, StandardiserInfo};
use proptest::prelude::*;

fn fit(width: usize, rows: &[f32]) -> (Standardiser, StandardiserInfo) {
    let mut fit = StandardiserFit::new(width);
    fit.push(rows).unwrap();
    fit.finish().unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn agrees_with_the_two_pass_formula(
        values in prop::collection::vec(-1.0..1.0f32, 2..200),
        offset in -1e3..1e3f32,
        scale in 1e-3..1e3f32,
    ) {
        let column: Vec<f32> = values.iter().map(|v| v * scale + offset).collect();
        let exact = |v: &f32| f64::from(*v);
        let mean = column.iter().map(exact).sum::<f64>() / column.len() as f64;
        let variance = column.iter().map(|v| (exact(v) - mean).powi(2)).sum::<f64>() / column.len() as f64;
        prop_assume!(variance.sqrt() > 1e-6 * mean.abs());
        let (standardiser, info) = fit(1, &column);
        prop_assert!(info.constant_columns.is_empty());
        prop_assert!((f64::from(standardiser.mean[0]) - mean).abs() <= 1e-6 * mean.abs().max(1e-3));
        prop_assert!((f64::from(standardiser.std[0]) / variance.sqrt() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn blocks_do_not_matter_and_the_inverse_undoes(
        rows in prop::collection::vec(-100.0..100.0f32, 3 * 4..3 * 40),
        block in 1..9usize,
    ) {
        let rows = &rows[..rows.len() / 3 * 3];
        let mut in_blocks = StandardiserFit::new(3);
        for part in rows.chunks(3 * block) {
            in_blocks.push(part).unwrap();
        }
        let (standardiser, info) = in_blocks.finish().unwrap();
        prop_assert_eq!((&standardiser, &info), (&fit(3, rows).0, &fit(3, rows).1));
        let mut changed = rows.to_vec();
        standardiser.apply(&mut changed).unwrap();
        let (again, _) = fit(3, &changed);
        for column in 0..3 {
            prop_assert!(again.mean[column].abs() < 1e-4, "{again:?}");
            prop_assert!((again.std[column] - 1.0).abs() < 1e-4, "{again:?}");
        }
        standardiser.invert(&mut changed).unwrap();
        for (back, &raw) in changed.iter().zip(rows) {
            prop_assert!((back - raw).abs() < 1e-4, "{back} against {raw}");
        }
    }
}

#[test]
fn constant_columns_are_reported_and_have_no_say() {
    let (standardiser, info) = fit(3, &[0.0, 7.3, 1.0, 0.0, 7.3, 2.0, 0.0, 7.3, 3.0]);
    assert_eq!(info.constant_columns, [0, 1]);
    assert_eq!(info.n_rows, 3);
    assert_eq!(standardiser.std[..2], [0.0, 0.0]);
    assert_eq!(standardiser.mean, [0.0, 7.3, 2.0]);
    let mut moved = [5.0, -7.3, 2.0];
    standardiser.apply(&mut moved).unwrap();
    assert_eq!(moved, [0.0; 3]);
    let mut back = [0.4, -3.0, 0.0];
    standardiser.invert(&mut back).unwrap();
    assert_eq!(back, [0.0, 7.3, 2.0]);
}

#[test]
fn a_large_offset_costs_no_digits() {
    let rows: Vec<f32> = (0..1000).map(|i| 4096.0 + (i % 2) as f32 * 0.001_953_125).collect();
    let (standardiser, _) = fit(1, &rows);
    assert!((standardiser.std[0] / 0.000_976_562_5 - 1.0).abs() < 1e-6, "{standardiser:?}");
}

#[test]
fn bad_input_is_refused_with_its_place() {
    let mut fit = StandardiserFit::new(2);
    fit.push(&[1.0, 2.0]).unwrap();
    let error = fit.push(&[1.0, 2.0, 3.0, f32::INFINITY]).unwrap_err();
    assert!(matches!(error, DataError::StandardiserInput { row: 2, column: 1, .. }), "{error}");
    assert!(matches!(fit.push(&[1.0; 3]), Err(DataError::StandardiserWidth { width: 2, got: 3 })));
    assert!(matches!(StandardiserFit::new(2).finish(), Err(DataError::StandardiserEmpty { .. })));
    let (standardiser, _) = fit.finish().unwrap();
    assert!(standardiser.apply(&mut [0.0; 3]).is_err());
    let json = serde_json::to_string(&standardiser).unwrap();
    assert_eq!(serde_json::from_str::<Standardiser>(&json).unwrap(), standardiser);
}
