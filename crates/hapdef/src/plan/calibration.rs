//! The step of a calibration that a person plans.

use hapdef_sim::FactorInfo;

use super::elastic::{fine_estimate, limb_estimate};
use super::{Plan, PlanStep, Rates, When};
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::run::Run;
use crate::touch::{CALIBRATION_SITES, N_STIFFNESS, UncertainParams, UncertainResponse};
use crate::work::{Work, WorkKind};

/// Name of the step.
pub(super) const NAME: &str = "hapdef calibrate";

/// Directions in which each gauge is moved for its modes, two ways each: along, across, turned.
const GAUGE_MODES: usize = 3;

/// Power of a solid's nodes with which those of its skin grow as it is refined.
const SKIN_GROWTH: f64 = 2.0 / 3.0;

impl Plan {
    /// The plan with a calibration by `n_presses`: the response and its modes on the limb's mesh, the
    /// response on a finer one where the scene asks for it, and the fit.
    ///
    /// # Errors
    /// As [`super::plan`].
    pub fn with_calibration(
        mut self,
        run: &Run,
        limb: &Limb,
        rates: &Rates,
        n_presses: usize,
    ) -> Result<Self, HapdefError> {
        let n_gauges = limb.gauges.len();
        let n_columns = 1 + GAUGE_MODES + N_STIFFNESS;
        let own = limb_estimate(run, limb)?;
        let refinements = run.scene.estimator.map_refinements();
        let fine = match refinements {
            0 => None,
            times => Some(fine_estimate(run, limb, times)?),
        };
        let params = UncertainParams::of_scene(run, N_STIFFNESS);
        let (solves, why) = match UncertainResponse::is_kept(run, limb, &params)? {
            true => (
                Work::solves(WorkKind::Calibration, &own, 0),
                "the response, which is in the cache, corrected by presses; it takes the response's place",
            ),
            false => (
                solved(&own, fine.as_ref(), limb),
                "the response corrected by presses; it takes the response's place",
            ),
        };
        let work = solves.fitting(n_presses, n_gauges, n_columns, CALIBRATION_SITES);
        let n_kept = n_gauges * (3 * limb.n_surface_nodes() + CALIBRATION_SITES * n_gauges);
        let work = Work { bytes: work.bytes + 8.0 * n_kept as f64, ..work };
        let sizes = [
            ("presses", n_presses),
            ("gauges", n_gauges),
            ("modes", n_columns),
            ("refinements", refinements as usize),
        ];
        let step = PlanStep::runs(NAME, why, &sizes).costing(work, rates);
        let after_design = self.steps.iter().position(|s| s.when == When::Frame);
        let place = after_design.unwrap_or(self.steps.len());
        self.steps.insert(place, step);
        Ok(self)
    }
}

/// The limb's mesh for the modes: the gauges, the gauges moved both ways, the stiffness modes, and the
/// tips of them all; the finer mesh for the gauges, with tips on its own skin.
fn solved(own: &FactorInfo, fine: Option<&FactorInfo>, limb: &Limb) -> Work {
    const KIND: WorkKind = WorkKind::Calibration;
    let (n_gauges, n_nodes) = (limb.gauges.len(), limb.n_surface_nodes());
    let n_moved = (2 * GAUGE_MODES + N_STIFFNESS) * n_gauges;
    let moved = Work::solves(KIND, own, n_moved);
    let work = Work::elastic(KIND, own, n_gauges).with_tips(n_nodes).plus(moved);
    fine.map_or(work, |fine| {
        let nodes_per_own = fine.n_fe_nodes as f64 / own.n_fe_nodes as f64;
        let n_fine_nodes = (n_nodes as f64 * nodes_per_own.powf(SKIN_GROWTH)) as usize;
        work.plus(Work::elastic(KIND, fine, n_gauges).with_tips(n_fine_nodes))
    })
}
