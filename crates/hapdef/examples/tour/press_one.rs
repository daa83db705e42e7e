//! One press: from a scene file to a contact.

use anyhow::{Context, Result};
use hapdef::touch::{Touch, TouchEstimator};

use super::scene::Placed;

/// A press as the gauges see it, and what is found behind their readings.
pub struct Pressed {
    pub readings_ue: Vec<f64>,
    pub force_n: f64,
    pub miss_mm: f64,
}

/// Presses with 20 N and looks for it.
pub fn press_one() -> Result<Pressed> {
    let placed = Placed::load()?;
    let (place, readings_ue) = placed.press(700, 20.0)?;
    let mut touch = Touch::default();
    placed.estimator()?.estimate(&readings_ue, &mut touch)?;
    let found = touch.contacts.first().context("nothing was found")?;
    Ok(Pressed {
        force_n: found.force_n,
        miss_mm: (found.position_m - place).norm() * 1e3,
        readings_ue,
    })
}

#[test]
fn the_press_is_found_where_it_is() {
    let pressed = press_one().unwrap();
    // Readings come from the map itself: what is left is the estimator's prior on forces.
    assert!((pressed.force_n - 20.0).abs() < 0.02, "{}", pressed.force_n);
    assert!(pressed.miss_mm < 0.01, "{} mm", pressed.miss_mm);
    let largest = pressed.readings_ue.iter().fold(0.0_f64, |m, r| m.max(r.abs()));
    // As it was when this was written.
    assert!((largest / 619.05 - 1.0).abs() < 1e-3, "{largest} µε");
}
