//! Whether an answer is honest about what was pressed.

use hapdef::HapdefError;
use hapdef_inverse::{ContactEstimate, InverseError, LocatedContact, SkinPoint, Verdict};
use hapdef_live::LiveError;
use nalgebra::{DMatrix, DVector};

use super::pressed::{Press, Pressed, chi2, chi2_misfit, chi2_touch};
use super::trial::Trial;

/// Standard deviations that a sure answer may be off, and the least that counts: m, and a share of
/// the force.
const MOST_SD: f64 = 6.0;
const LEAST_M: f64 = 2e-4;
const LEAST_SHARE: f64 = 1e-3;

/// An honest end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Honest {
    /// Every press found, where and as strong as claimed.
    Found,
    /// One contact for two presses, all of it within what it tells of itself if it is two.
    OneForTwo,
    /// What was not found is below what χ² can see.
    BelowNoise,
    /// It says that it is not sure.
    NotSure,
    /// A typed error that the scene deserves.
    Refused,
    /// The presses are nearer each other than the scene allows.
    TooNear,
}

/// A silently wrong end.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Wrong {
    /// An error.
    #[error("an error that this scene does not deserve: {0}")]
    Error(HapdefError),
    /// NaN or an infinity.
    #[error("a number of a contact is not finite")]
    NotFinite,
    /// A press that the readings show.
    #[error("a press is missed that χ² shows: {chi2:.1}, {most:.1} may be")]
    Missed { chi2: f64, most: f64 },
    /// More contacts than presses.
    #[error("{found} contacts are found, more than there are presses")]
    TooMany { found: usize },
    /// A contact that is not where, or not as strong as, it claims.
    #[error("a contact is off by {times:.2} times what its standard deviations allow")]
    Off { times: f64 },
}

/// Makes the scene, presses it, and judges what the estimator says.
pub(crate) fn tried(trial: &Trial) -> Result<Honest, Wrong> {
    let folder = tempfile::tempdir().unwrap();
    let pressed = match Pressed::new(folder.path(), trial) {
        Err(error) if is_deserved(trial, &error) => return Ok(Honest::Refused),
        made => made.map_err(Wrong::Error)?,
    };
    let estimate = pressed.estimator.estimate(&pressed.readings_ue);
    let estimate = estimate.map_err(|error| Wrong::Error(error.into()))?;
    judged(&pressed, &estimate)
}

/// Fewer than three gauges, or one that lies off this limb's wall.
fn is_deserved(trial: &Trial, error: &HapdefError) -> bool {
    match error {
        HapdefError::Live(LiveError::Inverse(InverseError::TooFewGauges { .. })) => {
            trial.n_gauges < 3
        }
        HapdefError::Gauge { .. } => true,
        _ => false,
    }
}

/// Whether `estimate` is honest about the presses.
pub(crate) fn judged(pressed: &Pressed, estimate: &ContactEstimate) -> Result<Honest, Wrong> {
    let (contacts, presses) = (&estimate.contacts[..], &pressed.presses[..]);
    if !contacts.iter().all(is_finite) {
        return Err(Wrong::NotFinite);
    }
    if let [a, b] = presses
        && (a.position_m - b.position_m).norm() < pressed.min_spacing_m
    {
        return Ok(Honest::TooNear);
    }
    if matches!(estimate.verdict, Verdict::NotIdentifiable(_)) {
        return Ok(Honest::NotSure);
    }
    if contacts.is_empty() {
        return below_noise(pressed);
    }
    match as_claimed(pressed, contacts) {
        Err(_) if stands_for_two(estimate, presses) => Ok(Honest::OneForTwo),
        end => end,
    }
}

/// Each contact where and as strong as claimed, and no press is left that the readings show.
fn as_claimed(pressed: &Pressed, contacts: &[LocatedContact]) -> Result<Honest, Wrong> {
    let (missed, times) = matched(contacts, &pressed.presses)?;
    if times > 1.0 {
        return Err(Wrong::Off { times });
    }
    match (missed, contacts) {
        (None, _) => Ok(Honest::Found),
        (Some(missed), [found]) => hidden(pressed, found, missed),
        (Some(_), _) => unreachable!("two presses at most"),
    }
}

/// One contact whose place if it is two holds both presses, and its force then their sum.
fn stands_for_two(estimate: &ContactEstimate, presses: &[Press]) -> bool {
    let ([found], [if_two], [a, b]) = (&estimate.contacts[..], &estimate.if_two[..], presses)
    else {
        return false;
    };
    let far_m = |press: &Press| (found.position_m - press.position_m).norm();
    let off_n = (found.force_n - a.force_n - b.force_n).abs();
    far_m(a).max(far_m(b)) <= MOST_SD * if_two.position_sd_m && off_n <= MOST_SD * if_two.force_sd_n
}

fn is_finite(contact: &LocatedContact) -> bool {
    let numbers = contact.position_m.coords.iter().chain(&contact.covariance);
    contact.force_n.is_finite() && numbers.into_iter().all(|v| v.is_finite())
}

