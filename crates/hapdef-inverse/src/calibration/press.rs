//! One press of known place and force.

use nalgebra::Point3;

use crate::error::InverseError;
use crate::skin::Skin;
use crate::skin_point::SkinPoint;

/// A press against the skin's normal, and what the gauges read.
#[derive(Clone, Debug, PartialEq)]
pub struct Press {
    /// Where on the skin.
    pub point: SkinPoint,
    /// Normal force, above 0, N.
    pub force_n: f64,
    /// Tared readings `[n_gauges]`, in the unit of the map.
    pub readings: Vec<f64>,
}

impl Press {
    /// The press at the point of `skin` nearest to `position_m`.
    ///
    /// # Errors
    /// [`InverseError::PressOffSkin`] farther than `max_distance_m` from the skin;
    /// [`InverseError::NotFinite`].
    pub fn at_position(
        skin: &Skin,
        position_m: &Point3<f64>,
        max_distance_m: f64,
        force_n: f64,
        readings: Vec<f64>,
    ) -> Result<Self, InverseError> {
        let (point, distance_m) = skin.nearest(position_m)?;
        if distance_m > max_distance_m {
            return Err(InverseError::PressOffSkin {
                position_m: [position_m.x, position_m.y, position_m.z],
                distance_m,
                max_distance_m,
            });
        }
        Ok(Self { point, force_n, readings })
    }
}
