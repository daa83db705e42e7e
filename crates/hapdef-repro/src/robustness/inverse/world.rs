//! The limb that rows are on, and what is measured of an answer.

use std::collections::BTreeMap;
use std::sync::Arc;

use hapdef_bench::robustness::MustHold;
use hapdef_inverse::{
    AtWall, ContactEstimate, ContactEstimator, EstimatorParams, InverseError, NoiseParams,
    ResponseMap, ScanSites, SkinPoint, Verdict,
};
use nalgebra::Point3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::error::ReproError;

const N_SITES: usize = 400;

/// Standard deviation of every reading's noise, µε.
pub(super) const SD: f64 = 1.0;

/// Contacts whose readings have less χ² than this are in the noise.
const UNSEEN_CHI2: f64 = 40.0;

/// An answer is right within this, m.
const RIGHT_M: f64 = 0.01;

/// No answer is asked to be better than this, m.
const FINE_M: f64 = 2e-4;

/// A limb with gauges.
#[derive(Clone, Debug)]
pub struct InverseWorld {
    pub(super) map: Arc<ResponseMap>,
    pub(super) sites: Arc<ScanSites>,
    clamped_m: Arc<[Point3<f64>]>,
    seed: u64,
}

impl InverseWorld {
    /// A limb with its response, µε/N, the places where it is held, m, and the seed of what rows draw.
    pub fn new(
        map: ResponseMap,
        clamped_m: Arc<[Point3<f64>]>,
        seed: u64,
    ) -> Result<Self, ReproError> {
        let sites = ScanSites::farthest(map.skin(), N_SITES)?;
        Ok(Self { map: Arc::new(map), sites: Arc::new(sites), clamped_m, seed })
    }

    pub(super) fn n(&self) -> usize {
        self.map.n_gauges()
    }

    /// The same limb whose gauge i is `of(i)`: one of these gauges, and a factor.
    pub(super) fn regauged(
        &self,
        of: impl Fn(usize) -> (usize, f64),
    ) -> Result<Self, InverseError> {
        let nodal = self.map.nodal();
        let rows = nodal.chunks_exact(self.n());
        let changed = rows.flat_map(|row| {
            let gauge = |i| row[of(i).0] * of(i).1;
            (0..row.len()).map(gauge).collect::<Vec<_>>()
        });
        let skin = self.map.skin().clone();
        let adjoint: Vec<_> = changed.collect();
        Ok(Self {
            map: Arc::new(ResponseMap::from_values(skin, self.n(), &adjoint)?),
            ..self.clone()
        })
    }

    /// An estimator that assumes noise of `sd`.
    pub(super) fn estimator(&self, sd: f64) -> Result<ContactEstimator, InverseError> {
        self.estimator_with(NoiseParams::uniform(self.n(), sd))
    }

    pub(super) fn estimator_with(
        &self,
        noise: NoiseParams,
    ) -> Result<ContactEstimator, InverseError> {
        let params = EstimatorParams::default();
        ContactEstimator::new(self.map.clone(), self.sites.clone(), noise, params)
    }

    /// A row's own stream.
    pub(super) fn rng(&self, row: u64) -> ChaCha8Rng {
        ChaCha8Rng::seed_from_u64(self.seed.wrapping_add(row))
    }

    /// Readings of the map itself, without noise.
    pub(super) fn readings(&self, contacts: &[(SkinPoint, f64)]) -> Vec<f64> {
        let mut y = vec![0.0; self.n()];
        for (point, force_n) in contacts {
            for (y, g) in y.iter_mut().zip(self.map.normal(point)) {
                *y += force_n * g;
            }
        }
        y
    }

    /// Scan sites drawn at random, at least `gap_m` apart.
    pub(super) fn draw(&self, n: usize, gap_m: f64, rng: &mut ChaCha8Rng) -> Vec<SkinPoint> {
        let mut drawn: Vec<SkinPoint> = Vec::new();
        while drawn.len() < n {
            let point = self.sites.points()[rng.random_range(0..self.sites.len())];
            let is_apart = |other: &SkinPoint| self.gap_m(other, &point) >= gap_m;
            if drawn.iter().all(is_apart) {
                drawn.push(point);
            }
        }
        drawn
    }

