//! Parameters of the tracker.

use crate::effort::Effort;
use crate::error::{InverseError, check_not_negative, check_positive};
use crate::estimator::MAX_CONTACTS;

/// How contacts are followed from frame to frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackerParams {
    /// Frames over which forces are averaged at most while they are steady, for what is reported; a
    /// force that changes by more than its noise starts anew. 1 for none.
    pub force_frames: usize,
    /// Contacts held at most. One that arrives needs two channels for its place and every contact
    /// one for its force, so that fewer are held where gauges are few.
    pub max_contacts: usize,
    /// Time between frames, s.
    pub frame_period_s: f64,
    /// Frames averaged for one update of the held contacts' places and map errors.
    pub block_frames: usize,
    /// A frame whose residual is less probable than this opens a detection window: has a contact come, or
    /// one slid?
    pub alarm_p: f64,
    /// Frames since the alarm after which a detection window first decides; it looks again after twice, four
    /// and eight times as many, and then drops the alarm.
    pub detection_frames: usize,
    /// What a new contact or a slide has to improve −2 ln evidence by.
    pub birth_margin: f64,
    /// A contact that has come is held when its force is steady, and at the latest after so many
    /// frames.
    pub settle_frames: usize,
    /// With a residual less probable than this one contact does not explain an arrival, and pairs
    /// are looked for.
    pub pair_p: f64,
    /// A contact with less force than this is let go, N, or with less than three standard
    /// deviations …
    pub release_force_n: f64,
    /// … for so many frames; a frame with more force takes two of them back.
    pub release_frames: usize,
    /// How fast contacts slide, standard deviation, m/s.
    pub slide_m_per_s: f64,
    /// Held contacts are not believed to stay where they are better than this, m/√s.
    pub drift_m_per_sqrt_s: f64,
    /// No contact comes nearer than this to another, m.
    pub min_gap_m: f64,
    /// Explanations kept side by side at most, the best included.
    pub n_hypotheses: usize,
    /// Explanations worse than the best by more than this in −2 ln evidence are dropped.
    pub hypothesis_delta: f64,
    /// Work in one frame at most: a trial step of a refinement counts one for each contact that moves,
    /// a row of a pair scan one, a scan of the sites eight. What is left over waits for the next frame.
    pub steps_per_frame: usize,
    /// Frames in a row that no hypothesis explains after which a full search is wanted.
    pub search_frames: usize,
    /// A residual less probable than this is a misfit.
    pub misfit_p: f64,
}

impl Default for TrackerParams {
    /// [`Effort::Usual`].
    fn default() -> Self {
        Self::of(Effort::Usual)
    }
}

impl TrackerParams {
    /// For 1,000 frames a second: the usual parameters, with the work of a frame and the hypotheses
    /// that are kept as the effort says.
    #[must_use]
    pub fn of(effort: Effort) -> Self {
        // With 45 steps hardly any pair is found beside two held contacts, with 60 half of them, with 100
        // two thirds; beyond 200 there is no gain (`docs/contacts.md`, `no_setting_beyond_the_efforts_is_better`).
        let (steps_per_frame, n_hypotheses) = match effort {
            Effort::Fast => (60, 2),
            Effort::Usual => (100, 4),
            Effort::Thorough => (200, 8),
        };
        Self {
            // a quarter of one frame's noise
            force_frames: 16,
            max_contacts: 4,
            frame_period_s: 1e-3,
            block_frames: 8,
            // noise alone opens a window every 100 s
            alarm_p: 1e-5,
            // decisions after 3, 6, 12 and 24 frames, each on half the noise variance of the one before
            detection_frames: 3,
            // odds of e⁶ = 400 to 1 beyond what a place and a force cost as unknowns: each alarm is decided
            // up to four times, with three places for each hypothesis and every slide as candidates, and a
            // contact that is none stays until it is weak
            birth_margin: 12.0,
            // a force that is never steady must not keep places from sharpening
            settle_frames: 120,
            // milder than an alarm: it only starts a search, whose pairs have to win by `birth_margin`
            pair_p: 1e-4,
            // Beside a press whose noise is twice what was assumed ghosts come, the fewer the more force is
            // asked (`what_is_too_weak_to_be_held_is_not_born`).
            release_force_n: 0.3,
            // 8 ms with hardly any force
            release_frames: 8,
            slide_m_per_s: 0.1,
            drift_m_per_sqrt_s: 1e-4,
            min_gap_m: 0.006,
            n_hypotheses,
            // odds of e⁸ = 3,000 to 1: what a few frames make that unlikely, later ones don't bring back
            hypothesis_delta: 16.0,
            steps_per_frame,
            // a detection window has made all its decisions by then. Of the frames of twice 32 random scripts 1.66 and
            // 1.30 % were misfits; with 12 1.93 and 1.42, with 64 1.82 and 1.50 % (hapdef's example scripts,
            // seeds 0 and 2).
            search_frames: 24,
            // one frame in a million is a misfit by noise alone
            misfit_p: 1e-6,
        }
    }

    pub(crate) fn check(&self) -> Result<(), InverseError> {
        let (found, most) = (self.max_contacts, MAX_CONTACTS);
        if found == 0 || found > most {
            return Err(InverseError::TooManyContacts { found, most });
        }
        for (what, found) in [
            ("frame_period_s", self.frame_period_s),
            ("force_frames", self.force_frames as f64),
            ("block_frames", self.block_frames as f64),
            ("detection_frames", self.detection_frames as f64),
            ("settle_frames", self.settle_frames as f64),
            ("release_frames", self.release_frames as f64),
            ("slide_m_per_s", self.slide_m_per_s),
            ("n_hypotheses", self.n_hypotheses as f64),
            ("steps_per_frame", self.steps_per_frame as f64),
            ("search_frames", self.search_frames as f64),
        ] {
            check_positive(what, found)?;
        }
        for (what, found) in [
            ("birth_margin", self.birth_margin),
            ("release_force_n", self.release_force_n),
            ("drift_m_per_sqrt_s", self.drift_m_per_sqrt_s),
            ("min_gap_m", self.min_gap_m),
            ("hypothesis_delta", self.hypothesis_delta),
        ] {
            check_not_negative(what, found)?;
        }
        for (what, found) in
            [("alarm_p", self.alarm_p), ("pair_p", self.pair_p), ("misfit_p", self.misfit_p)]
        {
            if !(0.0..=1.0).contains(&found) {
                let expected = "a probability, 0 to 1";
                return Err(InverseError::Parameter { what, found, expected });
            }
        }
        Ok(())
    }
}
