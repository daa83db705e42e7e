//! Whether something touches: χ² of the readings with hysteresis.

use crate::chi_square::upper_tail;
use crate::conditioning::params::ConditionerParams;

#[derive(Clone, Debug)]
pub(crate) struct TouchDetector {
    pub(crate) is_touched: bool,
    n_quiet: usize,
}

impl TouchDetector {
    pub(crate) fn new() -> Self {
        Self { is_touched: false, n_quiet: 0 }
    }

    /// Decides by χ² of the frame and of its running mean; says whether that changed anything.
    pub(crate) fn decide(
        &mut self,
        chi2: f64,
        slow_chi2: f64,
        n_dof: usize,
        params: &ConditionerParams,
    ) -> bool {
        let p = upper_tail(chi2, n_dof).min(upper_tail(slow_chi2, n_dof));
        let before = self.is_touched;
        if p < params.touch_p {
            self.is_touched = true;
        }
        self.n_quiet = if p >= params.release_p { self.n_quiet + 1 } else { 0 };
        if self.n_quiet >= params.release_frames {
            self.is_touched = false;
        }
        self.is_touched != before
    }
}
