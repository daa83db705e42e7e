//! The rows by superposition: maps calibrated with presses, frames drawn, contacts found.

use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use anyhow::Result;
use hapdef::scene::Scene;
use hapdef::touch::UncertainResponse;
use hapdef_inverse::{
    Calibrated, CalibrationParams, ContactEstimate, ContactEstimator, EstimatorParams,
    EstimatorScratch, ModelError, NoiseParams, Press, ScanSites, joint_bounds,
};

use nalgebra::Point3;
use rand::RngExt;

use super::score::Score;
use super::world::{Draw, Frame, TrueContact, World};

/// Sites of the scans.
const N_SITES: usize = 800;

/// Least force of contacts that are not the paper's, N.
pub(crate) const LEAST_N: f64 = 5.0;

/// Friction coefficients uniform in 0…μ in a random direction have this root mean square over μ.
const FRICTION_RMS: f64 = 0.408_248_290_463_863;

/// A calibrated map and what was used.
pub(crate) struct Map {
    pub(crate) calibrated: Calibrated,
    sites: Arc<ScanSites>,
    noise: NoiseParams,
    /// Channels of the rig that its gauges are.
    pub(crate) channels: Range<usize>,
}

impl Map {
    /// Calibrates a response with presses.
    pub(crate) fn calibrate(
        response: &UncertainResponse,
        presses: &[Frame],
        channels: Range<usize>,
        noise: NoiseParams,
        n_threads: usize,
    ) -> Result<Self> {
        let presses: Vec<Press> = presses
            .iter()
            .map(|frame| Press {
                point: frame.contacts[0].point,
                force_n: frame.contacts[0].force_n,
                readings: frame.readings_ue[channels.clone()].to_vec(),
            })
            .collect();
        let sites = Arc::new(ScanSites::farthest(response.map.skin(), N_SITES)?);
        let params = CalibrationParams { n_threads, ..CalibrationParams::new(noise_sd(&noise)) };
        let modes = response.modes();
        let calibrated = Calibrated::fit(&response.map, &sites, &modes, &presses, &params)?;
        Ok(Self { calibrated, sites, noise, channels })
    }

    /// An estimator on the map.
    pub(crate) fn estimator(&self, params: EstimatorParams) -> Result<ContactEstimator> {
        self.estimator_with(&self.sites, self.calibrated.model_error.clone(), params)
    }

    /// An estimator that assumes friction up to `most_friction`, which the presses didn't have, and
    /// how much wider the tips are than theirs, as [`ModelError::tip_ring_m`].
    pub(crate) fn estimator_with_friction(
        &self,
        params: EstimatorParams,
        most_friction: f64,
        tip_ring_m: f64,
    ) -> Result<ContactEstimator> {
        let model_error = ModelError {
            friction_rms: most_friction * FRICTION_RMS,
            tip_ring_m,
            ..self.calibrated.model_error.clone()
        };
        self.estimator_with(&self.sites, model_error, params)
    }

    /// An estimator that scans other sites, each with the map's error at the nearest calibrated one.
    pub(crate) fn estimator_at(
        &self,
        sites: &Arc<ScanSites>,
        params: EstimatorParams,
    ) -> Result<ContactEstimator> {
        let block = self.noise.gauge_sd.len().pow(2);
        let nearest = |x: &Point3<f64>| {
            let gap = |i: &usize| (self.sites.positions()[*i] - x).norm_squared();
            (0..self.sites.len()).min_by(|a, b| gap(a).total_cmp(&gap(b)))
        };
        let error = &self.calibrated.model_error;
        let per_site = sites.positions().iter().filter_map(nearest);
        let per_site = per_site.flat_map(|i| &error.per_site[i * block..(i + 1) * block]);
        let model_error = ModelError { per_site: per_site.copied().collect(), ..error.clone() };
        self.estimator_with(sites, model_error, params)
    }