/// Nothing found: the presses, or they and the noise, are no touch by the estimator's own limit.
fn below_noise(pressed: &Pressed) -> Result<Honest, Wrong> {
    let n_gauges = pressed.readings_ue.len();
    let mut adds = vec![0.0; n_gauges];
    for press in &pressed.presses {
        adds.iter_mut().zip(&press.adds_ue).for_each(|(sum, add)| *sum += add);
    }
    let seen = [&adds, &pressed.readings_ue].map(|values| chi2(values, pressed.noise_ue));
    within(seen, chi2_touch(n_gauges))
}

/// Each contact with a press of its own, so that the worst is as near as can be: the press left over
/// and how far the worst is off, over what is allowed.
fn matched<'a>(
    contacts: &[LocatedContact],
    presses: &'a [Press],
) -> Result<(Option<&'a Press>, f64), Wrong> {
    let off = |i: usize, j: usize| times_off(&contacts[i], &presses[j]);
    let ways: Vec<(Option<&Press>, f64)> = match (contacts.len(), presses.len()) {
        (1, 1) => vec![(None, off(0, 0))],
        (1, 2) => vec![(Some(&presses[1]), off(0, 0)), (Some(&presses[0]), off(0, 1))],
        (2, 2) => [[0, 1], [1, 0]].map(|[i, j]| (None, off(0, i).max(off(1, j)))).to_vec(),
        (found, _) => return Err(Wrong::TooMany { found }),
    };
    let best = ways.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
    Ok(best.unwrap_or((None, 0.0)))
}

/// Distance and difference of force over what the contact's own standard deviations allow.
fn times_off(contact: &LocatedContact, press: &Press) -> f64 {
    let place = contact.covariance.fixed_view::<2, 2>(0, 0).into_owned();
    let sd_m = place.symmetric_eigenvalues().max().max(0.0).sqrt();
    let sd_n = contact.covariance[(2, 2)].max(0.0).sqrt();
    let off_m = (contact.position_m - press.position_m).norm();
    let off_n = (contact.force_n - press.force_n).abs();
    let by_place = off_m / (MOST_SD * sd_m + LEAST_M);
    by_place.max(off_n / (MOST_SD * sd_n + LEAST_SHARE * press.force_n))
}

/// One of two found: what the other adds, or it and the noise, less what the found one's place and
/// force can take up, is no misfit by the estimator's own limit. The noise has the map's error at the
/// found contact's force.
fn hidden(pressed: &Pressed, found: &LocatedContact, missed: &Press) -> Result<Honest, Wrong> {
    let map = pressed.estimator.map();
    let n_gauges = map.n_gauges();
    let sds = sds_beside(pressed, found);
    let scaled = |values: &[f64]| {
        let each = values.iter().zip(&sds).map(|(v, sd)| v / sd);
        DVector::from_iterator(n_gauges, each)
    };
    let [along, across] = map.normal_gradient(&found.point);
    let columns = [map.normal(&found.point), along, across].map(|column| scaled(&column));
    let taken = DMatrix::from_columns(&columns).qr().q();
    let left = |values: &[f64]| {
        let values = scaled(values);
        (&values - &taken * (taken.transpose() * &values)).norm_squared()
    };
    let others = pressed.presses.iter().filter(|p| !std::ptr::eq(*p, missed));
    let mut with_noise = pressed.readings_ue.clone();
    for press in others {
        with_noise.iter_mut().zip(&press.adds_ue).for_each(|(sum, add)| *sum -= add);
    }
    let seen = [left(&missed.adds_ue), left(&with_noise)];
    within(seen, chi2_misfit(n_gauges - 3))
}

/// Standard deviation of each reading beside a contact, µε: noise, and the map's error as
/// [`hapdef_inverse::ModelError::relative`] has it.
fn sds_beside(pressed: &Pressed, found: &LocatedContact) -> Vec<f64> {
    let map = pressed.estimator.map();
    let n_gauges = map.n_gauges();
    let points: Vec<SkinPoint> = map.skin().node_points().into_iter().flatten().collect();
    let mut squares = vec![0.0; n_gauges];
    for point in &points {
        let each = squares.iter_mut().zip(map.normal(point));
        each.for_each(|(sum, g)| *sum += g * g / points.len() as f64);
    }
    let g = map.normal(&found.point);
    let shares = g.iter().zip(&squares).map(|(g, s2)| g * g / s2);
    let q = shares.sum::<f64>() / n_gauges as f64;
    let each = g.iter().zip(&squares).map(|(g, s2)| {
        let error = 0.5 * (pressed.map_error * found.force_n).powi(2) * (g * g + s2 * q);
        (pressed.noise_ue.powi(2) + error).sqrt()
    });
    each.collect()
}

fn within(seen: [f64; 2], most: f64) -> Result<Honest, Wrong> {
    let chi2 = seen[0].min(seen[1]);
    if chi2 <= most { Ok(Honest::BelowNoise) } else { Err(Wrong::Missed { chi2, most }) }
}
