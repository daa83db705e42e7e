//! One contact more: a scan beside each explanation, then contacts moved in turn.

use crate::dense::dot;
use crate::estimator::explanation::Explanation;
use crate::estimator::{EstimatorParams, EstimatorScratch, Model};

/// Times that all contacts are moved in turn.
const MAX_SWEEPS: usize = 2;

/// Adds a contact to each of `scratch.bases` in its best places, moves each contact in turn to
/// where it explains most while the others stay (alternating projection, Ziskind and Wax 1988),
/// and leaves the results in `scratch.starts`. Returns how many atoms were looked at.
pub(crate) fn grow(
    model: &Model,
    params: &EstimatorParams,
    scratch: &mut EstimatorScratch,
) -> usize {
    let mut n_scanned = 0;
    scratch.starts.clear();
    for index in 0..scratch.bases.len() {
        let base = scratch.bases[index];
        scan_beside(model, &base, None, scratch);
        n_scanned += model.n_sites();
        let mut peaks = std::mem::take(&mut scratch.peaks);
        model.peaks(&scratch.gains, params.n_per_base, &mut peaks);
        for peak in &peaks {
            let mut start = base;
            start.push(model.sites.points()[peak.site]);
            n_scanned += alternate(model, &mut start, scratch);
            let skin = model.skin();
            let is_new = |other: &Explanation| !other.is_same(&start, skin, 1e-4);
            if scratch.starts.iter().all(is_new) {
                scratch.starts.push(start);
            }
        }
        scratch.peaks = peaks;
    }
    n_scanned
}

/// Gains of one contact more beside those of `e`, or in place of contact `without`.
fn scan_beside(
    model: &Model,
    e: &Explanation,
    without: Option<usize>,
    scratch: &mut EstimatorScratch,
) {
    scratch.held.clear();
    for i in (0..e.n).filter(|&i| Some(i) != without) {
        atom_at(model, e, i, &mut scratch.atom);
        scratch.held.push(&scratch.atom);
    }
    scratch.r.copy_from_slice(&scratch.linear.z);
    scratch.held.project(&mut scratch.r);
    model.gains(&scratch.r, &scratch.held, &mut scratch.gains);
}

fn alternate(model: &Model, e: &mut Explanation, scratch: &mut EstimatorScratch) -> usize {
    let mut n_scanned = 0;
    // the contact added last is already where it explains most
    let mut n_settled = 1;
    for turn in 0..MAX_SWEEPS * e.n {
        if n_settled >= e.n {
            break;
        }
        let i = turn % e.n;
        scan_beside(model, e, Some(i), scratch);
        n_scanned += model.n_sites();
        atom_at(model, e, i, &mut scratch.atom);
        let own = own_gain(model, scratch);
        let best = Model::best_site(&scratch.gains);
        if best.gain > own * (1.0 + 1e-6) {
            e.points[i] = model.sites.points()[best.site];
            n_settled = 1;
        } else {
            n_settled += 1;
        }
    }
    n_scanned
}

/// What the atom in `scratch.atom` explains beside those held.
fn own_gain(model: &Model, scratch: &EstimatorScratch) -> f64 {
    let along = dot(&scratch.atom, &scratch.r);
    let mut left = 1.0;
    for i in 0..scratch.held.n() {
        left -= dot(scratch.held.row(i, model.width), &scratch.atom).powi(2);
    }
    if along > 0.0 && left > 1e-4 {
        along * along / left
    } else {
        0.0
    }
}

/// The unit atom of contact `i`.
fn atom_at(model: &Model, e: &Explanation, i: usize, out: &mut [f64]) {
    let point = &e.points[i];
    let weights = model.interpolant().value_weights(&point.bary());
    model
        .interpolant()
        .combine(model.rows(), point, &weights, out);
    let length = dot(out, out).sqrt();
    if length > 0.0 {
        out.iter_mut().for_each(|v| *v /= length);
    }
}
