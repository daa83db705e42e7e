//! One contact wider than the map's tip, such as a palm, where narrow ones leave a doubt.

use std::sync::Arc;

use hapdef_contact::{ContactRadius, Verdict};
use nalgebra::Vector3;

use crate::basis;
use crate::error::{InverseError, check_not_negative, check_positive};
use crate::estimator::output::ContactEstimate;
use crate::estimator::{ContactEstimator, EstimatorParams};
use crate::response::{ResponseMap, ResponseParams};
use crate::skin_point::SkinPoint;

/// From one radius to the next, between which maps are mixed.
const STEP: f64 = 4.0 / 3.0;

/// The radius from which they rise where the map's tip is narrower, m: below, a wider tip reads as a narrow one.
const LEAST_M: f64 = 3e-3;

/// A wide contact has to be better in −2 ln evidence than the narrow ones by this, odds of e² against it: each radius
/// is a further chance for noise, though hardly one of its own.
const MARGIN: f64 = 4.0;

/// How wide contacts are looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WideParams {
    /// Radius of the tip that is in the map, m.
    pub tip_radius_m: f64,
    /// The widest radius that is looked for, m.
    pub widest_m: f64,
}

/// One contact of each of some radii.
#[derive(Clone, Debug, Default)]
pub(crate) struct Wide {
    radii_m: Vec<f64>,
    estimators: Vec<ContactEstimator>,
}

impl WideParams {
    /// Contacts up to `widest_m`, where that is wider than the map's tip.
    #[must_use]
    pub fn up_to(widest_m: f64, tip_radius_m: f64) -> Option<Self> {
        (widest_m > tip_radius_m).then_some(Self { tip_radius_m, widest_m })
    }

    pub(crate) fn check(&self) -> Result<(), InverseError> {
        check_not_negative("wide.tip_radius_m", self.tip_radius_m)?;
        check_positive("wide.widest_m less wide.tip_radius_m", self.widest_m - self.tip_radius_m)
    }

    /// Three or more, rising, the last two beyond the widest: the best of them is mixed with those on both sides.
    fn radii_m(&self) -> Vec<f64> {
        let first_m = self.tip_radius_m.max(LEAST_M) * STEP;
        let mut radii_m = vec![first_m, first_m * STEP, first_m * STEP.powi(2)];
        while radii_m[radii_m.len() - 2] < self.widest_m {
            radii_m.push(radii_m[radii_m.len() - 1] * STEP);
        }
        radii_m
    }
}

impl Wide {
    /// The map under a wide tip is the mean of the map under the tips that it has, at the nodes of the skin; its
    /// error is taken to be that of the map.
    pub(crate) fn new(
        narrow: &ContactEstimator,
        params: &WideParams,
    ) -> Result<Self, InverseError> {
        let radii_m = params.radii_m();
        let map = narrow.map();
        let nodal = at_nodes(map);
        let wide = radii_m.iter().map(|radius_m| {
            // second moments of pressures add up
            let added_m = (radius_m.powi(2) - params.tip_radius_m.powi(2)).sqrt();
            let wider = ResponseParams { tip_radius_m: added_m };
            let map = ResponseMap::from_nodal(map.skin().clone(), map.n_gauges(), &nodal, &wider)?;
            let single = EstimatorParams { known_count: Some(1), wide: None, ..narrow.params };
            let sites = narrow.model.sites.clone();
            ContactEstimator::new(Arc::new(map), sites, narrow.noise.clone(), single)
        });
        Ok(Self { estimators: wide.collect::<Result<_, _>>()?, radii_m })
    }

    /// The same, each estimator `changed`.
    pub(crate) fn changed(
        &self,
        changed: impl Fn(&ContactEstimator) -> Result<ContactEstimator, InverseError>,
    ) -> Result<Self, InverseError> {
        let estimators = self.estimators.iter().map(changed).collect::<Result<_, _>>()?;
        Ok(Self { estimators, radii_m: self.radii_m.clone() })
    }

    /// Puts a wide contact in the place of the narrow ones of `estimate` where it is better, unless these are one
    /// with a residual of the probability `likely_p` at least.
    pub(crate) fn improve(
        &self,
        readings: &[f64],
        likely_p: f64,
        estimate: &mut ContactEstimate,
    ) -> Result<(), InverseError> {
        let is_one = estimate.contacts.len() == 1 && estimate.p_value >= likely_p;
        if self.estimators.is_empty() || is_one || estimate.verdict == Verdict::Untouched {
            return Ok(());
        }
        let found = self.estimators.iter().map(|wide| wide.estimate(readings));
        let mut found: Vec<ContactEstimate> = found.collect::<Result<_, _>>()?;
        let costs: Vec<f64> = found.iter().map(|wide| wide.cost).collect();
        let best = (0..costs.len()).min_by(|&a, &b| costs[a].total_cmp(&costs[b])).unwrap_or(0);
        let (radius, least) = least_cost(&self.radii_m, &costs, best);
        if least + MARGIN >= estimate.cost {
            return Ok(());
        }
        let between = self.of_radius(radius.radius_m)?.estimate(readings)?;
        let (mut better, radius) = if between.cost <= costs[best] {
            (between, radius)
        } else {
            let radius_m = self.radii_m[best];
            (found.swap_remove(best), ContactRadius { radius_m, ..radius })
        };
        if better.cost + MARGIN < estimate.cost {
            better.contacts.iter_mut().for_each(|contact| contact.radius = Some(radius));
            *estimate = better;
        }
        Ok(())
    }

