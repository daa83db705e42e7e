//! The radius at which one wide contact explains a frame best, and what not knowing it adds to the contact's errors.

use hapdef_contact::ContactRadius;
use nalgebra::Vector3;

use crate::error::InverseError;
use crate::estimator::output::ContactEstimate;
use crate::skin::Skin;

/// The most radii that are tried between those that there are. The cost is steep and no parabola over a step from one
/// radius to the next: judged by a single parabola 9 of 100 palms stayed two or three narrow contacts (`cargo xtask
/// compare`, test seed 611).
const MOST_STEPS: usize = 6;

/// Steps that are made whatever they promise, since the first parabolas are far too wide.
const LEAST_STEPS: usize = 2;

/// −2 ln evidence that a further step has to promise: a tenth of what one standard deviation costs.
const GAIN: f64 = 0.1;

/// Nearer to a radius that was tried than this share of the bracket, a further one shows nothing new.
const NEAREST: f64 = 0.02;

/// A radius, and the contact that it has.
#[derive(Clone, Debug)]
pub(super) struct Tried {
    pub(super) radius_m: f64,
    pub(super) estimate: ContactEstimate,
}

/// Three rising radii of which the middle one costs least.
pub(super) struct Bracket([Tried; 3]);

/// A parabola through the three costs.
struct Parabola {
    /// Where it is least, m, and what it is there.
    radius_m: f64,
    least: f64,
    /// Half its second derivative, per m².
    curvature: f64,
}

impl Bracket {
    /// The best of `tried`, rising in radius, and those beside it; none where the best is the first or the last.
    pub(super) fn around_best(tried: &[Tried]) -> Option<Self> {
        let cost = |i: &usize| tried[*i].estimate.cost;
        let best = (0..tried.len()).min_by(|a, b| cost(a).total_cmp(&cost(b)))?;
        let beside = best.checked_sub(1).and_then(|first| tried.get(first..best + 2))?;
        <[Tried; 3]>::try_from(beside.to_vec()).ok().map(Self)
    }

    /// Tries radii where parabolas are least, each through the three best so far (successive parabolic interpolation;
    /// Brent, Algorithms for Minimization without Derivatives, 1973, chapter 5).
    pub(super) fn narrow(
        &mut self,
        mut estimate: impl FnMut(f64) -> Result<ContactEstimate, InverseError>,
    ) -> Result<(), InverseError> {
        for step in 0..MOST_STEPS {
            let [low_m, best_m, high_m] = self.radii_m();
            let (mut radius_m, mut gain) = (0.5 * (low_m + high_m), f64::INFINITY);
            if let Some(parabola) = self.parabola() {
                (radius_m, gain) = (parabola.radius_m, self.best().cost - parabola.least);
            }
            if gain < GAIN && step >= LEAST_STEPS {
                break;
            }
            let apart_m = NEAREST * (high_m - low_m);
            if (radius_m - best_m).abs() < apart_m {
                // to the side where more is unknown
                let is_above = high_m - best_m > best_m - low_m;
                radius_m = best_m + if is_above { apart_m } else { -apart_m };
            }
            self.add(Tried { radius_m, estimate: estimate(radius_m)? });
        }
        Ok(())
    }

    /// The contact of the best radius: the radius with its error where the costs tell it, and errors of place and
    /// force with what they have from it.
    pub(super) fn into_estimate(self, skin: &Skin) -> ContactEstimate {
        let sd_m = self.parabola().map(|parabola| parabola.curvature.sqrt().recip());
        let per_m = self.per_radius(skin);
        let [_, Tried { radius_m, mut estimate }, _] = self.0;
        for contact in &mut estimate.contacts {
            contact.radius = Some(ContactRadius { radius_m, sd_m });
            if let (Some(sd_m), Some(per_m)) = (sd_m, per_m) {
                contact.covariance += per_m * per_m.transpose() * sd_m.powi(2);
                estimate.joint_covariance.copy_from_slice(contact.covariance.as_slice());
            }
        }
        estimate
    }

    pub(super) fn best(&self) -> &ContactEstimate {
        &self.0[1].estimate
    }

    fn radii_m(&self) -> [f64; 3] {
        [0, 1, 2].map(|i| self.0[i].radius_m)
    }

