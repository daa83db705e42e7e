//! Two fingers at once: readings add up, and so both can be found.

use anyhow::Result;
use hapdef::touch::{Touch, TouchEstimator};
use nalgebra::Point3;

use super::scene::Placed;

/// Force found, N, and distance from where it is pressed, mm, of a finger with 20 N and one with 8 N.
pub fn two_fingers() -> Result<Vec<(f64, f64)>> {
    let placed = Placed::load()?;
    let (first, mut readings_ue) = placed.press(100, 20.0)?;
    let (second, more_ue) = placed.press(1200, 8.0)?;
    for (sum, more) in readings_ue.iter_mut().zip(more_ue) {
        *sum += more;
    }
    let mut touch = Touch::default();
    placed.estimator()?.estimate(&readings_ue, &mut touch)?;
    let misses = touch.contacts.iter().map(|contact| {
        let miss = |place: Point3<f64>| (contact.position_m - place).norm() * 1e3;
        (contact.force_n, miss(first).min(miss(second)))
    });
    Ok(misses.collect())
}

#[test]
fn both_fingers_are_found_the_stronger_first() {
    let found = two_fingers().unwrap();
    assert_eq!(found.len(), 2, "{found:?}");
    for ((force_n, miss_mm), pressed_n) in found.into_iter().zip([20.0, 8.0]) {
        assert!((force_n - pressed_n).abs() < 0.05, "{force_n} N");
        assert!(miss_mm < 0.05, "{miss_mm} mm");
    }
}
