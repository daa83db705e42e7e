//! How fast this machine is at finding contacts, measured once with the estimator itself.

use std::sync::Arc;
use std::time::Instant;

use hapdef_inverse::{
    Calibrated, CalibrationParams, ContactEstimator, EstimatorParams, InverseError, ModelError,
    NoiseParams, ScanSites, Skin, TipMeans,
};
use serde::{Deserialize, Serialize};

use super::barrel::{N_GAUGES, barrel};
use super::cost::{fit_flops, follow_flops, pairs_flops, refine_flops, scan_flops, test_flops};
use super::frames::{DrawnFrame, FrameDraws, Searched, followed_s, searched};
use crate::scene::SuperpositionSpec;

/// Frames that are timed: untouched, of one contact, of two.
pub(super) const N_FRAMES: [usize; 3] = [2000, 60, 60];

/// Presses of the calibration that is timed.
const N_PRESSES: usize = 150;

/// Radius of the tip that is timed, m.
const TIP_M: f64 = 2e-3;

/// Part of a search that a scan counts for at least.
const LEAST_SCAN: f64 = 0.02;

/// Part of a search that its steps count for at least.
const LEAST_STEP: f64 = 1e-3;

/// Rates of a frame's inner loops on one thread, and the steps that searches take.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct FrameRates {
    /// Operations of the χ² test, 1/s.
    pub test_flops_per_s: f64,
    /// Operations of the scan for one contact, 1/s.
    pub scan_flops_per_s: f64,
    /// Operations of the scan of pairs, 1/s.
    pub pairs_flops_per_s: f64,
    /// Operations of the refinement of one contact, 1/s.
    pub single_flops_per_s: f64,
    /// Operations of the refinement of two, 1/s.
    pub pair_flops_per_s: f64,
    /// Steps of refinement behind one contact, the mean.
    pub single_steps: f64,
    /// Steps behind two contacts, those of the search for one before it included.
    pub pair_steps: f64,
    /// Operations of a frame in which a contact is followed, 1/s.
    pub follow_flops_per_s: f64,
    /// Operations of a calibration's fit on all threads, 1/s.
    pub fit_flops_per_s: f64,
    /// Nodes of a skin of which it is found what a tip there averages over, 1/s.
    pub tips_per_s: f64,
}

impl FrameRates {
    /// Measures with what a scene says by default: sites, noise, the map's error.
    pub(super) fn measure(threads: usize) -> Result<Self, InverseError> {
        let spec = SuperpositionSpec::default();
        let map = Arc::new(barrel()?);
        let sites = Arc::new(ScanSites::farthest(map.skin(), spec.n_sites)?);
        let noise = NoiseParams {
            model_error: ModelError { relative: spec.map_error, ..ModelError::default() },
            ..NoiseParams::uniform(N_GAUGES, spec.noise_ue)
        };
        let with =
            |params| ContactEstimator::new(map.clone(), sites.clone(), noise.clone(), params);
        let estimator = with(EstimatorParams::default())?;
        let short = with(EstimatorParams { max_steps: 1, ..EstimatorParams::default() })?;
        let mut draws = FrameDraws::new(&map, &sites, spec.noise_ue);
        let [none, singles, pairs] = [0, 1, 2].map(|n| draws.frames(n, N_FRAMES[n]));
        let test = Searched::mean_of(&searched(&estimator, &none)?, 0);
        let step_s = step_s(&estimator, &short, &pairs)?;
        let single = Refined::measure(&estimator, (&singles, 1), test, step_s)?;
        let pair = Refined::measure(&estimator, (&pairs, 2), test, step_s)?;
        let follow_s = followed_s(&estimator, &singles[0])?;
        Ok(Self {
            test_flops_per_s: test_flops(N_GAUGES) / test.seconds,
            scan_flops_per_s: scan_flops(N_GAUGES, spec.n_sites) / single.scan_s,
            pairs_flops_per_s: pairs_flops(spec.n_sites) / pair.scan_s,
            single_flops_per_s: refine_flops(N_GAUGES, 1, 1.0) / step_s,
            pair_flops_per_s: refine_flops(N_GAUGES, 2, 1.0) / step_s,
            single_steps: single.steps,
            pair_steps: pair.steps,
            follow_flops_per_s: follow_flops(N_GAUGES, 1) / follow_s,
            fit_flops_per_s: fit_rate(&mut draws, threads)?,
            tips_per_s: tip_rate(map.skin())?,
        })
    }
}

/// Time of a step of refinement, s: what the further steps of `estimator` take beyond those of `short`,
/// which does the same with fewer.
fn step_s(
    estimator: &ContactEstimator,
    short: &ContactEstimator,
    frames: &[DrawnFrame],
) -> Result<f64, InverseError> {
    let all = |estimator| Ok(Searched::mean(searched(estimator, frames)?.iter()));
    let (whole, least) = (all(estimator)?, all(short)?);
    let n_further = (whole.steps - least.steps).max(1.0);
    Ok((whole.seconds - least.seconds).max(LEAST_STEP * whole.seconds) / n_further)
}

/// A search in its parts.
struct Refined {
    steps: f64,
    /// What is left beside test and steps, s.
    scan_s: f64,
}

impl Refined {
    fn measure(
        estimator: &ContactEstimator,
        (frames, n_contacts): (&[DrawnFrame], usize),
        test: Searched,
        step_s: f64,
    ) -> Result<Self, InverseError> {
        let whole = Searched::mean_of(&searched(estimator, frames)?, n_contacts);
        let scan_s = whole.seconds - test.seconds - step_s * whole.steps;
        Ok(Self { steps: whole.steps, scan_s: scan_s.max(LEAST_SCAN * whole.seconds) })
    }
}

/// Operations per second of a calibration without modes.
fn fit_rate(draws: &mut FrameDraws<'_>, n_threads: usize) -> Result<f64, InverseError> {
    let presses = draws.presses(N_PRESSES);
    let params =
        CalibrationParams { n_threads, ..CalibrationParams::new(vec![draws.noise_ue; N_GAUGES]) };
    let start = Instant::now();
    Calibrated::fit(draws.map, draws.sites, &[], &presses, &params)?;
    let flops = fit_flops(N_PRESSES, N_GAUGES, 1, draws.sites.len());
    Ok(flops / start.elapsed().as_secs_f64())
}

/// Nodes per second of which it is found what a tip there averages over.
fn tip_rate(skin: &Skin) -> Result<f64, InverseError> {
    let start = Instant::now();
    TipMeans::new(skin, TIP_M)?;
    Ok(skin.n_nodes() as f64 / start.elapsed().as_secs_f64())
}
