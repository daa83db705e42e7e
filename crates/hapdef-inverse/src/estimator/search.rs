//! The search: one contact, pairs, more.

use crate::dense::dot;
use crate::estimator::explanation::Explanation;
use crate::estimator::grow::grow;
use crate::estimator::output::EstimateInfo;
use crate::estimator::refine::Refiner;
use crate::estimator::{ContactEstimator, EstimatorScratch};
use crate::walk::AtWall;

/// After the first steps a start is dropped if its χ² exceeds the best one's by this ratio and more
/// than this: most starts lie in other basins, and refining all of them to the end is most of a search's
/// time. A right explanation of ten gauges ends with χ² about ten, so 100 is ten times what noise leaves,
/// and the ratio takes its place where the map's error leaves more.
const HOPELESS_RATIO: f64 = 5.0;
const HOPELESS_CHI2: f64 = 100.0;

/// Sites that a wider search for one contact starts from: on coarse meshes descents from the few best
/// sites all end at kinks of the map. Ten times the usual starts, only for frames that those don't explain.
const N_WIDER: usize = 60;

/// Directions of a hop.
const N_DIRECTIONS: u32 = 6;

/// A hop is refined to the end if its first steps come this near the best: those have not
/// come to the end of the way, so one that is a little worse by then may still win.
const HOP_MARGIN: f64 = 5.0;

impl ContactEstimator {
    /// Adds refined explanations with `n` contacts to `scratch.found`.
    pub(super) fn search(&self, n: usize, scratch: &mut EstimatorScratch, info: &mut EstimateInfo) {
        let params = &self.params;
        let n_sites = self.model.n_sites();
        match n {
            1 => {
                self.single_starts(scratch);
                info.n_scanned += n_sites;
            }
            2 => {
                self.pair_starts(params.n_starts, scratch);
                info.n_scanned += n_sites * (n_sites - 1) / 2;
            }
            _ => {
                self.bases(n, params.n_bases, scratch);
                info.n_scanned += grow(&self.model, params.n_starts, params.n_per_base, scratch);
            }
        }
        self.refine(n, scratch, info);
    }

    /// The best local maxima of the scan, and the sites around the best.
    fn single_starts(&self, scratch: &mut EstimatorScratch) {
        let model = &self.model;
        let size = dot(&scratch.linear.z, &scratch.linear.z).sqrt();
        let scale = if size > 0.0 { 1.0 / size } else { 0.0 };
        for (unit, z) in scratch.unit_z.iter_mut().zip(&scratch.linear.z) {
            *unit = z * scale;
        }
        for site in 0..model.n_sites() {
            let product = dot(model.atom(site), &scratch.unit_z) as f32;
            scratch.c[site] = product;
            scratch.gains[site] = product.max(0.0).powi(2);
        }
        let n = self.params.n_single_starts;
        model.peaks(&scratch.gains, n, &mut scratch.peaks);
        scratch.starts.clear();
        let top = scratch.peaks.first().map(|peak| peak.site);
        let near = top.map_or(&[][..], |site| &model.sites.near(site)[..]);
        let around = near.iter().map(|&site| site as usize);
        for site in scratch.peaks.iter().map(|peak| peak.site).chain(around) {
            let point = model.sites.points()[site];
            scratch.starts.push(Explanation::new(&[point]));
        }
    }

    /// One contact from many of the best sites, for frames that the usual starts don't explain: on a
    /// coarse mesh descents end at kinks of the map.
    pub(super) fn search_wider(&self, scratch: &mut EstimatorScratch, info: &mut EstimateInfo) {
        let model = &self.model;
        for (gain, c) in scratch.gains.iter_mut().zip(&scratch.c) {
            *gain = c.max(0.0).powi(2);
        }
        model.largest(&scratch.gains, N_WIDER, &mut scratch.peaks);
        scratch.starts.clear();
        for best in &scratch.peaks {
            let point = model.sites.points()[best.site];
            scratch.starts.push(Explanation::new(&[point]));
        }
        self.refine(1, scratch, info);
    }

