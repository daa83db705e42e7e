//! From one frame of readings to contacts: the estimators behind one trait, and what a layout of
//! gauges can tell.

mod calibration;
mod chosen;
mod fine;
mod layout;
mod layout_choice;
mod limits;
mod modes;
mod paper_chain;
mod response;
mod superposition;

use nalgebra::{Matrix3, Point3, Vector3};

pub use calibration::{Calibration, PressQuality};
pub use chosen::touch_estimator;
pub(crate) use chosen::{ChainStages, chain_stages};
pub use layout::{
    CountedLayout, LayoutParams, LayoutStudy, PlacedGauge, ScoredLayout, study_layouts,
};
pub use limits::{LimitsReport, LimitsRequest, limits};
pub use modes::{UncertainParams, UncertainResponse};
pub use paper_chain::PaperChain;
pub use response::{gauge_map, response_map};
pub use superposition::{Superposition, estimator_params, superposition};

use crate::error::HapdefError;

/// Turns frames of tared gauge readings into contacts. One for each thread.
pub trait TouchEstimator {
    /// Name for people.
    fn name(&self) -> &'static str;

    /// Number of gauges.
    fn n_gauges(&self) -> usize;

    /// The contacts behind `readings_ue` `[n_gauges]`, µε, into `touch`.
    ///
    /// # Errors
    /// [`HapdefError`] when the readings have another number or one is not finite.
    fn estimate(&mut self, readings_ue: &[f64], touch: &mut Touch) -> Result<(), HapdefError>;
}

/// What one frame tells.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Touch {
    /// The contacts, the strongest first.
    pub contacts: Vec<TouchContact>,
    /// How good the explanation is, where the estimator can tell.
    pub quality: Option<TouchQuality>,
}

/// One contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TouchContact {
    /// Where, m.
    pub position_m: Point3<f64>,
    /// Its normal force, N.
    pub force_n: f64,
    /// How sure it is, where the estimator can tell.
    pub uncertainty: Option<TouchUncertainty>,
}

/// Covariance of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TouchUncertainty {
    /// Two unit tangents of the skin, at right angles.
    pub tangents: [Vector3<f64>; 2],
    /// Covariance of (position along tangent 1, along tangent 2, force), m and N.
    pub covariance: Matrix3<f64>,
}

impl TouchUncertainty {
    /// √(σ₁² + σ₂²) of the position, m.
    #[must_use]
    pub fn position_sd_m(&self) -> f64 {
        (self.covariance[(0, 0)] + self.covariance[(1, 1)]).sqrt()
    }

    /// Standard deviation of the force, N.
    #[must_use]
    pub fn force_sd_n(&self) -> f64 {
        self.covariance[(2, 2)].sqrt()
    }
}

/// How good an explanation of a frame is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TouchQuality {
    /// Whether the frame decides for these contacts.
    pub is_identified: bool,
    /// χ² of the residual.
    pub chi2: f64,
    /// Its degrees of freedom.
    pub n_dof: usize,
    /// The probability of a χ² as large.
    pub p_value: f64,
    /// Other explanations that are nearly as good.
    pub n_alternatives: usize,
}