    /// Takes a further radius between the outer ones.
    fn add(&mut self, tried: Tried) {
        let [low, best, high] = &mut self.0;
        let is_above = tried.radius_m > best.radius_m;
        let is_better = tried.estimate.cost < best.estimate.cost;
        let beyond = if is_above == is_better { low } else { high };
        *beyond = if is_better { std::mem::replace(best, tried) } else { tried };
    }

    /// None where the costs don't turn upwards.
    fn parabola(&self) -> Option<Parabola> {
        let ([low_m, best_m, high_m], cost) = (self.radii_m(), self.best().cost);
        let slope = |i: usize, radius_m: f64| {
            let step_m = radius_m - best_m;
            (step_m, (self.0[i].estimate.cost - cost) / step_m)
        };
        let (before, after) = (slope(0, low_m), slope(2, high_m));
        // c(r) = c₀ + b (r − r₀) + a (r − r₀)² through three points, by divided differences; −2 ln of a normal
        // density is (r − r̂)²/σ² and a constant
        let a = (after.1 - before.1) / (after.0 - before.0);
        let b = before.1 - a * before.0;
        let is_upwards = a > 0.0 && a.is_finite();
        is_upwards.then(|| Parabola {
            radius_m: best_m - 0.5 * b / a,
            least: cost - 0.25 * b * b / a,
            curvature: a,
        })
    }

    /// How far along the two tangents, m, and by how much force, N, the contact goes for each metre of radius; none
    /// unless there is one contact with each radius.
    fn per_radius(&self, skin: &Skin) -> Option<Vector3<f64>> {
        let contact = |i: usize| match &self.0[i].estimate.contacts[..] {
            [contact] => Some(contact),
            _ => None,
        };
        let [low, best, high] = [contact(0)?, contact(1)?, contact(2)?];
        let moved_m = high.position_m - low.position_m;
        let [t1, t2] = skin.tangents(&best.point).map(|tangent| tangent.dot(&moved_m));
        let [low_m, _, high_m] = self.radii_m();
        Some(Vector3::new(t1, t2, high.force_n - low.force_n) / (high_m - low_m))
    }
}

#[cfg(test)]
mod tests {
    use super::{Bracket, ContactEstimate, Tried};

    fn tried(radius_m: f64, cost: impl Fn(f64) -> f64) -> Tried {
        Tried { radius_m, estimate: ContactEstimate { cost: cost(radius_m), ..Default::default() } }
    }

    const RADII_M: [f64; 4] = [5e-3, 8e-3, 12e-3, 16e-3];

    #[test]
    fn a_parabola_is_least_where_it_is_least() {
        let cost = |r: f64| 3.0 + ((r - 9.5e-3) / 0.5e-3).powi(2);
        let bracket = Bracket::around_best(&RADII_M.map(|r| tried(r, cost))).unwrap();
        let parabola = bracket.parabola().unwrap();
        assert!((parabola.least - 3.0).abs() < 1e-9, "{}", parabola.least);
        assert!((parabola.radius_m - 9.5e-3).abs() < 1e-9, "{}", parabola.radius_m);
        assert!((parabola.curvature - 4e6).abs() < 1.0, "{}", parabola.curvature);
    }

    #[test]
    fn a_steep_cost_that_is_no_parabola_is_followed_to_where_it_is_least() {
        // means under a tip go with the square of its radius: hundreds on both sides, steeper above
        for least_m in [8.3e-3, 9.5e-3, 11e-3, 13.1e-3] {
            let cost = |r: f64| 5.0 + ((r * r - least_m * least_m) / 5e-6).powi(2);
            let mut bracket = Bracket::around_best(&RADII_M.map(|r| tried(r, cost))).unwrap();
            bracket.narrow(|r| Ok(tried(r, cost).estimate)).unwrap();
            // half a standard deviation off costs a quarter
            assert!(bracket.best().cost < 5.25, "{least_m}: {}", bracket.best().cost);
        }
    }

    #[test]
    fn the_narrowest_and_the_widest_have_none_beside_them() {
        for rising in [1.0, -1.0] {
            let tried = RADII_M.map(|r| tried(r, |r| rising * r));
            assert!(Bracket::around_best(&tried).is_none());
        }
        assert!(Bracket::around_best(&[]).is_none());
    }
}
