//! The search: nothing, one contact, pairs, more; then the count.

use std::sync::Arc;

use crate::chi_square::upper_tail;
use crate::dense::dot;
use crate::error::InverseError;
use crate::estimator::capacity::n_told;
use crate::estimator::explanation::{Explanation, MAX_CONTACTS};
use crate::estimator::grow::grow;
use crate::estimator::output::{ContactEstimate, EstimateInfo};
use crate::estimator::refine::Refiner;
use crate::estimator::report::report;
use crate::estimator::{EstimatorParams, EstimatorScratch, Model};
use crate::noise::NoiseParams;
use crate::response::ResponseMap;
use crate::sites::ScanSites;
use crate::skin_point::SkinPoint;
use crate::walk::AtWall;

/// After the first steps a start is dropped if its χ² exceeds the best one's by this ratio and more
/// than this.
const HOPELESS_RATIO: f64 = 5.0;
const HOPELESS_CHI2: f64 = 100.0;

/// Sites that a wider search for one contact starts from.
const N_WIDER: usize = 60;

/// Directions of a hop.
const N_DIRECTIONS: u32 = 6;

/// A hop is refined to the end if its first steps come this near the best.
const HOP_MARGIN: f64 = 5.0;

/// Finds the contacts behind readings.
#[derive(Clone, Debug)]
pub struct ContactEstimator {
    pub(crate) model: Model,
    pub(crate) noise: NoiseParams,
    pub(crate) params: EstimatorParams,
    /// Directions of the readings that tell something.
    pub(crate) n_told: usize,
}

impl ContactEstimator {
    /// An estimator for the map `map`, scanned at `sites`, all gauges alive.
    ///
    /// # Errors
    /// [`InverseError`] for unusable parameters, a wrong length, fewer than three gauges.
    pub fn new(
        map: Arc<ResponseMap>,
        sites: Arc<ScanSites>,
        noise: NoiseParams,
        params: EstimatorParams,
    ) -> Result<Self, InverseError> {
        params.check()?;
        let live = vec![true; map.n_gauges()];
        Self::with_gauges(map, sites, noise, params, &live)
    }

    /// The same estimator with only the gauges of `live` `[n_gauges]`: readings of the others are
    /// not looked at, and every covariance grows accordingly.
    ///
    /// # Errors
    /// [`InverseError::TooFewGauges`] with fewer than three alive; [`InverseError::Length`].
    pub fn masked(&self, live: &[bool]) -> Result<Self, InverseError> {
        let (map, sites) = (self.model.map.clone(), self.model.sites.clone());
        Self::with_gauges(map, sites, self.noise.clone(), self.params, live)
    }

    /// Standard deviation of each gauge's noise `[n_gauges]`, in the unit of the map, without what its
    /// converter adds.
    #[must_use]
    pub fn gauge_sd(&self) -> &[f64] {
        &self.noise.gauge_sd
    }

    /// The same estimator with other noise `[n_gauges]`.
    ///
    /// # Errors
    /// [`InverseError`] for a wrong length or a value that is not above 0.
    pub fn with_gauge_sd(&self, gauge_sd: &[f64]) -> Result<Self, InverseError> {
        let (map, sites) = (self.model.map.clone(), self.model.sites.clone());
        let noise = NoiseParams {
            gauge_sd: gauge_sd.to_vec(),
            ..self.noise.clone()
        };
        let mut live = vec![false; map.n_gauges()];
        self.model.live.iter().for_each(|&gauge| live[gauge] = true);
        Self::with_gauges(map, sites, noise, self.params, &live)
    }

    fn with_gauges(
        map: Arc<ResponseMap>,
        sites: Arc<ScanSites>,
        noise: NoiseParams,
        params: EstimatorParams,
        live: &[bool],
    ) -> Result<Self, InverseError> {
        let mut model = Model::new(map, sites, &noise, live)?;
        model.max_force_n = params.max_force_n;
        let (map, sites) = (&model.map, &model.sites);
        Ok(Self {
            n_told: n_told(map, sites, &noise, &model.live, params.force_scale_n),
            model,
            noise,
            params,
        })
    }

    /// The response map.
    #[must_use]
    pub fn map(&self) -> &ResponseMap {
        &self.model.map
    }

    /// The most contacts that are looked for: a contact takes three unknowns, so the live gauges
    /// carry one for every three of them. Gauges that contacts of the expected force don't move
    /// beyond their noise don't count, nor those that only repeat others; one contact is always
    /// looked for.
    #[must_use]
    pub fn most_contacts(&self) -> usize {
        let wanted = self.params.known_count.unwrap_or(self.params.max_contacts);
        wanted.min((self.n_told / 3).max(1))
    }

    /// Buffers for [`ContactEstimator::estimate_into`].
    #[must_use]
    pub fn scratch(&self) -> EstimatorScratch {
        EstimatorScratch::new(&self.model)
    }

    /// The contacts behind `readings` `[n_gauges]`, tared, in the unit of the map.
    ///
    /// # Errors
    /// [`InverseError::Length`]; [`InverseError::Reading`] naming a live gauge whose reading is not
    /// finite.
    pub fn estimate(&self, readings: &[f64]) -> Result<ContactEstimate, InverseError> {
        let mut estimate = ContactEstimate::default();
        self.estimate_into(readings, &mut self.scratch(), &mut estimate)?;
        Ok(estimate)
    }

