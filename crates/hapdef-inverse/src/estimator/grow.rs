//! One contact more: a scan beside each explanation, then contacts moved in turn.

use hapdef_contact::MAX_CONTACTS;

use crate::dense::dot;
use crate::estimator::explanation::Explanation;
use crate::estimator::{EstimatorScratch, Model};

/// Times that all contacts are moved in turn.
const MAX_SWEEPS: usize = 2;

/// Adds a contact to each of `scratch.bases` in its best places, moves each contact in turn to
/// where it explains most while the others stay (alternating projection, Ziskind and Wax 1988),
/// and leaves the results in `scratch.starts`. Returns how many atoms were looked at.
pub(crate) fn grow(
    model: &Model,
    n_starts: usize,
    n_per_base: usize,
    scratch: &mut EstimatorScratch,
) -> usize {
    let mut n_scanned = 0;
    scratch.starts.clear();
    let mut peaks = std::mem::take(&mut scratch.peaks);
    for index in 0..scratch.bases.len() {
        let base = scratch.bases[index];
        for j in 0..base.n {
            atom_at(model, &base, j, &mut scratch.atom);
            scratch.base_company.set_atom(model, j, &scratch.atom, &scratch.unit_z);
        }
        let held = others(base.n, None);
        let company = &scratch.base_company;
        company.gains(model, &scratch.c, &held[..base.n], &mut scratch.gains);
        n_scanned += model.n_sites();
        model.peaks(&scratch.gains, n_per_base, &mut peaks);
        for peak in &peaks {
            let mut start = base;
            start.push(model.sites.points()[peak.site]);
            for j in 0..base.n {
                scratch.company.copy(&scratch.base_company, j);
            }
            let z = &scratch.unit_z;
            scratch.company.set_site(model, base.n, peak.site, z);
            n_scanned += alternate(model, &mut start, scratch);
            let all = others(start.n, None);
            start.chi2 = -scratch.company.explained(&all[..start.n]);
            scratch.starts.push(start);
        }
    }
    scratch.peaks = peaks;
    keep_best(model, n_starts, scratch);
    n_scanned
}

/// Leaves the `n` starts that explain most and are in different places.
pub(super) fn keep_best(model: &Model, n: usize, scratch: &mut EstimatorScratch) {
    let EstimatorScratch { starts, bases, .. } = scratch;
    starts.sort_unstable_by(|a, b| a.chi2.total_cmp(&b.chi2));
    bases.clear();
    let near = 0.5 * model.sites.spacing_m();
    for start in starts.iter() {
        if bases.len() == n {
            break;
        }
        if bases.iter().all(|o| !o.is_same(start, model.skin(), near)) {
            bases.push(*start);
        }
    }
    std::mem::swap(starts, bases);
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
        let held = others(e.n, Some(i));
        let held = &held[..e.n - 1];
        scratch.company.gains(model, &scratch.c, held, &mut scratch.gains);
        n_scanned += model.n_sites();
        let own = scratch.company.own_gain(i, held);
        let best = Model::best_site(&scratch.gains);
        if f64::from(best.gain) > own * (1.0 + 1e-4) {
            e.points[i] = model.sites.points()[best.site];
            let z = &scratch.unit_z;
            scratch.company.set_site(model, i, best.site, z);
            n_settled = 1;
        } else {
            n_settled += 1;
        }
    }
    n_scanned
}

/// 0..n without one.
fn others(n: usize, without: Option<usize>) -> [usize; MAX_CONTACTS] {
    let mut list = [0; MAX_CONTACTS];
    let kept = (0..n).filter(|&i| Some(i) != without);
    for (place, i) in list.iter_mut().zip(kept) {
        *place = i;
    }
    list
}

/// The unit atom of contact `i`.
pub(super) fn atom_at(model: &Model, e: &Explanation, i: usize, out: &mut [f64]) {
    let point = &e.points[i];
    let weights = model.interpolant().value_weights(&point.bary());
    model.interpolant().combine(model.rows(), point, &weights, out);
    let length = dot(out, out).sqrt();
    if length > 0.0 {
        out.iter_mut().for_each(|v| *v /= length);
    }
}
