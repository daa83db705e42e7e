//! What a controller is to do about the strongest contact: nothing, slow down, stop.

use hapdef_contact::{Contact, TouchPhase, UnknownReason};

use crate::error::{LiveError, check_positive};

/// A force above which a stage begins and below which it ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Threshold {
    /// It begins at this force of any contact, N …
    pub on_n: f64,
    /// … and ends when every contact has less than this, N.
    pub off_n: f64,
}

/// The two stages.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlertParams {
    /// From when on a controller is warned.
    pub warn: Threshold,
    /// From when on it has to stop.
    pub stop: Threshold,
    /// Whether readings that no contacts explain stop: something touches, as strongly as it may be.
    pub misfit_stops: bool,
}

/// What a controller is to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AlertLevel {
    /// No contact matters.
    Clear,
    /// One is there.
    Warn,
    /// One is too strong.
    Stop,
    /// It can't be known.
    Unknown,
}

/// Follows both stages from frame to frame.
#[derive(Clone, Debug)]
pub struct Alert {
    params: AlertParams,
    is_warning: bool,
    is_stopping: bool,
}

impl Threshold {
    /// One that ends at half the force at which it begins.
    #[must_use]
    pub fn half_off(on_n: f64) -> Self {
        Self { on_n, off_n: 0.5 * on_n }
    }

    fn is_over(&self, strongest_n: f64, was_over: bool) -> bool {
        strongest_n >= if was_over { self.off_n } else { self.on_n }
    }

    fn check(&self, what: &'static str) -> Result<(), LiveError> {
        check_positive(what, self.on_n)?;
        if self.off_n > 0.0 && self.off_n <= self.on_n {
            return Ok(());
        }
        let expected = "an end above 0 N and not above the force at which it begins";
        Err(LiveError::Parameter { what, found: self.off_n, expected })
    }
}

impl Default for AlertParams {
    /// A warning from 0.5 N on, a stop from 1 N on, which end at half of that. A misfit stops: a press that grows
    /// slowly may be one for tens of milliseconds until its place is found.
    fn default() -> Self {
        let (warn, stop) = (Threshold::half_off(0.5), Threshold::half_off(1.0));
        Self { warn, stop, misfit_stops: true }
    }
}

impl AlertLevel {
    /// Its letter, the first of a line: one byte is enough to act on.
    #[must_use]
    pub const fn letter(self) -> char {
        match self {
            Self::Clear => 'C',
            Self::Warn => 'W',
            Self::Stop => 'S',
            Self::Unknown => 'U',
        }
    }
}

impl Alert {
    /// # Errors
    /// [`LiveError::Parameter`] for a threshold that begins or ends at no force above 0, or ends above where it
    /// begins.
    pub fn new(params: AlertParams) -> Result<Self, LiveError> {
        params.warn.check("warn")?;
        params.stop.check("stop")?;
        Ok(Self { params, is_warning: false, is_stopping: false })
    }

    /// What is to be done after a frame with `contacts`, and the strongest force, N. In one that is not known a stop
    /// begins, and none ends.
    pub fn follow(&mut self, contacts: &[Contact], phase: TouchPhase) -> (AlertLevel, f64) {
        let is_known = phase.is_known();
        let is_misfit = phase == TouchPhase::Unknown(UnknownReason::Misfit);
        let strongest_n = contacts.iter().map(|contact| contact.force_n).fold(0.0, f64::max);
        let is_stopping = self.params.stop.is_over(strongest_n, self.is_stopping);
        self.is_stopping = is_stopping
            || (self.is_stopping && !is_known)
            || (is_misfit && self.params.misfit_stops);
        if is_known {
            self.is_warning = self.params.warn.is_over(strongest_n, self.is_warning);
        }
        let level = match (self.is_stopping, is_known, self.is_warning) {
            (true, ..) => AlertLevel::Stop,
            (false, false, _) => AlertLevel::Unknown,
            (false, true, true) => AlertLevel::Warn,
            (false, true, false) => AlertLevel::Clear,
        };
        (level, strongest_n)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;
    use proptest::prelude::*;

    use super::*;

    const DRIFT: TouchPhase = TouchPhase::Unknown(UnknownReason::Drift);

    fn levels(forces_n: &[Option<f64>]) -> Vec<AlertLevel> {
        let mut alert = Alert::new(AlertParams::default()).unwrap();
        let mut follow = |force_n: &Option<f64>| match force_n {
            Some(force_n) => {
                let contact = Contact::new(Point3::origin(), *force_n);
                alert.follow(&[contact], TouchPhase::Touched).0
            }
            None => alert.follow(&[], DRIFT).0,
        };
        forces_n.iter().map(&mut follow).collect()
    }

    #[test]
    fn a_stage_ends_below_where_it_began() {
        use AlertLevel::{Clear, Stop, Unknown, Warn};
        let forces_n = [0.4, 0.5, 0.3, 0.2, 1.0, 0.6, 0.4, 0.6, 0.1].map(Some);
        let expected = [Clear, Warn, Warn, Clear, Stop, Stop, Warn, Warn, Clear];
        assert_eq!(levels(&forces_n), expected);
        let unknown = [None, Some(2.0), None, Some(0.6), Some(0.1), None];
        assert_eq!(levels(&unknown), [Unknown, Stop, Stop, Stop, Clear, Unknown]);
        let mut alert = Alert::new(AlertParams::default()).unwrap();
        let strong = [Contact::new(Point3::origin(), 1.5)];
        assert_eq!(alert.follow(&strong, DRIFT), (Stop, 1.5));
        assert_eq!(alert.follow(&[], DRIFT), (Stop, 0.0));
        assert_eq!(alert.follow(&[], TouchPhase::Untouched), (Clear, 0.0));
        let misfit = TouchPhase::Unknown(UnknownReason::Misfit);
        assert_eq!(alert.follow(&[], misfit), (Stop, 0.0));
        let params = AlertParams { misfit_stops: false, ..AlertParams::default() };
        assert_eq!(Alert::new(params).unwrap().follow(&[], misfit), (Unknown, 0.0));
    }

    #[test]
    fn thresholds_that_never_end_are_refused() {
        for (on_n, off_n) in [(1.0, 0.0), (1.0, 2.0), (0.0, 0.0), (f64::NAN, 0.5), (1.0, f64::NAN)]
        {
            let stop = Threshold { on_n, off_n };
            let alert = Alert::new(AlertParams { stop, ..AlertParams::default() });
            assert!(alert.is_err(), "{stop:?}");
        }
    }

    proptest! {
        /// A force at or above the threshold always stops, whatever was before.
        #[test]
        fn a_strong_contact_always_stops(before in prop::collection::vec(prop::option::of(0.0..3.0f64), 0..20)) {
            let last = |forces_n: &[Option<f64>]| *levels(forces_n).last().unwrap();
            let mut forces_n = before;
            forces_n.push(Some(1.0));
            prop_assert_eq!(last(&forces_n), AlertLevel::Stop);
            forces_n.push(None);
            prop_assert_eq!(last(&forces_n), AlertLevel::Stop);
            forces_n.push(Some(0.2));
            prop_assert_eq!(last(&forces_n), AlertLevel::Clear);
        }
    }
}
