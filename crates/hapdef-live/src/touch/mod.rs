//! From one frame of readings to contacts: estimators behind one trait, and what they say.

#[cfg(feature = "nets")]
mod hapdefx;
mod kind;
mod settings;
mod superposition;
mod tracking;

use hapdef_inverse::{ContactEstimator, MAX_CONTACTS, Phase, Verdict, WhyNot};
use nalgebra::{Matrix3, Point3, Vector3};

#[cfg(feature = "nets")]
pub use hapdefx::{ChainNets, FoundContact, Hapdefx, HapdefxScratch, PaperChain};
pub use kind::{EstimatorKind, UnknownEstimator};
pub use settings::{SuperpositionSettings, friction_rms};
pub use superposition::Superposition;
pub use tracking::{SearchPlace, Tracking};

use crate::error::LiveError;

/// Other explanations of a frame for which room is made ahead.
const N_ALTERNATIVES: usize = 16;

/// Turns frames of tared gauge readings into contacts. One for each thread.
pub trait TouchEstimator: Send {
    /// Name for people.
    fn name(&self) -> &'static str;

    /// Number of gauges.
    fn n_gauges(&self) -> usize;

    /// The contacts behind a frame, into `touch`: what `frame.wanted` names, whatever was there
    /// before.
    ///
    /// # Errors
    /// [`LiveError`] when the readings have another number, one that counts is not finite, or too
    /// few count.
    fn estimate_frame(
        &mut self,
        frame: &TouchFrame<'_>,
        touch: &mut Touch,
    ) -> Result<(), LiveError>;

    /// The contacts behind `readings_ue` `[n_gauges]`, µε, into `touch`, with all that is known.
    ///
    /// # Errors
    /// As [`TouchEstimator::estimate_frame`].
    fn estimate(&mut self, readings_ue: &[f64], touch: &mut Touch) -> Result<(), LiveError> {
        self.estimate_frame(&TouchFrame::whole(readings_ue), touch)
    }

    /// Forgets what earlier frames said: the stream begins anew.
    fn start_over(&mut self) {}

    /// Sets the time between frames, s, before the first of a device.
    ///
    /// # Errors
    /// [`LiveError`] for a time that can't be used.
    fn set_frame_period(&mut self, _period_s: f64) -> Result<(), LiveError> {
        Ok(())
    }

    /// Sets, for each device and after each tare, how large the noise of each gauge is at least
    /// `[n_gauges]`, µε, the converter's included. An estimator that weighs readings by their noise
    /// takes the larger of this and what it was made with, where they differ by more than 1 %.
    ///
    /// # Errors
    /// [`LiveError`] for a wrong length or noise that can't be used.
    fn set_least_noise(&mut self, _least_ue: &[f64]) -> Result<(), LiveError> {
        Ok(())
    }
}

/// Noise that is larger by less than this share is not worth weighing the readings anew.
const NOISIER_SHARE: f64 = 0.01;

/// `estimator` with the larger of the noise that it was made with and `least_ue`; none if it has
/// that.
fn noisier(
    estimator: &ContactEstimator,
    made_with_ue: &[f64],
    least_ue: &[f64],
) -> Result<Option<ContactEstimator>, LiveError> {
    let (expected, found) = (made_with_ue.len(), least_ue.len());
    if expected != found {
        return Err(LiveError::FrameLength { expected, found });
    }
    let pairs = made_with_ue.iter().zip(least_ue);
    let larger = |(made, least): (&f64, &f64)| match *least > made * (1.0 + NOISIER_SHARE) {
        true => *least,
        false => *made,
    };
    let wanted: Vec<f64> = pairs.map(larger).collect();
    if estimator.gauge_sd() == wanted {
        return Ok(None);
    }
    Ok(Some(estimator.with_gauge_sd(&wanted)?))
}

/// A frame as an estimator gets it.
#[derive(Clone, Copy, Debug)]
pub struct TouchFrame<'a> {
    /// Tared readings `[n_gauges]`, µε.
    pub readings_ue: &'a [f64],
    /// Gauges that count `[n_gauges]`; none if all do.
    pub live: Option<&'a [bool]>,
    /// What is asked for beside the contacts.
    pub wanted: TouchWanted,
}

/// What is asked for beside the contacts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TouchWanted {
    /// [`TouchContact::uncertainty`].
    pub uncertainty: bool,
    /// [`Touch::alternatives`].
    pub alternatives: bool,
}

/// The result of one frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Touch {
    /// The contacts: the strongest first, of an estimator that follows them the oldest first.
    pub contacts: Vec<TouchContact>,
    /// Names of the contacts that were let go in this frame, where the estimator gives names.
    pub released: Vec<u64>,
    /// How good the explanation is, where the estimator can tell.
    pub quality: Option<TouchQuality>,
    /// Other explanations of the frame, the best first, where they were asked for and the estimator
    /// has them.
    pub alternatives: Vec<Alternative>,
}

