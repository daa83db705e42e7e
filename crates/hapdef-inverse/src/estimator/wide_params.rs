//! How wide contacts are looked for.

use crate::error::{InverseError, check_not_negative, check_positive};

/// From one radius to the next, between which maps are mixed.
const STEP: f64 = 4.0 / 3.0;

/// The radius from which they rise where the map's tip is narrower, m: below, a wider tip reads as a narrow one.
const LEAST_M: f64 = 3e-3;

/// How wide contacts are looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WideParams {
    /// Radius of the tip that is in the map, m.
    pub tip_radius_m: f64,
    /// The widest radius that is looked for, m.
    pub widest_m: f64,
}

impl WideParams {
    /// Contacts up to `widest_m`, where that is wider than the map's tip.
    #[must_use]
    pub fn up_to(widest_m: f64, tip_radius_m: f64) -> Option<Self> {
        (widest_m > tip_radius_m).then_some(Self { tip_radius_m, widest_m })
    }

    pub(crate) fn check(&self) -> Result<(), InverseError> {
        check_not_negative("wide.tip_radius_m", self.tip_radius_m)?;
        check_positive("wide.widest_m less wide.tip_radius_m", self.widest_m - self.tip_radius_m)
    }

    /// Three or more, rising, the last two beyond the widest: the best of them is mixed with those on both sides.
    pub(crate) fn radii_m(&self) -> Vec<f64> {
        let first_m = self.tip_radius_m.max(LEAST_M) * STEP;
        let mut radii_m = vec![first_m, first_m * STEP, first_m * STEP.powi(2)];
        while radii_m[radii_m.len() - 2] < self.widest_m {
            radii_m.push(radii_m[radii_m.len() - 1] * STEP);
        }
        radii_m
    }
}

#[cfg(test)]
mod tests {
    use super::WideParams;

    #[test]
    fn radii_rise_to_two_beyond_the_widest() {
        let radii_m = WideParams { tip_radius_m: 2e-3, widest_m: 0.02 }.radii_m();
        assert!(radii_m.is_sorted() && radii_m[0] > 2e-3);
        let n_beyond = radii_m.iter().filter(|radius_m| **radius_m >= 0.02).count();
        assert_eq!(n_beyond, 2, "{radii_m:?}");
        assert!(WideParams { tip_radius_m: 2e-3, widest_m: 2e-3 }.check().is_err());
    }
}