    fn estimator_with(
        &self,
        sites: &Arc<ScanSites>,
        model_error: ModelError,
        params: EstimatorParams,
    ) -> Result<ContactEstimator> {
        let noise = NoiseParams { model_error, ..self.noise.clone() };
        let map = Arc::new(self.calibrated.map.clone());
        Ok(ContactEstimator::new(map, sites.clone(), noise, params)?)
    }

    /// Root mean square of the position error over the Cramér–Rao bound of the noise alone, over
    /// the matched contacts where that bound exceeds the map's error; none if there is none.
    pub(crate) fn bound_ratio(
        &self,
        estimator: &ContactEstimator,
        frames: &[Frame],
    ) -> Result<Option<f64>> {
        // the noise's bounds: the map is taken as exact
        let exact =
            self.estimator_with(&self.sites, ModelError::default(), EstimatorParams::default())?;
        let skin = estimator.map().skin();
        let (mut sum, mut n) = (0.0, 0.0);
        for frame in frames {
            let estimate = estimator.estimate(&frame.readings_ue[self.channels.clone()])?;
            if estimate.contacts.len() != frame.contacts.len() {
                continue;
            }
            let truth: Vec<_> = frame.contacts.iter().map(|c| (c.point, c.force_n)).collect();
            let (Some(bounds), Some(with_map)) =
                (joint_bounds(&exact, &truth)?, joint_bounds(estimator, &truth)?)
            else {
                continue;
            };
            let pairs = Score::default().add_estimate(skin, frame, &estimate, 0.0)?;
            for pair in pairs {
                let bound2 = bounds[pair.truth].position_sd_m.powi(2);
                let map2 = with_map[pair.truth].position_sd_m.powi(2) - bound2;
                if bound2 > map2 {
                    sum += pair.position_error_m.powi(2) / bound2;
                    n += 1.0;
                }
            }
        }
        Ok((n > 0.0).then(|| f64::sqrt(sum / n)))
    }
}

/// Finds the contacts of all `frames`, whose `channels` are the estimator's gauges, and shows `also`
/// its readings and each frame with its estimate.
pub(crate) fn score(
    estimator: &ContactEstimator,
    channels: Range<usize>,
    frames: &[Frame],
    mut also: impl FnMut(&ContactEstimator, &[f64], &Frame, &ContactEstimate) -> Result<()>,
) -> Result<Score> {
    let mut score = Score::default();
    let mut scratch = estimator.scratch();
    let mut estimate = ContactEstimate::default();
    for frame in frames {
        let readings = &frame.readings_ue[channels.clone()];
        let time_us = estimate_us(estimator, readings, &mut scratch, &mut estimate)?;
        score.add_estimate(estimator.map().skin(), frame, &estimate, time_us)?;
        also(estimator, readings, frame, &estimate)?;
    }
    Ok(score)
}

/// Finds the contacts of a frame; the time that it took, µs.
pub(crate) fn estimate_us(
    estimator: &ContactEstimator,
    readings: &[f64],
    scratch: &mut EstimatorScratch,
    estimate: &mut ContactEstimate,
) -> Result<f64> {
    let start = Instant::now();
    estimator.estimate_into(readings, scratch, estimate)?;
    Ok(start.elapsed().as_secs_f64() * 1e6)
}

/// What is pressed, each row from a seed of its own; the row seeds the noise, too.
#[derive(Clone, Copy)]
pub(crate) struct Drawn<'a> {
    pub(crate) world: &'a World,
    pub(crate) scene: &'a Scene,
    pub(crate) seed: u64,
}

