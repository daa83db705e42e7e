//! What a scene's gauges can tell about contacts: bounds on the limb, and how many they carry.

use std::sync::Arc;

use hapdef_bench::stats;
use hapdef_inverse::{
    Carried, ContactBound, ContactEstimator, EstimatorParams, LimitParams, NoiseParams, OtherLoads,
    ResponseMap, ScanSites, SkinPoint, carried_contacts, joint_bounds, single_bounds,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::error::HapdefError;

/// Draws of a second contact for each that is wanted, before a small skin gives up.
const MAX_TRIES: usize = 50;

/// What is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitsRequest {
    /// Standard deviation of a reading's noise, µε.
    pub noise_ue: f64,
    /// Scan sites that contacts are drawn from.
    pub n_sites: usize,
    /// Second contacts drawn for each node of the skin.
    pub n_partners: usize,
    /// Force, spacing, draws and what counts as usable.
    pub carried: LimitParams,
}

/// Cramér–Rao bounds of a layout; none of any unbiased estimator does better.
#[derive(Clone, Debug, PartialEq)]
pub struct LimitsReport {
    /// Bound of the position of one contact at each surface node `[n_surface]`, m; infinite where
    /// the readings don't determine it (a blind spot), and at nodes no contact may be on.
    pub single_m: Vec<f64>,
    /// Bound of the force there `[n_surface]`, N.
    pub single_n: Vec<f64>,
    /// Median bound of the position there while a second contact of the same force is somewhere
    /// else `[n_surface]`, m.
    pub pair_m: Vec<f64>,
    /// Surface nodes whose single bound is infinite or beyond what is usable.
    pub blind_nodes: Vec<usize>,
    /// How many contacts the layout carries.
    pub carried: Vec<Carried>,
    /// Median bound of the position of one contact over the sites if there were no loads, m; none where there are
    /// none.
    pub unloaded_m: Option<f64>,
}

impl LimitsReport {
    /// Quantile of the finite and infinite single bounds, m.
    #[must_use]
    pub fn single_quantile_m(&self, q: f64) -> f64 {
        bound_quantile(&self.single_m, q)
    }

    /// The same of the pair bounds, m.
    #[must_use]
    pub fn pair_quantile_m(&self, q: f64) -> f64 {
        bound_quantile(&self.pair_m, q)
    }
}

/// The bound at share `q` of all; infinite if there are none.
fn bound_quantile(bounds_m: &[f64], q: f64) -> f64 {
    let rising = stats::sorted(bounds_m.iter().copied());
    if rising.is_empty() { f64::INFINITY } else { stats::quantile(&rising, q) }
}

/// The bounds of a response map in µε/N at every node of its skin, beside `loads` that are no contacts.
///
/// # Errors
/// [`HapdefError::Inverse`] with fewer than three gauges or for a value out of range.
pub fn limits(
    map: ResponseMap,
    loads: OtherLoads,
    request: &LimitsRequest,
) -> Result<LimitsReport, HapdefError> {
    let sites = ScanSites::farthest(map.skin(), request.n_sites)?;
    let noise = NoiseParams { loads, ..NoiseParams::uniform(map.n_gauges(), request.noise_ue) };
    let partners = sites.points().to_vec();
    let nodes = map.skin().node_points();
    let params = EstimatorParams::default();
    let estimator = ContactEstimator::new(Arc::new(map), Arc::new(sites), noise, params)?;
    let mut report = LimitsReport {
        single_m: Vec::with_capacity(nodes.len()),
        single_n: Vec::with_capacity(nodes.len()),
        pair_m: Vec::with_capacity(nodes.len()),
        blind_nodes: Vec::new(),
        carried: carried_contacts(&estimator, &request.carried)?,
        unloaded_m: unloaded_m(&estimator, request)?,
    };
    let mut pairs = Pairs {
        estimator: &estimator,
        partners: &partners,
        request,
        rng: ChaCha8Rng::seed_from_u64(request.carried.seed),
    };
    for (node, point) in nodes.iter().enumerate() {
        let bound = match point {
            Some(point) => pairs.bound(&[*point])?,
            None => None,
        };
        let (metres, newtons) =
            bound.map_or((f64::INFINITY, f64::INFINITY), |b| (b.position_sd_m, b.force_sd_n));
        let is_usable = metres <= request.carried.usable_sd_m;
        report.blind_nodes.extend(Some(node).filter(|_| !is_usable && point.is_some()));
        report.single_m.push(metres);
        report.single_n.push(newtons);
        let pair = match point {
            Some(point) => pairs.median(point)?,
            None => f64::INFINITY,
        };
        report.pair_m.push(pair);
    }
    Ok(report)
}

fn unloaded_m(
    estimator: &ContactEstimator,
    request: &LimitsRequest,
) -> Result<Option<f64>, HapdefError> {
    if estimator.loads().is_empty() {
        return Ok(None);
    }
    let unloaded = estimator.with_loads(OtherLoads::default())?;
    let bounds = single_bounds(&unloaded, request.carried.force_n)?;
    let bounds_m = bounds.into_iter().map(|b| b.map_or(f64::INFINITY, |b| b.position_sd_m));
    Ok(Some(stats::median(bounds_m)))
}

/// Bounds with drawn second contacts.
struct Pairs<'a> {
    estimator: &'a ContactEstimator,
    partners: &'a [SkinPoint],
    request: &'a LimitsRequest,
    rng: ChaCha8Rng,
}

impl Pairs<'_> {
    /// The bound of the first of `points`.
    fn bound(&self, points: &[SkinPoint]) -> Result<Option<ContactBound>, HapdefError> {
        let force_n = self.request.carried.force_n;
        let contacts: Vec<_> = points.iter().map(|p| (*p, force_n)).collect();
        Ok(joint_bounds(self.estimator, &contacts)?.map(|bounds| bounds[0]))
    }

    fn median(&mut self, point: &SkinPoint) -> Result<f64, HapdefError> {
        let skin = self.estimator.map().skin();
        let x = skin.position(point);
        let mut found = Vec::with_capacity(self.request.n_partners);
        for _ in 0..MAX_TRIES * self.request.n_partners {
            if found.len() == self.request.n_partners {
                break;
            }
            let partner = self.partners[self.rng.random_range(0..self.partners.len())];
            let is_apart = (skin.position(&partner) - x).norm() >= self.request.carried.min_gap_m;
            if is_apart {
                let bound = self.bound(&[*point, partner])?;
                found.push(bound.map_or(f64::INFINITY, |b| b.position_sd_m));
            }
        }
        Ok(bound_quantile(&found, 0.5))
    }
}
