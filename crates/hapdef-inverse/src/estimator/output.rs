//! What is known after a frame, and what is not.

use hapdef_contact::{Contact, ContactRadius, MAX_CONTACTS, Uncertainty, Verdict};
use nalgebra::{Matrix2, Matrix3, Point3, Vector2, Vector3};

use crate::skin::Skin;
use crate::skin_point::SkinPoint;

/// The 95 % region of a place: χ² with two degrees of freedom, −2 ln 0.05.
pub const CHI2_95: f64 = 5.991_464_547_107_979;

/// A contact at a point of the skin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocatedContact {
    /// Where on the skin.
    pub point: SkinPoint,
    /// Where in space, m.
    pub position_m: Point3<f64>,
    /// Its normal force, 0 or more, N.
    pub force_n: f64,
    /// The force on the limb, N.
    pub force_vector_n: Vector3<f64>,
    /// Covariance of (position along tangent 1, along tangent 2, force), m and N; the tangents are
    /// [`crate::Skin::tangents`] at `point`.
    pub covariance: Matrix3<f64>,
    /// Its radius, where it is wider than the map's tip and such contacts were looked for.
    pub radius: Option<ContactRadius>,
}

impl LocatedContact {
    pub(crate) fn new(
        skin: &Skin,
        point: SkinPoint,
        force_n: f64,
        covariance: Matrix3<f64>,
    ) -> Self {
        Self {
            point,
            position_m: skin.position(&point),
            force_n,
            force_vector_n: -skin.normal(&point) * force_n,
            covariance,
            radius: None,
        }
    }

    /// The contact as those have it who don't know `skin`, with its covariance if that is wanted.
    #[must_use]
    pub fn contact(&self, skin: &Skin, with_uncertainty: bool) -> Contact {
        Contact {
            radius: self.radius,
            direction: Some(-skin.normal(&self.point)),
            uncertainty: with_uncertainty.then(|| Uncertainty {
                tangents: skin.tangents(&self.point),
                covariance: self.covariance,
            }),
            ..Contact::new(self.position_m, self.force_n)
        }
    }

    /// Squared distance (Mahalanobis) of the place from `truth`, m, in its own standard deviations, in the
    /// tangent plane of `skin`, `truth` itself being known to `truth_sd_m`; [`CHI2_95`] bounds the 95 %
    /// region. None if the covariance is singular.
    #[must_use]
    pub fn distance_2(&self, skin: &Skin, truth: &Point3<f64>, truth_sd_m: f64) -> Option<f64> {
        let off = truth - self.position_m;
        let off = Vector2::from(skin.tangents(&self.point).map(|t| t.dot(&off)));
        let reported = self.covariance.fixed_view::<2, 2>(0, 0).into_owned();
        let covariance = reported + Matrix2::identity() * truth_sd_m.powi(2);
        Some((off.transpose() * covariance.try_inverse()? * off)[(0, 0)])
    }
}

/// One contact with its force in three directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShearContact {
    /// Where on the skin.
    pub point: SkinPoint,
    /// Where in space, m.
    pub position_m: Point3<f64>,
    /// The force on the limb, N.
    pub force_vector_n: Vector3<f64>,
    /// Covariance of the position along the two tangents, m².
    pub position_covariance_m2: [[f64; 2]; 2],
    /// Covariance of the force, N².
    pub force_covariance_n2: Matrix3<f64>,
}

/// What is known of a contact if it is two, [`crate::EstimatorParams::distinct_m`] to both sides of it and
/// each with half its force: standard deviations, in the direction in which they are largest. Where
/// the response falls off fast, as beside a clamp, one contact reads as two with quite other forces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IfTwo {
    /// Of the sum of both forces, N.
    pub force_sd_n: f64,
    /// Of the place of the one that is known less, m.
    pub position_sd_m: f64,
}

/// Another explanation of the same frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunnerUp {
    pub(crate) n: usize,
    pub(crate) points: [SkinPoint; MAX_CONTACTS],
    pub(crate) forces: [f64; MAX_CONTACTS],
    /// χ² less the best's.
    pub delta_chi2: f64,
    /// −2 ln evidence less the best's; below 0 only for another number of contacts that the
    /// count's margin rejects.
    pub delta_cost: f64,
}

impl RunnerUp {
    /// Its contacts' places.
    #[must_use]
    pub fn points(&self) -> &[SkinPoint] {
        &self.points[..self.n]
    }

    /// Its contacts' normal forces, N.
    #[must_use]
    pub fn forces_n(&self) -> &[f64] {
        &self.forces[..self.n]
    }
}

/// What the search did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EstimateInfo {
    /// Sites and pairs of sites looked at.
    pub n_scanned: usize,
    /// Starts that were refined, at least for a few steps.
    pub n_refined: usize,
    /// Trial steps of all refinements.
    pub n_steps: usize,
    /// The most contacts that were searched for.
    pub most_contacts: usize,
}

/// Contacts found in one frame.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactEstimate {
    /// The contacts of the best explanation, the strongest first.
    pub contacts: Vec<LocatedContact>,
    /// Covariance of all contacts' (tangent 1, tangent 2, force) `[3 n, 3 n]`, m and N, of the
    /// linearised problem: where it says a millimetre or more, its 95 % regions hold less.
    pub joint_covariance: Vec<f64>,
    /// Of each contact, where the live gauges and the parameters leave room for a further one; else empty.
    pub if_two: Vec<IfTwo>,
    /// Other explanations within the margin, the best first.
    pub runner_ups: Vec<RunnerUp>,
    /// What the frame decides.
    pub verdict: Verdict,
    /// rᵀ S⁻¹ r of the best explanation, S the noise with the map's error at its forces.
    pub chi2: f64,
    /// Live gauges less unknowns.
    pub n_dof: usize,
    /// P(χ² of `n_dof` > `chi2`): the quality of the fit; 1 without degrees of freedom.
    pub p_value: f64,
    /// −2 ln evidence, up to what all explanations of a frame share.
    pub cost: f64,
    /// χ² without any contact.
    pub chi2_untouched: f64,
    /// Readings less what the contacts explain `[n_gauges]`, in their unit; 0 for dead gauges.
    pub residual: Vec<f64>,
    /// What the search did.
    pub info: EstimateInfo,
}

impl Default for ContactEstimate {
    fn default() -> Self {
        Self {
            contacts: Vec::new(),
            joint_covariance: Vec::new(),
            if_two: Vec::new(),
            runner_ups: Vec::new(),
            verdict: Verdict::Untouched,
            chi2: 0.0,
            n_dof: 0,
            p_value: 1.0,
            cost: 0.0,
            chi2_untouched: 0.0,
            residual: Vec::new(),
            info: EstimateInfo::default(),
        }
    }
}