    /// `n` contacts of `force_n` each, 20 mm apart, and their readings with noise of [`SD`].
    pub(super) fn noisy(
        &self,
        n: usize,
        force_n: f64,
        rng: &mut ChaCha8Rng,
    ) -> (Vec<SkinPoint>, Vec<f64>) {
        let truth = self.draw(n, 0.02, rng);
        let contacts: Vec<_> = truth.iter().map(|p| (*p, force_n)).collect();
        let mut y = self.readings(&contacts);
        add_noise(&mut y, SD, rng);
        (truth, y)
    }

    pub(super) fn gap_m(&self, a: &SkinPoint, b: &SkinPoint) -> f64 {
        (self.map.skin().position(a) - self.map.skin().position(b)).norm()
    }

    /// A point at `gap_m` from `start` along the skin, in the first direction in which there is one at
    /// three quarters of it as the crow flies.
    pub(super) fn beside(&self, start: &SkinPoint, gap_m: f64) -> Option<SkinPoint> {
        let skin = self.map.skin();
        let [t1, t2] = skin.tangents(start);
        let ends = [t1, t2, -t1, -t2].map(|t| skin.walk(start, &(t * gap_m), AtWall::Slide).point);
        let is_far = |end: &SkinPoint| self.gap_m(start, end) >= 0.75 * gap_m;
        ends.into_iter().find(is_far)
    }

    /// Corners on the skin's rim, those nearest to where the limb is held first.
    pub(super) fn rim(&self) -> Vec<SkinPoint> {
        let skin = self.map.skin();
        let mut edges: BTreeMap<[u32; 2], usize> = BTreeMap::new();
        for face in 0..skin.n_faces() {
            let nodes = skin.face_nodes(face);
            for i in 0..3 {
                let (a, b) = (nodes[i], nodes[(i + 1) % 3]);
                *edges.entry([a.min(b), a.max(b)]).or_default() += 1;
            }
        }
        let open = edges.into_iter().filter(|(_, n)| *n == 1);
        let mut nodes: Vec<u32> = open.flat_map(|(edge, _)| edge).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let points = skin.node_points();
        let far = |point: &SkinPoint| {
            let x = skin.position(point);
            let gaps = self.clamped_m.iter().map(|held| (held - x).norm());
            gaps.fold(f64::INFINITY, f64::min)
        };
        let on_skin = nodes.iter().filter_map(|&node| points[node as usize]);
        let mut rim: Vec<(f64, SkinPoint)> = on_skin.map(|p| (far(&p), p)).collect();
        rim.sort_by(|a, b| a.0.total_cmp(&b.0));
        rim.into_iter().map(|(_, point)| point).collect()
    }
}

pub(super) fn add_noise(y: &mut [f64], sd: f64, rng: &mut ChaCha8Rng) {
    for y in y {
        let n: f64 = StandardNormal.sample(rng);
        *y += sd * n;
    }
}

/// The answer to a frame, or an error where the answer says that it is none; `None` where it holds
/// what is not a number.
pub(super) fn sure(
    estimator: &ContactEstimator,
    y: &[f64],
) -> Result<Option<ContactEstimate>, ReproError> {
    let found = estimator.estimate(y)?;
    let of_contacts = found.contacts.iter().all(|c| {
        c.position_m.iter().all(|x| x.is_finite())
            && c.force_n.is_finite()
            && c.covariance.iter().all(|v| v.is_finite())
    });
    let of_frame = found.chi2.is_finite() && found.residual.iter().all(|r| r.is_finite());
    if !of_contacts || !of_frame {
        return Ok(None);
    }
    match found.verdict {
        Verdict::NotIdentifiable(why) => Err(ReproError::NotIdentifiable { why }),
        Verdict::Untouched | Verdict::Identified => Ok(Some(found)),
    }
}

/// Distance of one contact found from the true one over its standard deviation; infinite for
/// another count, unless the readings are in the noise.
fn single_sds(
    world: &InverseWorld,
    estimator: &ContactEstimator,
    truth: (SkinPoint, f64),
    y: &[f64],
) -> Result<f64, ReproError> {
    let Some(found) = sure(estimator, y)? else {
        return Ok(f64::NAN);
    };
    let skin = world.map.skin();
    Ok(match found.contacts.as_slice() {
        [] if found.chi2_untouched < UNSEEN_CHI2 => 0.0,
        [one] => {
            let variance = one.covariance[(0, 0)] + one.covariance[(1, 1)];
            (one.position_m - skin.position(&truth.0)).norm() / variance.sqrt().max(FINE_M)
        }
        _ => f64::INFINITY,
    })
}

