//! One contact: found, or drawn.

use nalgebra::{Point3, Vector3};

use crate::state::Phase;
use crate::uncertainty::Uncertainty;

/// One contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Where on the skin, m.
    pub position_m: Point3<f64>,
    /// Its normal force, N.
    pub force_n: f64,
    /// Its radius, where it is found to be wider than the tip that the estimator expects.
    pub radius: Option<ContactRadius>,
    /// Direction of the force on the limb, unit length, where the estimator knows the skin.
    pub direction: Option<Vector3<f64>>,
    /// Its name, never given twice, where the estimator follows contacts from frame to frame.
    pub id: Option<u64>,
    /// What it does, where the estimator follows contacts.
    pub phase: Option<Phase>,
    /// How sure it is, where that was asked for and the estimator can tell.
    pub uncertainty: Option<Uncertainty>,
}

/// How wide a contact is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactRadius {
    /// Radius of the round tip whose pressure at distance d goes with (1 − (d/r)²)², m.
    pub radius_m: f64,
    /// Its standard deviation, m; none where it is the narrowest or the widest that was tried.
    pub sd_m: Option<f64>,
}

/// A normal force on a surface node, as samples and presses are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawnContact {
    /// The surface node pressed.
    pub node: usize,
    /// Force, N.
    pub force_n: f64,
}

impl DrawnContact {
    /// No force at the first node: what a sample holds before it is drawn.
    pub const NONE: Self = Self { node: 0, force_n: 0.0 };
}

impl Contact {
    /// A contact of which nothing else is known.
    #[must_use]
    pub const fn new(position_m: Point3<f64>, force_n: f64) -> Self {
        Self {
            position_m,
            force_n,
            radius: None,
            direction: None,
            id: None,
            phase: None,
            uncertainty: None,
        }
    }

    /// Unit normal of the skin there, outwards: where the force comes from.
    #[must_use]
    pub fn normal(&self) -> Option<Vector3<f64>> {
        self.direction.map(|direction| -direction)
    }

    /// Its name in 32 bits; `place` in the list where it has none.
    #[must_use]
    pub fn number(&self, place: usize) -> u32 {
        self.id.map_or(place as u32, |id| id as u32)
    }
}
