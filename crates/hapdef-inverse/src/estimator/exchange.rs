//! Pairs exchanged: two contacts at a time are looked for anew beside the others.

use crate::estimator::explanation::Explanation;
use crate::estimator::grow::atom_at;
use crate::estimator::output::EstimateInfo;
use crate::estimator::refine::Refiner;
use crate::estimator::{ContactEstimator, EstimatorScratch};

/// Times at most that all pairs are gone round.
const MAX_ROUNDS: usize = 4;

/// Pairs that are refined of each scan. The scan ranks pairs as if they were at sites, and half a site's spacing of a
/// strong contact is more χ² than a wrong pair: with 4 instead of 16 another 1.7 % of 600 frames of four
/// contacts on sixteen gauges were not clean; 32 find another 0.5 % and make the slowest frames a tenth slower.
const N_PAIRS: usize = 16;

/// An exchange has to lower −2 ln likelihood by this.
const LEAST_GAIN: f64 = 1.0;

impl ContactEstimator {
    /// Improves the best explanations with `n` contacts of `scratch.found` until one is as good as `p`: all
    /// contacts but two are held, all pairs of sites are scanned beside them, the best refined.
    pub(super) fn exchange(
        &self,
        n: usize,
        n_starts: usize,
        p: f64,
        scratch: &mut EstimatorScratch,
        info: &mut EstimateInfo,
    ) {
        let EstimatorScratch { kept, found, .. } = scratch;
        kept.clear();
        kept.extend(found.iter().filter(|e| e.n == n));
        kept.sort_unstable_by(|a, b| a.misfit().total_cmp(&b.misfit()));
        kept.truncate(n_starts);
        for k in 0..scratch.kept.len() {
            let better = self.exchanged(scratch.kept[k], p, scratch, info);
            scratch.found.push(better);
            if self.is_good(&better, p) {
                break;
            }
        }
    }

    fn exchanged(
        &self,
        start: Explanation,
        p: f64,
        scratch: &mut EstimatorScratch,
        info: &mut EstimateInfo,
    ) -> Explanation {
        let n = start.n;
        let mut best = start;
        // pairs gone through since the last one that was exchanged
        let (mut n_idle, n_pairs) = (0, n * (n - 1) / 2);
        for _ in 0..MAX_ROUNDS {
            for i in 0..n {
                for j in i + 1..n {
                    if n_idle == n_pairs || self.is_good(&best, p) || best.n < n {
                        return best;
                    }
                    n_idle += 1;
                    let found = self.exchange_pair(&best, [i, j], scratch, info);
                    if let Some(found) = found {
                        best = found;
                        n_idle = 0;
                    }
                }
            }
        }
        best
    }

    /// The best explanation with contacts `pair` of `from` elsewhere, if it is better.
    fn exchange_pair(
        &self,
        from: &Explanation,
        pair: [usize; 2],
        scratch: &mut EstimatorScratch,
        info: &mut EstimateInfo,
    ) -> Option<Explanation> {
        let model = &self.model;
        let mut held = Explanation::new(&[]);
        for k in (0..from.n).filter(|k| !pair.contains(k)) {
            atom_at(model, from, k, &mut scratch.atom);
            scratch.company.set_atom(model, held.n, &scratch.atom, &scratch.unit_z);
            held.push(from.points[k]);
        }
        let EstimatorScratch { c, company, pair_buffers, pairs, linear, .. } = scratch;
        model.best_pairs_beside(c, company, held.n, N_PAIRS, pair_buffers, pairs);
        info.n_scanned += model.n_sites() * (model.n_sites() - 1) / 2;
        let mut refiner = Refiner { model, params: &self.params, linear, n_steps: 0 };
        let mut best: Option<Explanation> = None;
        for pair in pairs.iter() {
            let mut trial = held;
            pair.sites.iter().for_each(|&s| trial.push(model.sites.points()[s as usize]));
            refiner.weigh(&mut trial);
            refiner.descend(&mut trial, self.params.n_probe_steps);
            info.n_refined += 1;
            if best.is_none_or(|best| trial.misfit() < best.misfit()) {
                best = Some(trial);
            }
        }
        let mut best = best?;
        refiner.settle(&mut best);
        info.n_steps += refiner.n_steps;
        (best.n == from.n && best.misfit() < from.misfit() - LEAST_GAIN).then_some(best)
    }
}
