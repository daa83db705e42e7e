//! From one frame of readings to contacts: estimators behind one trait.

#[cfg(feature = "nets")]
mod hapdefx;
mod kind;
mod settings;
mod superposition;
mod tracking;

use hapdef_contact::{Contact, Quality, Touch};
use hapdef_inverse::{
    ContactEstimate, ContactEstimator, LocatedContact, OtherLoads, SeenForces, chi_square_tail,
};

#[cfg(feature = "nets")]
pub use hapdefx::{ChainNets, FoundContact, Hapdefx, HapdefxScratch, PaperChain};
pub use kind::{EstimatorKind, UnknownEstimator};
pub use settings::{SuperpositionSettings, friction_rms};
pub use superposition::Superposition;
pub use tracking::{SearchPlace, Tracking};

use crate::error::LiveError;

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

    /// What explains `readings_ue` `[n_gauges]`, µε, on their own: contacts that press, and contacts that
    /// pressed and are gone, by the mirrored readings. None for an estimator that can't tell how well.
    ///
    /// # Errors
    /// As [`TouchEstimator::estimate_frame`].
    fn explain(
        &mut self,
        _readings_ue: &[f64],
        _live: Option<&[bool]>,
    ) -> Result<Option<[Explained; 2]>, LiveError> {
        Ok(None)
    }

    /// The same for a stream, whose frames don't wait: what was found where that is known at once, else none, and
    /// [`TouchEstimator::explained`] has it later. What was begun before is given up.
    ///
    /// # Errors
    /// As [`TouchEstimator::estimate_frame`].
    fn begin_to_explain(
        &mut self,
        readings_ue: &[f64],
        live: Option<&[bool]>,
    ) -> Result<Option<[Explained; 2]>, LiveError> {
        self.explain(readings_ue, live)
    }

    /// What was begun to be explained, once, so many frames later that replays have it in the same one; to be
    /// asked after each frame.
    fn explained(&mut self) -> Option<[Explained; 2]> {
        None
    }

    /// What it can and can't see, where it knows.
    fn sight(&self) -> Option<Sight<'_>> {
        None
    }

    /// Full searches whose outcome came later than it was due: from the first on a replay may differ.
    fn n_late_searches(&self) -> u64 {
        0
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

/// Contacts that explain readings.
#[derive(Clone, Debug, PartialEq)]
pub struct Explained {
    /// The strongest first.
    pub contacts: Vec<Contact>,
    /// The probability of a residual as large by noise and the map's error.
    pub p_value: f64,
    /// −2 ln evidence, up to what all explanations of the same readings, mirrored or not, share.
    pub cost: f64,
}

/// What explains readings by `estimator`, pressing and mirrored.
fn explain(
    estimator: &ContactEstimator,
    readings_ue: &[f64],
    live: Option<&[bool]>,
) -> Result<[Explained; 2], LiveError> {
    let masked = match live.filter(|live| live.contains(&false)) {
        Some(live) => Some(estimator.masked(live)?),
        None => None,
    };
    let estimator = masked.as_ref().unwrap_or(estimator);
    let explained = |sign: f64| -> Result<Explained, LiveError> {
        let signed: Vec<f64> = readings_ue.iter().map(|reading| sign * reading).collect();
        Ok(Explained::of(estimator, &estimator.estimate(&signed)?))
    };
    Ok([explained(1.0)?, explained(-1.0)?])
}

impl Explained {
    fn of(estimator: &ContactEstimator, found: &ContactEstimate) -> Self {
        let skin = estimator.map().skin();
        let contacts = found.contacts.iter().map(|contact| contact.contact(skin, true)).collect();
        Self { contacts, p_value: found.p_value, cost: found.cost }
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

/// What an estimator can see, and what it believes.
#[derive(Clone, Copy, Debug)]
pub struct Sight<'a> {
    /// The smallest forces that show; none where they are known for no set of gauges but all.
    pub seen: Option<&'a SeenForces>,
    /// The strongest force that touches are expected to have, N.
    pub range_n: f64,
    /// Loads that are no contacts; none where it knows of none.
    pub loads: Option<&'a OtherLoads>,
}

/// The strongest force that touches are expected to have, N.
fn range_n(estimator: &ContactEstimator) -> f64 {
    estimator.params().range_n()
}

/// Bounds the forces of `contacts`, as which `found` is reported, by `range_n` where that explains the readings, too:
/// a force at the end of the range is read beyond it by noise and the map's error. To a force A of variance σ², what
/// explains it left free, its bound adds (A − range)²/σ² to χ². Whether it is explained is left to `misfit_p`.
fn bound<'a>(
    contacts: &mut [Contact],
    found: impl Iterator<Item = &'a LocatedContact>,
    quality: &mut Quality,
    range_n: f64,
    misfit_p: f64,
) {
    let beyond = |contact: &Contact| (contact.force_n - range_n).max(0.0);
    let pairs = contacts.iter().zip(found);
    let added: f64 = pairs.map(|(c, found)| beyond(c).powi(2) / found.covariance[(2, 2)]).sum();
    if added > 0.0 {
        quality.chi2 += added;
        quality.p_value = chi_square_tail(quality.chi2, quality.n_dof.max(1));
        if quality.p_value >= misfit_p {
            contacts.iter_mut().for_each(|contact| contact.force_n = contact.force_n.min(range_n));
        }
    }
}

/// What is asked for beside the contacts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TouchWanted {
    /// [`hapdef_contact::Contact::uncertainty`].
    pub uncertainty: bool,
    /// [`Touch::alternatives`].
    pub alternatives: bool,
}

impl<'a> Sight<'a> {
    fn new(seen: &'a SeenForces, estimator: &'a ContactEstimator) -> Self {
        Self { seen: Some(seen), range_n: range_n(estimator), loads: Some(estimator.loads()) }
    }
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
