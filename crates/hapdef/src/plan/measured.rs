//! What a plan by superposition expected beside what it comes to.

use std::time::Instant;

use hapdef_inverse::{ContactEstimator, ScanSites};
use serde::Serialize;
use serde_json::json;

use super::frames::{DrawnFrame, FrameDraws, N_FRAMES, Searched, followed_s, searched};
use super::{Plan, StepState, calibration, superposition as steps};
use crate::cache::StageRecord;
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::run::Run;
use crate::touch::{
    CALIBRATION_SITES, Calibration, N_STIFFNESS, PressQuality, UncertainParams, UncertainResponse,
    response_map, superposition,
};

/// A step as it was expected and as it went.
#[derive(Clone, Debug, Serialize)]
pub struct MeasuredStep {
    /// Name of the step.
    pub step: &'static str,
    /// The same in one word, for a metric.
    pub word: &'static str,
    /// Expected time, s.
    pub predicted_s: f64,
    /// Time it took, s; of a frame the mean over many that ended with that step.
    pub measured_s: f64,
}

impl MeasuredStep {
    /// The larger of both times over the smaller.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        let ratio = self.predicted_s / self.measured_s;
        ratio.max(ratio.recip())
    }
}

impl Plan {
    /// Solves the response, calibrates with `n_presses` where the plan has a calibration
    /// ([`Plan::with_calibration`]), and searches and follows contacts, all by superposition with the
    /// scene's parameters, whatever the cache or a calibration has. What was measured is kept beside the
    /// run's results, for the next plan.
    ///
    /// # Errors
    /// What the first step that fails returns.
    pub fn measured(
        &self,
        run: &Run,
        limb: &Limb,
        n_presses: usize,
    ) -> Result<Vec<MeasuredStep>, HapdefError> {
        let spec = run.scene.estimator.superposition();
        let start = Instant::now();
        let map = response_map(limb, run.scene.contact.tip_radius_m, run.threads)?;
        let response_s = start.elapsed().as_secs_f64();
        let sites = ScanSites::farthest(map.skin(), spec.n_sites)?;
        let mut draws = FrameDraws::new(&map, &sites, spec.noise_ue);
        let estimator = superposition(&run.scene, &spec, map.clone())?.into_estimator();
        let mut taken = vec![(steps::RESPONSE, "response", response_s)];
        taken.extend(frames_s(&mut draws, &estimator)?);
        if self.step(calibration::NAME).is_some() {
            let fit_s = calibration_s(run, limb, &mut draws, n_presses)?;
            taken.push((calibration::NAME, "calibration", fit_s));
        }
        let mut measured = Vec::new();
        for (step, word, measured_s) in taken {
            let planned = self.step(step).filter(|s| s.state == StepState::Runs);
            let Some((work, predicted_s)) = planned.and_then(|s| s.work.zip(s.predicted_s)) else {
                continue;
            };
            run.cache.keep(&StageRecord {
                stage: format!("measured-{word}"),
                inputs: json!({ "scene": run.scene.name }),
                info: json!({ "work": work.done(run.threads) }),
                elapsed_s: measured_s,
            })?;
            measured.push(MeasuredStep { step, word, predicted_s, measured_s });
        }
        Ok(measured)
    }
}

fn frames_s(
    draws: &mut FrameDraws<'_>,
    estimator: &ContactEstimator,
) -> Result<[(&'static str, &'static str, f64); 4], HapdefError> {
    let [none, singles, pairs] = [0, 1, 2].map(|n| draws.frames(n, N_FRAMES[n]));
    let mean_s = |frames: &[DrawnFrame], n_contacts| -> Result<f64, HapdefError> {
        Ok(Searched::mean_of(&searched(estimator, frames)?, n_contacts).seconds)
    };
    let (test_s, single_s) = (mean_s(&none, 0)?, mean_s(&singles, 1)?);
    let pair_s = mean_s(&pairs, 2)?;
    Ok([
        (steps::TEST, "test", test_s),
        (steps::SINGLE, "single", single_s - test_s),
        (steps::PAIRS, "pair", pair_s - test_s),
        (steps::FOLLOWED, "followed", followed_s(estimator, &singles[0])?),
    ])
}

fn calibration_s(
    run: &Run,
    limb: &Limb,
    draws: &mut FrameDraws<'_>,
    n_presses: usize,
) -> Result<f64, HapdefError> {
    let quality = PressQuality { noise_ue: draws.noise_ue, position_sd_m: 0.0, force_sd_n: 0.0 };
    let presses = draws.presses(n_presses);
    let params = UncertainParams::of_scene(run, N_STIFFNESS);
    let start = Instant::now();
    let response = UncertainResponse::solve(limb, &limb.sites, &limb.gauges, &params)?;
    Calibration::of_response(run, limb, &response, &presses, &quality, CALIBRATION_SITES)?;
    Ok(start.elapsed().as_secs_f64())
}
