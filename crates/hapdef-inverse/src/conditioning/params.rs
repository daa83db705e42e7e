//! How gauges drift, and when something touches.

use crate::error::{InverseError, check_length, check_not_negative, check_positive};
use crate::other_loads::OtherLoads;

/// Parameters of a [`crate::Conditioner`]. Readings in one unit throughout.
#[derive(Clone, Debug, PartialEq)]
pub struct ConditionerParams {
    /// Standard deviation of each gauge's noise in a frame `[n_gauges]`, quantisation included.
    pub gauge_sd: Vec<f64>,
    /// Time between frames, s.
    pub period_s: f64,
    /// Frames whose mean is the tare.
    pub tare_frames: usize,
    /// Random walk of a gauge's baseline, per √s.
    pub drift_sd: f64,
    /// Rates up to which zeros are followed, per s: of each gauge in any direction, …
    pub drift_limit: f64,
    /// … of all gauges together, as by their temperature, …
    pub common_drift_limit: f64,
    /// … and of one gauge more than the others, as by its creep. A press that moves the readings no faster is
    /// taken for drift.
    pub single_drift_limit: f64,
    /// Standard deviation of a gauge's temperature coefficient before it is learned, per K; 0 without
    /// a temperature channel.
    pub temperature_sd: f64,
    /// Standard deviation of a gauge's creep before it is learned: part of the reading per unit of
    /// ln(1 + t/τ); 0 for none.
    pub creep_sd: f64,
    /// τ, s.
    pub creep_time_s: f64,
    /// Something touches if readings are less probable than this.
    pub touch_p: f64,
    /// It has gone when they are at least this probable for `release_frames` frames.
    pub release_p: f64,
    /// See `release_p`.
    pub release_frames: usize,
    /// Frames over which readings are averaged for contacts that come slowly.
    pub slow_frames: usize,
    /// Baselines learn from frames this many frames ago, so that the beginning of a contact that is
    /// not yet noticed is not learned.
    pub lag_frames: usize,
    /// Lowest and highest raw value of each gauge's converter `[n_gauges]`; empty for no limits.
    pub rails: Vec<(f64, f64)>,
    /// Whether each gauge's converter has steps larger than the gauge's noise `[n_gauges]`; empty for
    /// none. Such a gauge repeats one value while it is hardly loaded, and is not dead for that.
    pub coarse: Vec<bool>,
    /// A gauge is dead that repeats one value for this many frames while another moves by
    /// `moved_sds` standard deviations of its noise.
    pub stuck_frames: usize,
    /// See `stuck_frames`.
    pub moved_sds: f64,
    /// A gauge spikes that jumps by this many standard deviations while no other gauge moves.
    pub spike_sds: f64,
    /// Frames for which a jump of one gauge alone is held back; longer ones are believed.
    pub spike_frames: usize,
    /// Frames without fault after which a gauge counts again.
    pub recover_frames: usize,
    /// Loads that are no contacts: nothing touches, and no zero drifts, for what they explain.
    pub loads: OtherLoads,
}

impl ConditionerParams {
    /// For frames every `period_s`: 0.02 per √s of drift, no temperature channel, no creep.
    #[must_use]
    pub fn new(gauge_sd: Vec<f64>, period_s: f64) -> Self {
        Self {
            gauge_sd,
            period_s,
            // a fourteenth of one frame's noise
            tare_frames: 200,
            drift_sd: 0.02,
            // a board that is heated by a degree in a second drifts by 1.2 µε/s; with 1.0 noise on top of a drift
            // of 1 µε/s was cut off, and the rest became a contact within a minute
            drift_limit: 1.2,
            common_drift_limit: 3.0,
            single_drift_limit: 3.0,
            temperature_sd: 0.0,
            creep_sd: 0.0,
            creep_time_s: 1.0,
            // one frame in a million touches by noise alone; between the two probabilities nothing changes,
            // so that a contact at the threshold does not come and go with the noise
            touch_p: 1e-6,
            release_p: 1e-3,
            release_frames: 20,
            // contacts a quarter as strong as one frame shows are seen in these, drift taken off …
            slow_frames: 64,
            // … and are not in the baseline yet when they are
            lag_frames: 200,
            rails: Vec::new(),
            coarse: Vec::new(),
            // a gauge that hardly answers repeats values, too: only beside another that clearly moves is
            // it dead
            stuck_frames: 100,
            moved_sds: 20.0,
            // a contact moves several gauges; one that jumps alone for longer is believed, since it may be
            // a press that only it feels
            spike_sds: 12.0,
            spike_frames: 2,
            recover_frames: 100,
            loads: OtherLoads::default(),
        }
    }

    pub(crate) fn check(&self) -> Result<(), InverseError> {
        check_positive("the number of gauges", self.gauge_sd.len() as f64)?;
        for &sd in &self.gauge_sd {
            check_positive("gauge_sd", sd)?;
        }
        check_positive("period_s", self.period_s)?;
        check_positive("tare_frames", self.tare_frames as f64)?;
        check_not_negative("drift_sd", self.drift_sd)?;
        check_not_negative("drift_limit", self.drift_limit)?;
        check_not_negative("common_drift_limit", self.common_drift_limit)?;
        check_not_negative("single_drift_limit", self.single_drift_limit)?;
        check_not_negative("temperature_sd", self.temperature_sd)?;
        check_not_negative("creep_sd", self.creep_sd)?;
        check_positive("creep_time_s", self.creep_time_s)?;
        check_positive("release_frames", self.release_frames as f64)?;
        check_positive("slow_frames", self.slow_frames as f64)?;
        check_positive("stuck_frames", self.stuck_frames as f64)?;
        check_positive("moved_sds", self.moved_sds)?;
        check_positive("spike_sds", self.spike_sds)?;
        for (what, p) in [("touch_p", self.touch_p), ("release_p", self.release_p)] {
            if !(p > 0.0 && p < 1.0) {
                let expected = "a probability between 0 and 1";
                return Err(InverseError::Parameter { what, found: p, expected });
            }
        }
        let n_gauges = self.gauge_sd.len();
        self.loads.check(n_gauges)?;
        for (what, n) in [("rails", self.rails.len()), ("coarse", self.coarse.len())] {
            if n > 0 {
                check_length(what, n_gauges, n)?;
            }
        }
        Ok(())
    }
}