/// The worst of [`single_sds`] of contacts at these points, readings exact.
pub(super) fn worst_single(
    world: &InverseWorld,
    points: &[SkinPoint],
    force_n: f64,
) -> Result<f64, ReproError> {
    let estimator = world.estimator(SD)?;
    worst(points.iter().map(|point| {
        let truth = (*point, force_n);
        single_sds(world, &estimator, truth, &world.readings(&[truth]))
    }))
}

/// Whether χ² could not tell readings from noise.
pub(super) fn is_unseen(y: &[f64]) -> bool {
    y.iter().map(|y| (y / SD).powi(2)).sum::<f64>() < UNSEEN_CHI2
}

/// What the wrong ones of the sure answers must be, and of all frames.
pub(super) const WRONG: MustHold =
    ("at most 5 % of the sure answers are wrong in count or by over 10 mm", 0.05);
pub(super) const SURE_AND_WRONG: MustHold =
    ("at most 1 % of the frames are sure and wrong in count or by over 10 mm", 0.01);

/// Answers to frames of contacts.
pub(super) struct Answers {
    n: usize,
    n_sure: usize,
    /// Sure, with another count than the truth's or with a contact that is not where it is found; no
    /// number where an answer has one that is none.
    n_wrong: f64,
}

impl Answers {
    /// Part of the sure answers that is wrong.
    pub(super) fn wrong_share(self) -> f64 {
        self.n_wrong / self.n_sure.max(1) as f64
    }

    /// Part of the frames whose answer is sure and wrong.
    pub(super) fn sure_and_wrong_share(self) -> f64 {
        self.n_wrong / self.n.max(1) as f64
    }
}

/// Answers to `frames`; where none is sure, the reason. Contacts in the noise may be missed.
pub(super) fn answers(
    world: &InverseWorld,
    estimator: &ContactEstimator,
    frames: impl Iterator<Item = (Vec<SkinPoint>, Vec<f64>)>,
) -> Result<Answers, ReproError> {
    let mut n = 0;
    let wrong = sure_ones(frames.map(|(truth, y)| {
        n += 1;
        let Some(found) = sure(estimator, &y)? else {
            return Ok(f64::NAN);
        };
        let is_missed = found.contacts.is_empty() && is_unseen(&y);
        let is_wrong = !is_missed && !is_right(world, &truth, &found);
        Ok(f64::from(u8::from(is_wrong)))
    }))?;
    Ok(Answers { n, n_sure: wrong.len(), n_wrong: wrong.iter().sum() })
}

fn is_right(world: &InverseWorld, truth: &[SkinPoint], found: &ContactEstimate) -> bool {
    let skin = world.map.skin();
    let is_near = |point: &SkinPoint| {
        let x = skin.position(point);
        let near = |c: &hapdef_inverse::LocatedContact| (c.position_m - x).norm() <= RIGHT_M;
        found.contacts.iter().any(near)
    };
    found.contacts.len() == truth.len() && truth.iter().all(is_near)
}

/// The worst of the sure metrics, one that is no number before any; where none is sure, the reason.
pub(super) fn worst(
    metrics: impl Iterator<Item = Result<f64, ReproError>>,
) -> Result<f64, ReproError> {
    let worse = |worst: f64, metric: f64| {
        if metric.is_nan() || metric > worst { metric } else { worst }
    };
    Ok(sure_ones(metrics)?.into_iter().reduce(worse).unwrap_or(f64::NAN))
}

/// What is sure; where nothing is, the reason.
fn sure_ones(all: impl Iterator<Item = Result<f64, ReproError>>) -> Result<Vec<f64>, ReproError> {
    let (mut sure, mut refused) = (Vec::new(), None);
    for one in all {
        match one {
            Ok(one) => sure.push(one),
            Err(why @ ReproError::NotIdentifiable { .. }) => refused = Some(why),
            Err(error) => return Err(error),
        }
    }
    match refused {
        Some(why) if sure.is_empty() => Err(why),
        _ => Ok(sure),
    }
}