impl<'a> Drawn<'a> {
    pub(crate) fn draw(&self, row: u64) -> Draw<'a> {
        Draw::new(&self.world.skin, self.seed.wrapping_add(row))
    }

    /// Single presses for a calibration: places uniform over the skin, forces over the scene's range.
    pub(crate) fn presses(&self, n: usize) -> Result<Vec<Frame>> {
        let [weakest_n, strongest_n] = self.scene.contact.force_range_n;
        let mut draw = self.draw(1);
        let drawn = (0..n).map(|_| {
            let point = draw.place();
            let force_n = draw.rng.random_range(weakest_n.max(1.0)..=strongest_n);
            vec![draw.contact(point, force_n, 0.0)]
        });
        self.under_own_tip(drawn.collect(), 1)
    }

    /// Single contacts of 5 N to the strongest.
    pub(crate) fn singles(&self, n: usize) -> Result<Vec<Frame>> {
        self.apart(n, 1, 0.0, 11)
    }

    /// Single contacts of one force under one tip.
    pub(crate) fn alike(&self, n: usize, force_n: f64, tip_m: f64) -> Result<Vec<Frame>> {
        const ROW: u64 = 24;
        let forces = [[force_n, force_n]; 4];
        let drawn = sets(&mut self.draw(ROW), n, 1, forces, [0.0, f64::MAX], 0.0);
        self.world.frames(drawn, tip_m, ROW)
    }

    /// `k` contacts of 5 N to the strongest, `gap_m` apart.
    pub(crate) fn apart(&self, n: usize, k: usize, gap_m: f64, row: u64) -> Result<Vec<Frame>> {
        let forces = [[LEAST_N, self.scene.contact.force_range_n[1]]; 4];
        let drawn = sets(&mut self.draw(row), n, k, forces, [gap_m, f64::MAX], 0.0);
        self.under_own_tip(drawn, row)
    }

    /// The paper's pairs: 30 N held and 0…34 N varied, 12–75 mm apart.
    pub(crate) fn doubles(&self, n: usize) -> Result<Vec<Frame>> {
        self.under_own_tip(self.pairs(n, 0.0, 12), 12)
    }

    /// The same with friction up to `most_friction` and under another tip.
    pub(crate) fn rough_doubles(
        &self,
        n: usize,
        most_friction: f64,
        tip_m: f64,
    ) -> Result<Vec<Frame>> {
        self.world.frames(self.pairs(n, most_friction, 20), tip_m, 20)
    }

    fn under_own_tip(&self, drawn: Vec<Vec<TrueContact>>, stream: u64) -> Result<Vec<Frame>> {
        self.world.frames(drawn, self.scene.contact.tip_radius_m, stream)
    }

    fn pairs(&self, n: usize, most_friction: f64, row: u64) -> Vec<Vec<TrueContact>> {
        let (presses, varied_n) = (&self.scene.rig.presses, self.scene.contact.force_range_n);
        let (held, spread) = (presses.held_force_n, presses.held_spread_n);
        let forces = [[held - spread, held + spread], varied_n, varied_n, varied_n];
        sets(&mut self.draw(row), n, 2, forces, presses.spacing_range_m, most_friction)
    }
}

/// Sets of `k` contacts, forces uniform in their ranges, distances within `gap_m`.
pub(crate) fn sets(
    draw: &mut Draw<'_>,
    n: usize,
    k: usize,
    forces_n: [[f64; 2]; 4],
    gap_m: [f64; 2],
    most_friction: f64,
) -> Vec<Vec<TrueContact>> {
    (0..n)
        .map(|_| {
            let places = draw.places(k, gap_m);
            let contact = |(i, place)| {
                let [low, high] = forces_n[i];
                let force_n = draw.rng.random_range(low..=high);
                draw.contact(place, force_n, most_friction)
            };
            places.into_iter().enumerate().map(contact).collect()
        })
        .collect()
}

/// White noise and quantisation together `[n_gauges]`.
fn noise_sd(noise: &NoiseParams) -> Vec<f64> {
    let step2 = |g: usize| noise.quantisation_step.get(g).map_or(0.0, |s| s * s / 12.0);
    let sd = |(g, sd): (usize, &f64)| (sd * sd + step2(g)).sqrt();
    noise.gauge_sd.iter().enumerate().map(sd).collect()
}
