//! What a layout can measure: Fisher information and Cramér–Rao bounds.

use crate::dense::{cholesky, inverse, log_det};
use crate::error::{InverseError, check_positive};
use crate::estimator::{ContactEstimator, Explanation, Linear, MAX_CONTACTS};
use crate::placement::Draws;
use crate::skin_point::SkinPoint;

/// Relative pivot of the scaled information below which it counts as singular.
const LEAST_PIVOT: f64 = 1e-10;

/// The least standard deviations that any unbiased estimate of a contact can have
/// (Cramér–Rao; Kay, Fundamentals of Statistical Signal Processing, vol. I, 1993, chapter 3), the
/// covariance taken as known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactBound {
    /// Where.
    pub point: SkinPoint,
    /// √(σ₁² + σ₂²) of the position on the surface, m.
    pub position_sd_m: f64,
    /// Of the force, N.
    pub force_sd_n: f64,
    /// ln det of the information of the set of contacts that it is of, in m and N.
    pub log_det: f64,
}

/// What [`carried_contacts`] asks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitParams {
    /// Force of every contact, N.
    pub force_n: f64,
    /// Least distance of two contacts, m.
    pub min_gap_m: f64,
    /// Sets of contacts drawn for each count.
    pub n_draws: usize,
    /// Seed of the draws.
    pub seed: u64,
    /// A count is carried if the median bound of the position is at most this, m.
    pub usable_sd_m: f64,
}

impl Default for LimitParams {
    fn default() -> Self {
        Self { force_n: 10.0, min_gap_m: 0.012, n_draws: 400, seed: 1, usable_sd_m: 0.005 }
    }
}

/// Bounds for one number of contacts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Carried {
    /// Number of contacts.
    pub n_contacts: usize,
    /// Median of the position's bound over drawn contacts, m; infinite if most are singular.
    pub median_sd_m: f64,
    /// 95th percentile of the position's bound, m; infinite if 5 % are singular.
    pub p95_sd_m: f64,
    /// Share of draws whose information is singular.
    pub singular_share: f64,
    /// Whether the median is usable.
    pub is_carried: bool,
}

/// The bound for one contact of `force_n` at each scan site `[n_sites]`; `None` at blind spots,
/// where the information is singular.
///
/// # Errors
/// [`InverseError::Parameter`] for a force that is not positive.
pub fn single_bounds(
    estimator: &ContactEstimator,
    force_n: f64,
) -> Result<Vec<Option<ContactBound>>, InverseError> {
    check_positive("force_n", force_n)?;
    let model = &estimator.model;
    let mut linear = Linear::new(model);
    let mut bound = |point: &SkinPoint| {
        bounds_of(estimator, &[(*point, force_n)], &mut linear).map(|found| found[0])
    };
    Ok(model.sites.points().iter().map(&mut bound).collect())
}

/// The bounds of several contacts at once, (place, force in N) each; `None` if the readings do not
/// determine them.
///
/// # Errors
/// [`InverseError::TooManyContacts`]; [`InverseError::Parameter`] for a force that is not positive.
pub fn joint_bounds(
    estimator: &ContactEstimator,
    contacts: &[(SkinPoint, f64)],
) -> Result<Option<Vec<ContactBound>>, InverseError> {
    let (found, most) = (contacts.len(), MAX_CONTACTS);
    if found > most {
        return Err(InverseError::TooManyContacts { found, most });
    }
    for (_, force_n) in contacts {
        check_positive("force_n", *force_n)?;
    }
    let mut linear = Linear::new(&estimator.model);
    Ok(bounds_of(estimator, contacts, &mut linear))
}

/// How many contacts the layout carries: bounds for 1, 2, … contacts at drawn scan sites, as long as
/// there are three live gauges for each.
///
/// # Errors
/// [`InverseError::Parameter`] for an unusable parameter.
pub fn carried_contacts(
    estimator: &ContactEstimator,
    params: &LimitParams,
) -> Result<Vec<Carried>, InverseError> {
    check_positive("force_n", params.force_n)?;
    check_positive("n_draws", params.n_draws as f64)?;
    check_positive("usable_sd_m", params.usable_sd_m)?;
    let most = (estimator.model.m / 3).min(MAX_CONTACTS);
    let mut linear = Linear::new(&estimator.model);
    let mut rng = Draws::new(params.seed);
    let carried = (1..=most).map(|n| carried_by(estimator, n, params, &mut rng, &mut linear));
    Ok(carried.collect())
}