    /// The same into `estimate`, without allocating once `scratch` and `estimate` have been used
    /// for such a frame. A scratch of another estimator is replaced.
    ///
    /// # Errors
    /// As [`ContactEstimator::estimate`].
    pub fn estimate_into(
        &self,
        readings: &[f64],
        scratch: &mut EstimatorScratch,
        estimate: &mut ContactEstimate,
    ) -> Result<(), InverseError> {
        self.begin(readings, scratch)?;
        let mut info = EstimateInfo::default();
        let untouched = self.untouched(scratch);
        let is_count_known = self.params.known_count.is_some();
        if is_count_known || upper_tail(untouched.chi2, self.model.m) < self.params.touch_p {
            for n in 1..=self.most_contacts() {
                self.search(n, scratch, &mut info);
                info.most_contacts = n;
                let is_good = |e: &Explanation| {
                    e.n == n && self.p_value(e) >= self.params.accept_p && self.is_believed(e)
                };
                if n == 1 && !scratch.found.iter().any(is_good) {
                    self.search_wider(scratch, &mut info);
                }
                if !is_count_known && scratch.found.iter().any(is_good) {
                    break;
                }
            }
        }
        report(self, readings, &untouched, scratch, &mut info, estimate);
        Ok(())
    }

    /// Contacts that start at `points` and only move downhill: no scan, no count. For following
    /// contacts from frame to frame, and for asking what readings say about a given place.
    ///
    /// # Errors
    /// As [`ContactEstimator::estimate`]; [`InverseError::TooManyContacts`] if the live gauges don't
    /// carry as many.
    pub fn refine_into(
        &self,
        readings: &[f64],
        points: &[SkinPoint],
        scratch: &mut EstimatorScratch,
        estimate: &mut ContactEstimate,
    ) -> Result<(), InverseError> {
        let (found, most) = (points.len(), (self.model.m / 3).min(MAX_CONTACTS));
        if found > most {
            return Err(InverseError::TooManyContacts { found, most });
        }
        self.begin(readings, scratch)?;
        let untouched = self.untouched(scratch);
        let mut start = Explanation::new(points);
        let mut refiner = Refiner {
            model: &self.model,
            params: &self.params,
            linear: &mut scratch.linear,
            n_steps: 0,
        };
        refiner.weigh(&mut start);
        refiner.settle(&mut start);
        let mut info = EstimateInfo {
            n_refined: 1,
            n_steps: refiner.n_steps,
            most_contacts: found,
            ..EstimateInfo::default()
        };
        scratch.found.push(start);
        report(self, readings, &untouched, scratch, &mut info, estimate);
        Ok(())
    }

    fn begin(&self, readings: &[f64], scratch: &mut EstimatorScratch) -> Result<(), InverseError> {
        if !scratch.fits(&self.model) {
            *scratch = self.scratch();
        }
        scratch.found.clear();
        self.model.whiten(readings, &mut scratch.linear.z)
    }

    pub(crate) fn p_value(&self, e: &Explanation) -> f64 {
        upper_tail(e.chi2, self.model.m.saturating_sub(3 * e.n))
    }

    /// Whether no force is beyond what is possible.
    pub(crate) fn is_believed(&self, e: &Explanation) -> bool {
        e.forces[..e.n]
            .iter()
            .all(|&a| a <= self.params.max_force_n)
    }

    fn untouched(&self, scratch: &mut EstimatorScratch) -> Explanation {
        let mut none = Explanation::new(&[]);
        scratch.linear.set_covariance(&self.model, &mut none);
        scratch.linear.evaluate(&self.model, &mut none);
        none
    }

    /// Adds refined explanations with `n` contacts to `scratch.found`.
    fn search(&self, n: usize, scratch: &mut EstimatorScratch, info: &mut EstimateInfo) {
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
                self.bases(n, scratch);
                info.n_scanned += grow(&self.model, params, scratch);
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
    fn search_wider(&self, scratch: &mut EstimatorScratch, info: &mut EstimateInfo) {
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
    fn bases(&self, n: usize, scratch: &mut EstimatorScratch) {
        let params = &self.params;
        scratch.bases.clear();
        let less = scratch.found.iter().filter(|e| e.n + 1 == n);
        scratch.bases.extend(less);
        scratch
            .bases
            .sort_unstable_by(|a, b| a.evidence().total_cmp(&b.evidence()));
        scratch.bases.truncate(params.n_bases);
        if n == 3 {
            let free = params.n_bases.saturating_sub(scratch.bases.len());
            let (buffers, pairs) = (&mut scratch.pair_buffers, &mut scratch.pairs);
            self.model.distinct_pairs(free, buffers, pairs);
            let points = self.model.sites.points();
            for pair in scratch.pairs.iter().take(free) {
                let pair = pair.sites.map(|site| points[site as usize]);
                scratch.bases.push(Explanation::new(&pair));
            }
        }
    }

    fn refine(&self, n: usize, scratch: &mut EstimatorScratch, info: &mut EstimateInfo) {
        let params = &self.params;
        let skin = self.model.skin();
        let mut refiner = Refiner {
            model: &self.model,
            params,
            linear: &mut scratch.linear,
            n_steps: 0,
        };
        for start in &mut scratch.starts {
            refiner.weigh(start);
            refiner.descend(start, params.n_probe_steps);
        }
        info.n_refined += scratch.starts.len();
        scratch
            .starts
            .sort_unstable_by(|a, b| a.misfit().total_cmp(&b.misfit()));
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
            hop(
                &mut refiner,
                &mut scratch.kept,
                self.model.sites.spacing_m(),
            );
        }
        scratch
            .found
            .extend(scratch.kept.iter().filter(|e| e.n == n));
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
