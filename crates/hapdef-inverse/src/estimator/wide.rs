//! One contact wider than the map's tip, such as a palm, where narrow ones leave a doubt.

use std::sync::Arc;

use hapdef_contact::{ContactRadius, Verdict};
use nalgebra::Vector3;

use crate::basis;
use crate::error::InverseError;
use crate::estimator::contact_estimator::OfRadius;
use crate::estimator::output::ContactEstimate;
use crate::estimator::{ContactEstimator, EstimatorParams, WideParams};
use crate::response::{ResponseMap, ResponseParams};
use crate::skin_point::SkinPoint;

/// A wide contact has to be better in −2 ln evidence than the narrow ones by this, odds of e² against it: each radius
/// is a further chance for noise, though hardly one of its own.
const MARGIN: f64 = 4.0;

impl ContactEstimator {
    /// The same with one contact on the maps of wider tips. The map under a wide tip is the mean of the map under the
    /// tips that it has, at the nodes of the skin; its error is taken to be that of the map.
    pub(crate) fn widened(mut self, params: &WideParams) -> Result<Self, InverseError> {
        let nodal = at_nodes(self.map());
        let of_radius = |radius_m: f64| {
            // second moments of pressures add up
            let added_m = (radius_m.powi(2) - params.tip_radius_m.powi(2)).sqrt();
            let wider = ResponseParams { tip_radius_m: added_m };
            let map = self.map();
            let map = ResponseMap::from_nodal(map.skin().clone(), map.n_gauges(), &nodal, &wider)?;
            let single = EstimatorParams { known_count: Some(1), wide: None, ..self.params };
            let sites = self.model.sites.clone();
            let estimator = Self::new(Arc::new(map), sites, self.noise.clone(), single)?;
            Ok(OfRadius { radius_m, estimator })
        };
        self.wide = params.radii_m().into_iter().map(of_radius).collect::<Result<_, _>>()?;
        Ok(self)
    }

    /// Puts a wide contact in the place of the narrow ones of `estimate` where it is better, unless these are one
    /// whose residual is likely.
    pub(crate) fn improve_by_wide(
        &self,
        readings: &[f64],
        estimate: &mut ContactEstimate,
    ) -> Result<(), InverseError> {
        let is_one = estimate.contacts.len() == 1 && estimate.p_value >= self.params.settle_p;
        if self.wide.is_empty() || is_one || estimate.verdict == Verdict::Untouched {
            return Ok(());
        }
        let found = self.wide.iter().map(|wide| wide.estimator.estimate(readings));
        let mut found: Vec<ContactEstimate> = found.collect::<Result<_, _>>()?;
        let costs: Vec<f64> = found.iter().map(|wide| wide.cost).collect();
        let best = (0..costs.len()).min_by(|&a, &b| costs[a].total_cmp(&costs[b])).unwrap_or(0);
        let radii_m: Vec<f64> = self.wide.iter().map(|wide| wide.radius_m).collect();
        let (radius, least) = least_cost(&radii_m, &costs, best);
        if least + MARGIN >= estimate.cost {
            return Ok(());
        }
        let between = self.of_radius(radius.radius_m)?.estimate(readings)?;
        let (mut better, radius) = if between.cost <= costs[best] {
            (between, radius)
        } else {
            let radius_m = radii_m[best];
            (found.swap_remove(best), ContactRadius { radius_m, ..radius })
        };
        if better.cost + MARGIN < estimate.cost {
            better.contacts.iter_mut().for_each(|contact| contact.radius = Some(radius));
            *estimate = better;
        }
        Ok(())
    }

    /// One contact of a radius between those that there are. To second order a mean under a tip goes with the
    /// square of the radius, so maps are mixed by that: on the radii alone 52 of 60 palms between two of them
    /// were found within 3 mm and 10 % of their force, 59 of 60 on one of them (`cargo xtask compare`, test seed 611).
    fn of_radius(&self, radius_m: f64) -> Result<Self, InverseError> {
        let above = self.wide.partition_point(|wide| wide.radius_m < radius_m);
        let above = above.clamp(1, self.wide.len() - 1);
        let [low, high] = [above - 1, above].map(|i| self.wide[i].radius_m.powi(2));
        let share = (radius_m.powi(2) - low) / (high - low);
        let [a, b] = [above - 1, above].map(|i| &self.wide[i].estimator);
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
    use super::least_cost;

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
}
