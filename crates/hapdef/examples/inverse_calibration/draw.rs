//! The simulated hardware: presses, contacts and readings.

use anyhow::{Context, Result};
use hapdef_inverse::{ModelError, NoiseParams, Press, Skin, SkinPoint};
use hapdef_rig::{Electronics, ElectronicsParams, RealLimb};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

const NOISE_UE: f64 = 1.0;
const STRONGEST_N: f64 = 34.0;

/// Contacts of a double: the held one, and how far apart they are.
const HELD_N: (f64, f64) = (29.0, 31.0);
const SPACING_M: (f64, f64) = (0.012, 0.075);

pub(crate) struct Hardware<'a> {
    real: &'a RealLimb,
    skin: Skin,
    electronics: Electronics,
    n_gauges: usize,
    /// Summed areas of the faces, m².
    areas: Vec<f64>,
}

impl<'a> Hardware<'a> {
    pub(crate) fn new(real: &'a RealLimb, skin: &Skin, seed: u64) -> Result<Self> {
        let nodes: Vec<SkinPoint> = skin.node_points().into_iter().flatten().collect();
        let mut largest: Vec<f64> = Vec::new();
        for point in &nodes {
            let g = real.response_ue_per_n(&skin.position(point), &-skin.normal(point))?;
            largest.resize(g.len(), 0.0);
            largest.iter_mut().zip(g).for_each(|(l, g)| *l = l.max(STRONGEST_N * g.abs()));
        }
        let params = ElectronicsParams { noise_ue: NOISE_UE, adc_bits: 12, headroom: 1.5, seed };
        let area = |sum: &mut f64, face: usize| {
            let x = |i: usize| skin.nodes()[skin.face_nodes(face)[i] as usize];
            *sum += 0.5 * (x(1) - x(0)).cross(&(x(2) - x(0))).norm();
            Some(*sum)
        };
        Ok(Self {
            real,
            n_gauges: largest.len(),
            electronics: Electronics::new(params, &largest)?,
            areas: (0..skin.n_faces()).scan(0.0, area).collect(),
            skin: skin.clone(),
        })
    }

    /// µε/N, without noise.
    pub(crate) fn response(&self, point: &SkinPoint) -> Result<Vec<f64>> {
        let (x, n) = (self.skin.position(point), self.skin.normal(point));
        Ok(self.real.response_ue_per_n(&x, &-n)?)
    }

    /// A frame of readings, µε.
    pub(crate) fn readings(&mut self, contacts: &[(SkinPoint, f64)]) -> Result<Vec<f64>> {
        let mut frame = vec![0.0; self.n_gauges];
        for (point, force_n) in contacts {
            let g = self.response(point)?;
            frame.iter_mut().zip(g).for_each(|(y, g)| *y += force_n * g);
        }
        self.electronics.measure(&mut frame);
        Ok(frame)
    }

    pub(crate) fn noise(&self, model_error: ModelError) -> NoiseParams {
        let step = |channel| self.electronics.resolution_ue(channel);
        NoiseParams {
            quantisation_step: (0..self.n_gauges).map(step).collect(),
            model_error,
            ..NoiseParams::uniform(self.n_gauges, NOISE_UE)
        }
    }

    /// Presses of 5–34 N anywhere on the skin.
    pub(crate) fn presses(&mut self, n: usize, rng: &mut ChaCha8Rng) -> Result<Vec<Press>> {
        (0..n)
            .map(|_| {
                let point = self.point(rng)?;
                let force_n = rng.random_range(5.0..STRONGEST_N);
                let readings = self.readings(&[(point, force_n)])?;
                Ok(Press { point, force_n, readings })
            })
            .collect()
    }

    /// One contact of 5–34 N, or one of about 30 N and one of 0–34 N.
    pub(crate) fn contacts(&self, k: usize, rng: &mut ChaCha8Rng) -> Result<Vec<(SkinPoint, f64)>> {
        let first = self.point(rng)?;
        if k == 1 {
            return Ok(vec![(first, rng.random_range(5.0..STRONGEST_N))]);
        }
        loop {
            let second = self.point(rng)?;
            let apart_m = (self.skin.position(&first) - self.skin.position(&second)).norm();
            if apart_m >= SPACING_M.0 && apart_m <= SPACING_M.1 {
                let held_n = rng.random_range(HELD_N.0..HELD_N.1);
                return Ok(vec![(first, held_n), (second, rng.random_range(0.0..STRONGEST_N))]);
            }
        }
    }

    /// A point, uniform by area.
    fn point(&self, rng: &mut ChaCha8Rng) -> Result<SkinPoint> {
        let all = self.areas.last().context("a skin has faces")?;
        let u = rng.random::<f64>() * all;
        let face = self.areas.partition_point(|sum| *sum < u);
        Ok(SkinPoint::drawn(&self.skin, face, [rng.random(), rng.random()])?)
    }
}
