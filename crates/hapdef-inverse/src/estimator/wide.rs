//! One contact wider than the map's tip, such as a palm, where narrow ones leave a doubt.

use std::sync::Arc;

use hapdef_contact::{ContactRadius, Verdict};
use nalgebra::Vector3;

use crate::basis;
use crate::error::InverseError;
use crate::estimator::contact_estimator::OfRadius;
use crate::estimator::output::ContactEstimate;
use crate::estimator::radius::{Bracket, Tried};
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
        let tried = self.wide.iter().map(|wide| {
            let (radius_m, estimate) = (wide.radius_m, wide.estimator.estimate(readings)?);
            Ok::<_, InverseError>(Tried { radius_m, estimate })
        });
        let tried: Vec<Tried> = tried.collect::<Result<_, _>>()?;
        let better = match Bracket::around_best(&tried) {
            Some(mut bracket) => {
                bracket.narrow(|radius_m| self.of_radius(radius_m)?.estimate(readings))?;
                Some(bracket.into_estimate(self.map().skin()))
            }
            None => at_an_end(tried),
        };
        if let Some(better) = better.filter(|better| better.cost + MARGIN < estimate.cost) {
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

/// The best of those that were tried, of which it is the narrowest or the widest.
fn at_an_end(tried: Vec<Tried>) -> Option<ContactEstimate> {
    let best = tried.into_iter().min_by(|a, b| a.estimate.cost.total_cmp(&b.estimate.cost));
    let Tried { radius_m, mut estimate } = best?;
    let radius = Some(ContactRadius { radius_m, sd_m: None });
    estimate.contacts.iter_mut().for_each(|contact| contact.radius = radius);
    Some(estimate)
}
