//! What a page can ask for.

use crate::error::ViewError;

/// What the page can ask for; a button shows only where it does something.
#[derive(Clone, Debug, Default)]
pub struct Offers {
    /// Gauges can be tared.
    pub tare: bool,
    /// Recording can be turned on and off.
    pub record: bool,
    /// A virtual limb can be pressed.
    pub press: Option<PressOffer>,
}

/// Presses of a virtual limb.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PressOffer {
    /// Force at first, N.
    pub default_n: f64,
    /// Largest force, N.
    pub max_n: f64,
}

impl Offers {
    /// Refuses a press without a force.
    pub(crate) fn check(&self) -> Result<(), ViewError> {
        match self.press {
            Some(press)
                if !(press.default_n > 0.0
                    && press.default_n <= press.max_n
                    && press.max_n.is_finite()) =>
            {
                Err(ViewError::BadPressOffer { default_n: press.default_n, max_n: press.max_n })
            }
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Offers, PressOffer};

    #[test]
    fn a_press_needs_a_force() {
        for (default_n, max_n) in [(0.0, 1.0), (2.0, 1.0), (1.0, f64::INFINITY), (f64::NAN, 1.0)] {
            let offers =
                Offers { press: Some(PressOffer { default_n, max_n }), ..Offers::default() };
            assert!(offers.check().is_err(), "{default_n} {max_n}");
        }
    }
}
