//! How large the reported regions have to be: contacts found where presses were that the map has not seen.

use std::sync::Arc;

use hapdef_contact::Verdict;

use crate::calibration::corrected::{Corrected, Given};
use crate::calibration::kernel::Kernel;
use crate::calibration::output::Calibrated;
use crate::calibration::press::Press;
use crate::calibration::regions::SHARE;
use crate::calibration::residual::Wanted;
use crate::calibration::solution::Solution;
use crate::error::InverseError;
use crate::estimator::{CHI2_95, ContactEstimator, EstimatorParams};
use crate::noise::{ModelError, NoiseParams};
use crate::sites::ScanSites;

/// Numbers of presses for which some are held out: fewer don't determine a quantile of 95 %, and more know
/// so little of each other that the left-out ones of the fit itself suffice.
const N_PRESSES: std::ops::RangeInclusive<usize> = 40..=1000;

/// Parts into which the presses are divided; each in turn is held out, until so many presses were. A fit to
/// nine tenths is nearly as good as one to all, and the 95 % quantile of 300 errors has 15 beyond it.
const N_PARTS: usize = 10;
const N_HELD_OUT: usize = 300;

impl Calibrated {
    /// How often a fit to `n_presses` is repeated without a part of them, to see how large the reported
    /// regions have to be.
    #[must_use]
    pub fn n_refits(n_presses: usize) -> usize {
        if !N_PRESSES.contains(&n_presses) {
            return 0;
        }
        let n_of_part = n_presses.div_ceil(N_PARTS);
        N_HELD_OUT.div_ceil(n_of_part).min(N_PARTS)
    }
}

/// The factor of a place's covariance with which the reported 95 % regions hold 95 % of presses that
/// neither the map nor its error know of (split conformal prediction: the ⌈.95 (n + 1)⌉-th smallest
/// squared distance; Vovk, Gammerman & Shafer, Algorithmic Learning in a Random World, 2005, chapter
/// 2). The kernels are those of all presses. Answers that say that they are not identifiable count for
/// nothing. 1 where too few or too many presses are there.
pub(crate) fn place_factor(
    given: &Given<'_>,
    sites: &ScanSites,
    presses: &[Press],
    rows: &[usize],
    kernels: &[Kernel],
) -> Result<f64, InverseError> {
    let chosen = |part: usize, is_held_out: bool| -> Vec<usize> {
        let places = rows.iter().enumerate();
        let some = places.filter(|(place, _)| (place % N_PARTS == part) == is_held_out);
        some.map(|(_, &row)| row).collect()
    };
    let wanted = Wanted { sites: Some(given.at_sites), ..Wanted::default() };
    let solve = |part: usize| given.problem.solve(&chosen(part, false), kernels, wanted);
    let solutions: Vec<Solution> =
        (0..Calibrated::n_refits(rows.len())).map(solve).collect::<Result<_, _>>()?;
    let mut distances = Vec::new();
    for (part, corrected) in given.correct_each(solutions, kernels).enumerate() {
        let estimator = estimator(given, sites, corrected)?;
        for row in chosen(part, true) {
            let press = &presses[given.problem.samples.index[row]];
            let found = estimator.estimate(&press.readings)?;
            if let ([one], Verdict::Identified) = (&found.contacts[..], found.verdict) {
                let skin = given.basis.map.skin();
                let sd_m = given.params.position_sd_m;
                distances.extend(one.distance_2(skin, &skin.position(&press.point), sd_m));
            }
        }
    }
    distances.sort_unstable_by(f64::total_cmp);
    let n = distances.len();
    let rank = (SHARE * (n + 1) as f64).ceil() as usize;
    let quantile = distances.get(rank.min(n).wrapping_sub(1));
    Ok(quantile.map_or(1.0, |distance_2| distance_2 / CHI2_95))
}

fn estimator(
    given: &Given<'_>,
    sites: &ScanSites,
    corrected: Corrected,
) -> Result<ContactEstimator, InverseError> {
    let gauge_sd = given.params.gauge_sd.clone();
    let noise = NoiseParams {
        model_error: ModelError { per_site: corrected.per_site, ..ModelError::default() },
        gauge_sd,
        ..NoiseParams::uniform(given.basis.map.n_gauges(), 1.0)
    };
    let params = EstimatorParams { max_contacts: 1, ..EstimatorParams::default() };
    let (map, sites) = (Arc::new(corrected.map), Arc::new(sites.clone()));
    ContactEstimator::new(map, sites, noise, params)
}
