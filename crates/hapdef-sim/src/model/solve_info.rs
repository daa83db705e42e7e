//! When a solution is refined or refused, and what a solve reached.

use crate::SimError;

/// When a solution is refined, and when it is refused.
///
/// The measure is the backward error of the Jacobi-scaled system K̂ û = b̂,
/// η = ‖b̂ − K̂ û‖∞ / (‖K̂‖∞ ‖û‖∞ + ‖b̂‖∞): the size of the change to K̂ and b̂ that would make û exact
/// (Rigal and Gaches, J. ACM 14, 1967). The plain residual ‖b − K u‖ / ‖b‖ can't fall below
/// ‖K‖ ‖u‖ / ‖b‖ roundings, which on a soft limb is 1e-9, however good the solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveParams {
    /// A backward error above this asks for a refinement step.
    pub refine_above: f64,
    /// Refinement steps at most.
    pub max_refinements: usize,
    /// A backward error above this after refinement is an error.
    pub fail_above: f64,
    /// Above this condition number residuals are taken in twice the precision, and every solution
    /// is refined.
    pub extend_above_condition: f64,
    /// A bound on the forward error ([`SolveInfo::forward_error_bound`]) above this is an error.
    /// By default 1, where no digit is certain; errors are mostly 100 to 1000 times below the bound.
    pub max_forward_error: f64,
}

impl Default for SolveParams {
    fn default() -> Self {
        Self {
            refine_above: 1e-14,
            max_refinements: 2,
            fail_above: 1e-11,
            extend_above_condition: 1e9,
            max_forward_error: 1.0,
        }
    }
}

/// What a solve took and reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveInfo {
    /// Right-hand sides solved.
    pub n_loads: usize,
    /// Those of them that were solved in full, with their residual taken: all, unless
    /// [`crate::Residuals::Sampled`] asked for less and got it.
    pub n_residuals: usize,
    /// The largest relative residual ‖b − K u‖₂ / ‖b‖₂ over those, after refinement.
    pub worst_relative_residual: f64,
    /// The largest backward error (see [`SolveParams`]) over those, after refinement.
    pub worst_backward_error: f64,
    /// The load with the largest backward error.
    pub worst_load: usize,
    /// The estimated condition number of the Jacobi-scaled stiffness; none without loads.
    pub condition: Option<f64>,
    /// The rounding of the stiffness itself, as a share of ‖K̂‖∞: that of one number, and the largest
    /// force that a rigid motion of an element leaves in it, which would be 0 without rounding.
    pub stiffness_rounding: f64,
    /// The most refinement steps that a block of right-hand sides asked for.
    pub n_refinements: usize,
    /// The most iterations that a right-hand side took; 0 on the direct path.
    pub n_iterations: usize,
    /// The largest estimated relative error in energy (see [`crate::IterativeParams`]); 0 on the
    /// direct path, which makes no estimate.
    pub worst_energy_error: f64,
    /// The largest reciprocity error (see [`crate::Residuals::Sampled`]) over the other right-hand
    /// sides; 0 where there are none.
    pub worst_reciprocity_error: f64,
    /// The share of the entries of L that the forward substitution reads, a mean over right-hand
    /// sides; 0 on the iterative path.
    pub forward_factor_share: f64,
    /// The same of the backward substitution.
    pub backward_factor_share: f64,
    /// Seconds.
    pub elapsed_s: f64,
}

impl SolveInfo {
    /// A bound on the relative error of any displacement field whose residual was taken, in the norm
    /// of the Jacobi-scaled system (for the others see [`crate::Residuals::Sampled`]): κ (η + ε), with the condition number κ, the backward error η, and the rounding ε of
    /// the stiffness itself ([`Self::stiffness_rounding`]; N. J. Higham, Accuracy and Stability of Numerical
    /// Algorithms, 2nd ed., section 7.1). 0 without loads.
    #[must_use]
    pub fn forward_error_bound(&self) -> f64 {
        self.condition.map_or(0.0, |condition| {
            condition * (self.worst_backward_error + self.stiffness_rounding)
        })
    }

    /// Nothing reached yet.
    pub(crate) fn new(n_loads: usize) -> Self {
        Self {
            n_loads,
            n_residuals: n_loads,
            worst_relative_residual: 0.0,
            worst_backward_error: 0.0,
            worst_load: 0,
            condition: None,
            stiffness_rounding: 0.0,
            n_refinements: 0,
            n_iterations: 0,
            worst_energy_error: 0.0,
            worst_reciprocity_error: 0.0,
            forward_factor_share: 0.0,
            backward_factor_share: 0.0,
            elapsed_s: 0.0,
        }
    }
}

/// Refuses what may be off by more than allowed.
pub(crate) fn check_forward_error(info: &SolveInfo, params: &SolveParams) -> Result<(), SimError> {
    let (bound, condition) = (info.forward_error_bound(), info.condition);
    if info.n_loads == 0 || bound <= params.max_forward_error {
        return Ok(());
    }
    Err(SimError::IllConditioned {
        condition: condition.unwrap_or(f64::NAN),
        backward_error: info.worst_backward_error,
        bound,
        limit: params.max_forward_error,
    })
}