fn carried_by(
    estimator: &ContactEstimator,
    n_contacts: usize,
    params: &LimitParams,
    rng: &mut Draws,
    linear: &mut Linear,
) -> Carried {
    let mut sds = Vec::with_capacity(params.n_draws * n_contacts);
    let mut n_singular = 0;
    for _ in 0..params.n_draws {
        let contacts = draw(estimator, n_contacts, params, rng);
        match bounds_of(estimator, &contacts, linear) {
            Some(bounds) => sds.extend(bounds.iter().map(|b| b.position_sd_m)),
            None => {
                n_singular += 1;
                sds.extend((0..n_contacts).map(|_| f64::INFINITY));
            }
        }
    }
    sds.sort_by(f64::total_cmp);
    let quantile = |q: f64| sds[((sds.len() - 1) as f64 * q).round() as usize];
    Carried {
        n_contacts,
        median_sd_m: quantile(0.5),
        p95_sd_m: quantile(0.95),
        singular_share: n_singular as f64 / params.n_draws as f64,
        is_carried: quantile(0.5) <= params.usable_sd_m,
    }
}

/// Different sites, at least the gap apart where a few tries find such.
fn draw(
    estimator: &ContactEstimator,
    n: usize,
    params: &LimitParams,
    rng: &mut Draws,
) -> Vec<(SkinPoint, f64)> {
    let sites = &estimator.model.sites;
    let mut chosen: Vec<usize> = Vec::new();
    for attempt in 0..200 * n {
        if chosen.len() == n {
            break;
        }
        let site = rng.below(sites.len());
        let x = sites.positions()[site];
        let gap = |other: &usize| (sites.positions()[*other] - x).norm();
        let is_apart = chosen.iter().all(|other| gap(other) >= params.min_gap_m);
        if is_apart || attempt >= 100 * n {
            chosen.push(site);
        }
    }
    let contact = |site: usize| (sites.points()[site], params.force_n);
    chosen.into_iter().map(contact).collect()
}

fn bounds_of(
    estimator: &ContactEstimator,
    contacts: &[(SkinPoint, f64)],
    linear: &mut Linear,
) -> Option<Vec<ContactBound>> {
    let points: Vec<_> = contacts.iter().map(|c| c.0).collect();
    let mut e = Explanation::new(&points);
    for (force, contact) in e.forces.iter_mut().zip(contacts) {
        *force = contact.1;
    }
    linear.inform(&estimator.model, &mut e);
    let n = 3 * e.n;
    let (covariance, log_det) = inverted(&linear.a[..n * n], n)?;
    let bound = |i: usize| {
        let variance = |q: usize| covariance[q * (n + 1)].max(0.0);
        ContactBound {
            point: points[i],
            position_sd_m: (variance(3 * i) + variance(3 * i + 1)).sqrt(),
            force_sd_n: variance(3 * i + 2).sqrt(),
            log_det,
        }
    };
    Some((0..e.n).map(bound).collect())
}

/// a⁻¹ and ln det a of the information `a`, scaled to a unit diagonal first; `None` if singular.
fn inverted(a: &[f64], n: usize) -> Option<(Vec<f64>, f64)> {
    let scale: Vec<f64> = (0..n).map(|p| a[p * (n + 1)].sqrt()).collect();
    if !scale.iter().all(|s| s.is_normal()) {
        return None;
    }
    let mut l: Vec<f64> = (0..n * n).map(|k| a[k] / (scale[k / n] * scale[k % n])).collect();
    if !cholesky(&mut l, n, LEAST_PIVOT) {
        return None;
    }
    let mut covariance = vec![0.0; n * n];
    inverse(&l, n, &mut covariance);
    for (k, c) in covariance.iter_mut().enumerate() {
        *c /= scale[k / n] * scale[k % n];
    }
    let of_scale: f64 = scale.iter().map(|s| 2.0 * s.ln()).sum();
    Some((covariance, log_det(&l, n) + of_scale))
}
