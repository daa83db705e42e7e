//! What became of a touch.

/// What became of a touch, and what it did to the gains. Readings are in their own unit.
#[derive(Clone, Debug, PartialEq)]
pub struct TouchInfo {
    /// Whether it fits what is known and was used; a refused touch changes nothing.
    pub is_accepted: bool,
    /// χ² of its innovation, with as many degrees of freedom as there are gauges.
    pub chi2: f64,
    /// The χ² beyond which touches are refused.
    pub limit: f64,
    /// Probability of so large a χ².
    pub p_value: f64,
    /// Readings that were expected, by place, force and the gains so far `[n_gauges]`.
    pub expected: Vec<f64>,
    /// What was read beyond that: the innovation `[n_gauges]`.
    pub innovation: Vec<f64>,
    /// Its standard deviation `[n_gauges]`.
    pub innovation_sd: Vec<f64>,
    /// Whether an untouched frame was farther from the zeros than they drift, so that they begin anew with it.
    pub has_new_zeros: bool,
    /// Relative change of each gauge's gain since the calibration, before the touch `[n_gauges]`.
    pub gains_before: Vec<f64>,
    /// The same after it.
    pub gains_after: Vec<f64>,
}

impl TouchInfo {
    /// The gauge whose reading is farthest from what was expected, by its standard deviation.
    #[must_use]
    pub fn worst_gauge(&self) -> usize {
        let off = |&gauge: &usize| (self.innovation[gauge] / self.innovation_sd[gauge]).abs();
        let gauges = 0..self.innovation.len();
        gauges.max_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(0)
    }
}