    /// One contact of a radius between those that there are. To second order a mean under a tip goes with the
    /// square of the radius, so maps are mixed by that: on the radii alone 87 of 100 palms between two of them
    /// were found within 3 mm and 10 % of their force, where it was 98 on one of them.
    fn of_radius(&self, radius_m: f64) -> Result<ContactEstimator, InverseError> {
        let above = self.radii_m.partition_point(|r| *r < radius_m);
        let above = above.clamp(1, self.radii_m.len() - 1);
        let [low, high] = [above - 1, above].map(|i| self.radii_m[i].powi(2));
        let share = (radius_m.powi(2) - low) / (high - low);
        let [a, b] = [above - 1, above].map(|i| &self.estimators[i]);
        let mixed = a.map().nodal().into_iter().zip(b.map().nodal());
        let mixed: Vec<_> = mixed.map(|(a, b)| a + (b - a) * share).collect();
        let map = ResponseMap::from_values(a.map().skin().clone(), a.map().n_gauges(), &mixed)?;
        a.on_map(Arc::new(map))
    }
}

/// Readings per newton along x, y and z at every node of the skin `[n_nodes, n_gauges]`.
fn at_nodes(map: &ResponseMap) -> Vec<Vector3<f64>> {
    let (skin, m) = (map.skin(), map.n_gauges());
    let mut values = vec![Vector3::zeros(); skin.n_nodes() * m];
    for face in 0..skin.n_faces() {
        for (&node, bary) in skin.face_nodes(face).iter().zip(&basis::NODES) {
            let at = node as usize * m;
            let point = SkinPoint::trusted(face as u32, *bary);
            values[at..at + m].copy_from_slice(&map.vector(&point));
        }
    }
    values
}

/// The radius where −2 ln evidence is least by the parabola through the best radius and those beside it, and what
/// it is there.
fn least_cost(radii_m: &[f64], costs: &[f64], best: usize) -> (ContactRadius, f64) {
    let at_an_end = (ContactRadius { radius_m: radii_m[best], sd_m: None }, costs[best]);
    if best == 0 || best + 1 == radii_m.len() {
        return at_an_end;
    }
    let [before, after] = [best - 1, best + 1].map(|i| {
        let step_m = radii_m[i] - radii_m[best];
        (step_m, (costs[i] - costs[best]) / step_m)
    });
    // c(r) = c₀ + b (r − r₀) + a (r − r₀)² through three points, by divided differences
    let a = (after.1 - before.1) / (after.0 - before.0);
    let b = before.1 - a * before.0;
    if a <= 0.0 {
        return at_an_end;
    }
    let radius = ContactRadius {
        radius_m: radii_m[best] - 0.5 * b / a,
        // −2 ln of a normal density is (r − r̂)²/σ² and a constant
        sd_m: Some(a.sqrt().recip()),
    };
    (radius, costs[best] - 0.25 * b * b / a)
}

#[cfg(test)]
mod tests {
    use super::{WideParams, least_cost};

    #[test]
    fn the_radius_is_where_the_parabola_is_least() {
        let radii_m = [5e-3, 8e-3, 12e-3, 16e-3];
        let costs = radii_m.map(|r| 3.0 + ((r - 9.5e-3_f64) / 0.5e-3).powi(2));
        let (radius, least) = least_cost(&radii_m, &costs, 1);
        assert!((least - 3.0).abs() < 1e-9, "{least}");
        assert!((radius.radius_m - 9.5e-3).abs() < 1e-9, "{radius:?}");
        assert!((radius.sd_m.unwrap() - 0.5e-3).abs() < 1e-9, "{radius:?}");
        assert_eq!(least_cost(&radii_m, &costs, 3).0.sd_m, None);
    }

    #[test]
    fn radii_rise_to_two_beyond_the_widest() {
        let radii_m = WideParams { tip_radius_m: 2e-3, widest_m: 0.02 }.radii_m();
        assert!(radii_m.is_sorted() && radii_m[0] > 2e-3);
        let n_beyond = radii_m.iter().filter(|radius_m| **radius_m >= 0.02).count();
        assert_eq!(n_beyond, 2, "{radii_m:?}");
        assert!(WideParams { tip_radius_m: 2e-3, widest_m: 2e-3 }.check().is_err());
    }
}
