//! A calibration from beginning to end.

use crate::calibration::corrected::{Corrected, Given};
use crate::calibration::evidence::{FIRST, choose_kernels};
use crate::calibration::held_out::place_factor;
use crate::calibration::kernel::{Kernel, around};
use crate::calibration::next::next_presses;
use crate::calibration::output::{
    Calibrated, CalibrationInfo, CurvePoint, HeldOutError, RejectReason, RejectedPress,
};
use crate::calibration::params::{CalibrationParams, ModeMap};
use crate::calibration::press::Press;
use crate::calibration::reject::reject;
use crate::calibration::residual::Wanted;
use crate::calibration::samples::{Basis, LEAST_PRESSES, Places, Samples};
use crate::calibration::solution::{Problem, Solution};
use crate::calibration::spread::Spread;
use crate::error::InverseError;
use crate::noise::ModelError;
use crate::response::ResponseMap;
use crate::sites::ScanSites;

/// Parts of the presses at which the learning curve is taken.
const CUTS: [f64; 4] = [0.125, 0.25, 0.5, 0.75];

/// Rounds of choosing kernels and rejecting presses: bad presses spoil the kernels by which they are judged.
const N_ROUNDS: usize = 3;

impl Calibrated {
    /// Corrects `map` by `presses`; `modes` say how it may differ, gains are a mode of their own.
    /// The error of the result is reported at `sites`.
    ///
    /// Time grows with the cube of the number of presses, and memory with its square:
    /// [`CalibrationParams::max_presses`].
    ///
    /// # Errors
    /// [`InverseError`]: unusable parameters or modes, too few presses, all in one spot, one that
    /// is not of this skin or has readings or a force that can't be used.
    pub fn fit(
        map: &ResponseMap,
        sites: &ScanSites,
        modes: &[ModeMap<'_>],
        presses: &[Press],
        params: &CalibrationParams,
    ) -> Result<Self, InverseError> {
        params.check(map.n_gauges())?;
        let nodal = nodal_values(map);
        let mean_squares = mean_squares(&nodal, map.n_gauges());
        let basis = Basis::new(map, modes, params, &mean_squares)?;
        let samples = Samples::new(&basis, &nodal, presses, params)?;
        let problem = Problem {
            samples: &samples,
            n_own: basis.n_own(),
            mean_squares: &mean_squares,
            n_threads: params.n_threads,
        };
        let all: Vec<usize> = (0..samples.len()).collect();
        let mut rejected = Vec::new();
        let mut kernels = vec![FIRST; map.n_gauges()];
        let mut rows = reject(&problem, &all, &kernels, params.reject_p, &mut rejected)?;
        // bad presses make the residual look rough, and a rough residual excuses bad presses
        for _ in 0..N_ROUNDS {
            kernels = choose_kernels(&problem, &rows, params);
            rejected.clear();
            let kept = reject(&problem, &all, &kernels, params.reject_p, &mut rejected)?;
            let is_same = kept == rows;
            rows = kept;
            if is_same {
                break;
            }
        }
        let (found, needed) = (rows.len(), LEAST_PRESSES);
        if found < needed {
            return Err(InverseError::TooFewPresses { found, needed });
        }
        let at_sites = Places::new(&basis, &nodal, sites.points().to_vec(), params.widths_m());
        let cuts: Vec<usize> = CUTS.map(|c| (c * found as f64) as usize).to_vec();
        let positions = map.value_positions();
        let widths_m = params.widths_m();
        let around = around(&positions, &nodal, map.n_gauges(), &positions, widths_m);
        let given = Given {
            basis: &basis,
            values: &(positions, around),
            problem: &problem,
            at_sites: &at_sites,
            params,
        };
        let place_factor = match params.holds_out {
            true => place_factor(&given, sites, presses, &rows, &kernels)?,
            false => 1.0,
        };
        let wanted =
            Wanted { sites: Some(&at_sites), has_covariance: params.n_next > 0, cuts: &cuts };
        let solution = problem.solve(&rows, &kernels, wanted)?;
        let Corrected { solution, map, spread, per_site } = given.correct(solution, &kernels);
        not_needed(presses.len(), &samples, &mut rejected);
        let info = info(&basis, &samples, &solution, &spread, &kernels, rejected);
        let next = next_presses(&problem, &solution, &at_sites, &spread.scales, params.n_next);
        Ok(Self {
            map,
            model_error: ModelError { per_site, place_factor, ..ModelError::default() },
            info: CalibrationInfo { next, ..info },
        })
    }
}

/// g where the map has values `[n_values, n_gauges]`.
fn nodal_values(map: &ResponseMap) -> Vec<f64> {
    let width = crate::dense::padded(map.n_gauges());
    let rows = map.normal_rows().chunks_exact(width).take(map.n_values());
    rows.flat_map(|row| row[..map.n_gauges()].to_vec()).collect()
}

fn mean_squares(nodal: &[f64], n_gauges: usize) -> Vec<f64> {
    let n = (nodal.len() / n_gauges).max(1) as f64;
    let mean = |gauge: usize| {
        let column = nodal.iter().skip(gauge).step_by(n_gauges);
        (column.map(|g| g * g).sum::<f64>() / n).max(f64::MIN_POSITIVE)
    };
    (0..n_gauges).map(mean).collect()
}

fn not_needed(n_presses: usize, samples: &Samples, rejected: &mut Vec<RejectedPress>) {
    let mut is_used = vec![false; n_presses];
    samples.index.iter().for_each(|&i| is_used[i] = true);
    let reason = RejectReason::NotNeeded;
    let unused = (0..n_presses).filter(|&press| !is_used[press]);
    rejected.extend(unused.map(|press| RejectedPress { press, reason }));
    rejected.sort_by_key(|r| r.press);
}

fn info(
    basis: &Basis<'_>,
    samples: &Samples,
    solution: &Solution,
    spread: &Spread,
    kernels: &[Kernel],
    rejected: Vec<RejectedPress>,
) -> CalibrationInfo {
    let m = samples.n_gauges();
    let norm = |values: &[f64], i: usize| {
        values[i * m..(i + 1) * m].iter().map(|v| v * v).sum::<f64>().sqrt()
    };
    let held_out = |(place, &i): (usize, &usize)| HeldOutError {
        press: samples.index[i],
        error: (0..m).map(|g| spread.left_out[g].error[place].powi(2)).sum::<f64>().sqrt(),
        response: norm(&samples.response, i),
        mean_square_z: spread.mean_square_z[place],
    };
    let held_out: Vec<_> = solution.rows.iter().enumerate().map(held_out).collect();
    let sum = |f: &dyn Fn(&HeldOutError) -> f64| held_out.iter().map(|h| f(h).powi(2)).sum::<f64>();
    let all = sum(&|h| h.response).max(f64::MIN_POSITIVE);
    let before: f64 = solution.rows.iter().map(|&i| norm(&samples.residual, i).powi(2)).sum();
    CalibrationInfo {
        n_used: solution.rows.len(),
        rejected,
        mode_coefficients: basis.coefficients(&solution.modes.theta),
        beyond_prior: basis.beyond_prior(&solution.modes.theta),
        gains: solution.modes.theta.iter().map(|t| basis.gain_sd * t[0]).collect(),
        lengths_m: kernels.iter().map(|k| k.length_m).collect(),
        residual_sizes: kernels.iter().map(|k| k.size).collect(),
        variance_scales: spread.scales.clone(),
        relative_error: (sum(&|h| h.error) / all).sqrt(),
        relative_error_before: (before / all).sqrt(),
        curve: curve(samples, solution),
        next: Vec::new(),
        held_out,
    }
}

/// Errors of later presses as predicted from the first ones, the modes as found from all.
fn curve(samples: &Samples, solution: &Solution) -> Vec<CurvePoint> {
    let m = samples.n_gauges();
    let n_cuts = solution.fits.first().map_or(0, |fit| fit.cuts.len());
    let point = |k: usize| {
        let (mut error, mut all) = (0.0, 0.0);
        let cut = solution.fits[0].cuts[k].cut;
        for (gauge, fit) in solution.fits.iter().enumerate() {
            let errors = &fit.cuts[k];
            for (place, y) in errors.of_y.iter().enumerate() {
                let predicted = solution.modes.theta[gauge].iter().zip(&errors.of_columns);
                let e = y - predicted.map(|(t, h)| t * h[place]).sum::<f64>();
                error += e * e;
                all += samples.response[solution.rows[cut + place] * m + gauge].powi(2);
            }
        }
        CurvePoint { n_presses: cut, relative_error: (error / all).sqrt() }
    };
    (0..n_cuts).map(point).collect()
}
