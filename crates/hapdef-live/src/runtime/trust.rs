//! Whether what a frame says can be known, and what is known while no frame comes.

use std::time::Duration;

use hapdef_contact::{Touch, TouchPhase, UnknownReason, Verdict, WhyNot};

use crate::estimator::Sight;
use crate::frame::LiveFrame;
use crate::sink::PhaseStatus;

/// What the gauges that count must show wherever it presses, a share of the strongest force expected.
/// The demonstration limb with all its gauges shows a tenth anywhere, without its first six a quarter, without
/// seven two fifths: so a limb that lost half its gauges is believed as far as it can see.
pub const BLIND_SHARE: f64 = 0.25;

/// A force that was beyond the range is within it again when that explains the readings as well as this.
const BACK_P: f64 = 1e-3;

/// Time between two reports while nothing comes.
const REPORT_NS: u64 = 500_000_000;

/// Judges frames and silence.
pub(super) struct Trust {
    stale_after_ns: u64,
    unknown_after_ns: u64,
    /// Host time at which the last usable frame was taken.
    last_ns: u64,
    silence: Silence,
    reported_ns: u64,
    /// For which gauges `smallest_n` was computed; none: anew.
    live: Option<Vec<bool>>,
    smallest_n: Option<f64>,
    /// The last that was explained, and its sample instant.
    good: Touch,
    good_ns: u64,
    /// A force was beyond the range in the last frame.
    is_beyond: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Silence {
    None,
    Stale,
    Unknown,
}

/// What else is known of a frame.
pub(super) struct Signs<'a> {
    pub(super) sight: Option<Sight<'a>>,
    /// Gauges that count `[n_gauges]`; none if all do.
    pub(super) live: Option<&'a [bool]>,
    /// By how much more the readings are uncertain than by their noise, as the zero is not known so well: 1 or more.
    pub(super) blur: f64,
    /// All readings stand still.
    pub(super) is_frozen: bool,
    /// The estimator refused the frame.
    pub(super) is_refused: bool,
}

impl Trust {
    pub(super) fn new(stale_after: Duration, unknown_after: Duration, now_ns: u64) -> Self {
        let ns = |time: Duration| u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
        Self {
            stale_after_ns: ns(stale_after),
            unknown_after_ns: ns(unknown_after),
            last_ns: now_ns,
            silence: Silence::None,
            reported_ns: 0,
            live: None,
            smallest_n: None,
            good: Touch::with_room(),
            good_ns: 0,
            is_beyond: false,
        }
    }

    /// The noise, the device or its gauges are others, or the stream begins anew.
    pub(super) fn start_over(&mut self) {
        (self.live, self.is_beyond) = (None, false);
        self.good.clear();
    }

    /// A usable frame was taken at `now_ns`.
    pub(super) fn hear(&mut self, now_ns: u64) {
        (self.last_ns, self.silence) = (now_ns, Silence::None);
    }

    /// Sets the phase of a frame whose contacts were looked for. A frame that no believed contacts explain
    /// keeps those of the last one that they did, as stale, for as long as a silent stream does.
    pub(super) fn judge(&mut self, frame: &mut LiveFrame, signs: &Signs<'_>) {
        let is_beyond = self.is_beyond(&frame.touch, signs);
        if let Some(quality) = frame.touch.quality.as_mut().filter(|_| is_beyond) {
            quality.verdict = Verdict::NotIdentifiable(WhyNot::Misfit);
        }
        let is_misfit = signs.is_refused
            || frame.touch.quality.is_some_and(|q| q.why_not() == Some(WhyNot::Misfit));
        let is_blurred = self.is_blurred(frame.phase, signs);
        let why = if signs.is_frozen {
            Some(UnknownReason::StreamStalled)
        } else if self.is_blind(signs) {
            Some(UnknownReason::TooFewGauges)
        } else {
            let misfit = (is_misfit || is_beyond).then_some(UnknownReason::Misfit);
            let blurred = is_blurred.then_some(UnknownReason::Drift);
            frame.phase.why_unknown().or(misfit).or(blurred)
        };
        frame.smallest_seen_n = self.smallest_n.map(|n| n * signs.blur);
        frame.is_stale = false;
        if let Some(why) = why {
            frame.phase = TouchPhase::Unknown(why);
        } else {
            if !frame.touch.contacts.is_empty() {
                frame.phase = TouchPhase::Touched;
            }
            self.good.copy_from(&frame.touch);
            self.good_ns = frame.t_host_ns;
        }
        if is_blurred {
            frame.touch.clear();
        }
        if is_beyond || signs.is_refused || signs.is_frozen {
            let is_young = frame.t_host_ns.saturating_sub(self.good_ns) < self.unknown_after_ns;
            frame.touch.contacts.clear();
            if is_young {
                frame.touch.contacts.extend_from_slice(&self.good.contacts);
            }
            frame.is_stale = true;
        }
    }

    /// Whether a force is beyond the range. One near its end is explained by the range's end in some frames and not
    /// in others: once it was beyond, it has to be explained better than by [`BACK_P`].
    fn is_beyond(&mut self, touch: &Touch, signs: &Signs<'_>) -> bool {
        let most_n = signs.sight.map_or(f64::INFINITY, |sight| sight.range_n);
        let strongest_n = touch.contacts.iter().map(|c| c.force_n).fold(0.0, f64::max);
        let is_explained = touch.quality.is_none_or(|quality| quality.p_value >= BACK_P);
        let is_still = self.is_beyond && strongest_n >= most_n && !is_explained;
        self.is_beyond = strongest_n > most_n || is_still;
        self.is_beyond
    }