/// One contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TouchContact {
    /// Where, m.
    pub position_m: Point3<f64>,
    /// Its normal force, N.
    pub force_n: f64,
    /// Direction of the force on the limb, unit length, where the estimator knows the skin.
    pub direction: Option<Vector3<f64>>,
    /// Its name, never given twice, where the estimator follows contacts from frame to frame.
    pub id: Option<u64>,
    /// What it does, where the estimator follows contacts.
    pub phase: Option<Phase>,
    /// How sure it is, where that was asked for and the estimator can tell.
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

/// How good an explanation of a frame is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TouchQuality {
    /// Whether the frame decides for these contacts.
    pub is_identified: bool,
    /// Why not, if it doesn't.
    pub why_not: Option<WhyNot>,
    /// χ² of the residual.
    pub chi2: f64,
    /// Its degrees of freedom.
    pub n_dof: usize,
    /// The probability of a χ² as large.
    pub p_value: f64,
    /// Other explanations that are nearly as good.
    pub n_alternatives: usize,
}

/// Another explanation of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alternative {
    /// −2 ln evidence less the best's.
    pub delta_cost: f64,
    n_contacts: usize,
    positions_m: [Point3<f64>; MAX_CONTACTS],
    forces_n: [f64; MAX_CONTACTS],
}

impl<'a> TouchFrame<'a> {
    /// A frame in which every gauge counts, of which all is wanted.
    #[must_use]
    pub fn whole(readings_ue: &'a [f64]) -> Self {
        Self {
            readings_ue,
            live: None,
            wanted: TouchWanted { uncertainty: true, alternatives: true },
        }
    }

    /// Refuses another number of readings or of gauges that count.
    ///
    /// # Errors
    /// [`LiveError::FrameLength`].
    pub fn check(&self, n_gauges: usize) -> Result<(), LiveError> {
        let lengths = [Some(self.readings_ue.len()), self.live.map(<[bool]>::len)];
        match lengths.into_iter().flatten().find(|&n| n != n_gauges) {
            Some(found) => Err(LiveError::FrameLength { expected: n_gauges, found }),
            None => Ok(()),
        }
    }
}

impl Touch {
    /// Nothing touches; with room for what a frame may hold, so that filling it allocates nothing.
    #[must_use]
    pub fn with_room() -> Self {
        Self {
            contacts: Vec::with_capacity(MAX_CONTACTS),
            released: Vec::with_capacity(MAX_CONTACTS),
            quality: None,
            alternatives: Vec::with_capacity(N_ALTERNATIVES),
        }
    }

    /// Nothing touches, and nothing is known of how sure that is.
    pub fn clear(&mut self) {
        self.contacts.clear();
        self.released.clear();
        self.alternatives.clear();
        self.quality = None;
    }

    /// Takes over what `from` says; allocates only to grow.
    pub fn copy_from(&mut self, from: &Self) {
        self.contacts.clone_from(&from.contacts);
        self.released.clone_from(&from.released);
        self.alternatives.clone_from(&from.alternatives);
        self.quality = from.quality;
    }
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

    /// Covariance of the position in space, m²: T C Tᵀ with the tangents T; singular along the
    /// normal.
    #[must_use]
    pub fn position_covariance_m2(&self) -> Matrix3<f64> {
        let mut sum = Matrix3::zeros();
        for i in 0..2 {
            for j in 0..2 {
                let outer = self.tangents[i] * self.tangents[j].transpose();
                sum += outer * self.covariance[(i, j)];
            }
        }
        sum
    }
}

impl TouchQuality {
    /// What an estimator's `verdict` says.
    #[must_use]
    pub(crate) fn of(verdict: Verdict, chi2: f64, n_dof: usize, p_value: f64) -> Self {
        let why_not = match verdict {
            Verdict::NotIdentifiable(why) => Some(why),
            Verdict::Untouched | Verdict::Identified => None,
        };
        Self { is_identified: why_not.is_none(), why_not, chi2, n_dof, p_value, n_alternatives: 0 }
    }
}

impl Alternative {
    /// An explanation by contacts, (m, N) each; those beyond [`MAX_CONTACTS`] are left out.
    #[must_use]
    pub fn new(delta_cost: f64, contacts: impl IntoIterator<Item = (Point3<f64>, f64)>) -> Self {
        let mut alternative = Self {
            delta_cost,
            n_contacts: 0,
            positions_m: [Point3::origin(); MAX_CONTACTS],
            forces_n: [0.0; MAX_CONTACTS],
        };
        for (i, (position_m, force_n)) in contacts.into_iter().take(MAX_CONTACTS).enumerate() {
            alternative.positions_m[i] = position_m;
            alternative.forces_n[i] = force_n;
            alternative.n_contacts = i + 1;
        }
        alternative
    }

    /// Its contacts: position, m, and normal force, N.
    pub fn contacts(&self) -> impl ExactSizeIterator<Item = (Point3<f64>, f64)> + '_ {
        let places = self.positions_m[..self.n_contacts].iter().copied();
        places.zip(self.forces_n.iter().copied())
    }
}