    fn pair_starts(&self, n: usize, scratch: &mut EstimatorScratch) {
        let (model, buffers) = (&self.model, &mut scratch.pair_buffers);
        model.best_pairs(&scratch.c, n, buffers, &mut scratch.pairs);
        scratch.starts.clear();
        let points = model.sites.points();
        for pair in &scratch.pairs {
            let pair = pair.sites.map(|site| points[site as usize]);
            scratch.starts.push(Explanation::new(&pair));
        }
    }

    /// What a further contact is added to: refined explanations with one contact less, the best
    /// first, and for three contacts pairs of the scan.
    pub(super) fn bases(&self, n: usize, n_bases: usize, scratch: &mut EstimatorScratch) {
        scratch.bases.clear();
        let less = scratch.found.iter().filter(|e| e.n + 1 == n);
        scratch.bases.extend(less);
        scratch.bases.sort_unstable_by(|a, b| a.cost().total_cmp(&b.cost()));
        scratch.bases.truncate(n_bases);
        if n == 3 {
            let free = n_bases.saturating_sub(scratch.bases.len());
            let (buffers, pairs) = (&mut scratch.pair_buffers, &mut scratch.pairs);
            self.model.best_pairs(&scratch.c, free, buffers, pairs);
            let points = self.model.sites.points();
            for pair in scratch.pairs.iter().take(free) {
                let pair = pair.sites.map(|site| points[site as usize]);
                scratch.bases.push(Explanation::new(&pair));
            }
        }
    }

    pub(super) fn refine(&self, n: usize, scratch: &mut EstimatorScratch, info: &mut EstimateInfo) {
        let params = &self.params;
        let skin = self.model.skin();
        let mut refiner =
            Refiner { model: &self.model, params, linear: &mut scratch.linear, n_steps: 0 };
        for start in &mut scratch.starts {
            refiner.weigh(start);
            refiner.descend(start, params.n_probe_steps);
        }
        info.n_refined += scratch.starts.len();
        scratch.starts.sort_unstable_by(|a, b| a.misfit().total_cmp(&b.misfit()));
        scratch.kept.clear();
        let best = scratch.starts.first().map_or(0.0, |e| e.chi2);
        let hopeless = |e: &Explanation| e.chi2 > HOPELESS_RATIO * best + HOPELESS_CHI2;
        for start in scratch.starts.iter().filter(|e| !hopeless(e)) {
            let near = 0.2 * params.distinct_m;
            let is_new = |other: &Explanation| !other.is_same(start, skin, near);
            if scratch.kept.len() < params.n_finalists && scratch.kept.iter().all(is_new) {
                scratch.kept.push(*start);
            }
        }
        for kept in &mut scratch.kept {
            refiner.settle(kept);
        }
        for _ in 0..params.n_hops {
            hop(&mut refiner, &mut scratch.kept, self.model.sites.spacing_m());
        }
        scratch.found.extend(scratch.kept.iter().filter(|e| e.n == n));
        info.n_steps += refiner.n_steps;
    }
}

/// Starts again from places around the contacts of the best explanation, one contact moved at a
/// time: the map's slope jumps at edges of faces, and a descent may end at a kink.
fn hop(refiner: &mut Refiner<'_>, kept: &mut [Explanation], distance_m: f64) {
    let best = (0..kept.len()).min_by(|&a, &b| kept[a].misfit().total_cmp(&kept[b].misfit()));
    let Some(best) = best else {
        return;
    };
    let from = kept[best];
    let mut found = from;
    for i in 0..from.n {
        let [t1, t2] = refiner.model.skin().tangents(&from.points[i]);
        for turn in 0..N_DIRECTIONS {
            let (s, c) =
                (f64::from(turn) / f64::from(N_DIRECTIONS) * std::f64::consts::TAU).sin_cos();
            let step = (t1 * c + t2 * s) * distance_m;
            let mut start = from;
            let skin = refiner.model.skin();
            start.points[i] = skin.walk(&from.points[i], &step, AtWall::Slide).point;
            refiner.descend(&mut start, refiner.params.n_probe_steps);
            if start.misfit() < found.misfit() + HOP_MARGIN {
                refiner.settle(&mut start);
                if start.n == from.n && start.misfit() < found.misfit() {
                    found = start;
                }
            }
        }
    }
    kept[best] = found;
}