    /// Whether a contact may have stayed, when one seems to be over, that a zero hides which was not followed while it
    /// lasted.
    fn is_blurred(&self, phase: TouchPhase, signs: &Signs<'_>) -> bool {
        let most_n = signs.sight.map_or(f64::INFINITY, |sight| BLIND_SHARE * sight.range_n);
        phase == TouchPhase::Untouched && self.smallest_n.is_some_and(|n| n * signs.blur > most_n)
    }

    fn is_blind(&mut self, signs: &Signs<'_>) -> bool {
        let Some(sight) = signs.sight else {
            return false;
        };
        let now = signs.live.unwrap_or_default();
        let Some(seen) = sight.seen else {
            return now.contains(&false);
        };
        if self.live.as_deref() != Some(now) {
            self.smallest_n = Some(seen.smallest_n(signs.live));
            let live = self.live.get_or_insert_default();
            live.clear();
            live.extend_from_slice(now);
        }
        self.smallest_n.is_some_and(|n| n > BLIND_SHARE * sight.range_n)
    }

    /// What is to be reported, if anything, at `now_ns` while no frame comes; the last frame's contacts
    /// become stale, then its phase unknown.
    pub(super) fn wait(&mut self, frame: &mut LiveFrame, now_ns: u64) -> Option<PhaseStatus> {
        let silent_ns = now_ns.saturating_sub(self.last_ns);
        let silence = match silent_ns {
            ns if ns >= self.unknown_after_ns => Silence::Unknown,
            ns if ns >= self.stale_after_ns => Silence::Stale,
            _ => Silence::None,
        };
        let is_due = now_ns.saturating_sub(self.reported_ns) >= REPORT_NS;
        if silence <= self.silence && !(is_due && self.silence == Silence::Unknown) {
            return None;
        }
        self.silence = silence;
        self.reported_ns = now_ns;
        frame.is_stale = true;
        if silence == Silence::Unknown {
            frame.phase = TouchPhase::Unknown(UnknownReason::StreamStalled);
            frame.touch.clear();
            self.good.clear();
        }
        Some(PhaseStatus {
            phase: frame.phase,
            is_stale: true,
            n_contacts: frame.touch.contacts.len(),
            silent_s: silent_ns as f64 * 1e-9,
        })
    }
}

#[cfg(test)]
mod tests {
    use hapdef_contact::Contact;
    use nalgebra::Point3;
    use proptest::prelude::*;

    use super::*;

    const MS: u64 = 1_000_000;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(256))]

        /// Frames with pauses of any length between them: whenever nothing has come for the stated
        /// time, neither the phase nor the contacts of the last frame are taken for known.
        #[test]
        fn a_silent_stream_is_never_untouched(pauses in prop::collection::vec(1..900u64, 1..40)) {
            let (stale, unknown) = (Duration::from_millis(100), Duration::from_millis(300));
            let mut trust = Trust::new(stale, unknown, 0);
            let mut frame = LiveFrame::new(3);
            let mut now = 0;
            for (i, pause) in pauses.into_iter().enumerate() {
                trust.hear(now);
                frame.is_stale = false;
                frame.phase = TouchPhase::Touched;
                frame.touch.contacts.clear();
                frame.touch.contacts.push(Contact::new(Point3::origin(), i as f64));
                let mut reports = Vec::new();
                for ms in 0..pause {
                    reports.extend(trust.wait(&mut frame, now + ms * MS));
                    prop_assert_eq!(frame.is_stale, ms >= 100);
                    prop_assert_eq!(frame.known_contacts().is_ok(), ms < 100);
                    let is_unknown = frame.phase.why_unknown() == Some(UnknownReason::StreamStalled);
                    prop_assert_eq!(is_unknown, ms >= 300);
                    prop_assert_eq!(frame.touch.contacts.is_empty(), ms >= 300);
                }
                let n_wanted = [100, 300, 800].iter().filter(|ms| **ms < pause).count();
                prop_assert_eq!(reports.len(), n_wanted);
                now += pause * MS;
            }
        }
    }

    /// One that can't say how sure it is, as the paper's chain: forces beyond the range are no contacts, and without
    /// a gauge that it was trained with nothing is known.
    #[test]
    fn an_estimator_without_doubts_is_bounded_too() {
        let (stale, unknown) = (Duration::from_millis(100), Duration::from_millis(300));
        let mut trust = Trust::new(stale, unknown, 0);
        let mut frame = LiveFrame::new(3);
        let mut judged = |force_n: f64, live: &[bool]| {
            frame.phase = TouchPhase::Touched;
            frame.touch.contacts.clear();
            frame.touch.contacts.push(Contact::new(Point3::origin(), force_n));
            let sight = Some(Sight { seen: None, range_n: 34.0, loads: None });
            let signs =
                Signs { sight, live: Some(live), blur: 1.0, is_frozen: false, is_refused: false };
            trust.judge(&mut frame, &signs);
            let forces_n: Vec<f64> = frame.touch.contacts.iter().map(|c| c.force_n).collect();
            (frame.phase, frame.is_stale, forces_n)
        };
        let (touched, unknown) = (TouchPhase::Touched, TouchPhase::Unknown);
        assert_eq!(judged(33.0, &[true; 3]), (touched, false, vec![33.0]));
        assert_eq!(judged(60.0, &[true; 3]), (unknown(UnknownReason::Misfit), true, vec![33.0]));
        let blind = judged(20.0, &[true, false, true]).0;
        assert_eq!(blind, unknown(UnknownReason::TooFewGauges));
    }
}
