//! A guess at the contacts, while it is searched for.

use hapdef_contact::MAX_CONTACTS;

use crate::skin::Skin;
use crate::skin_point::SkinPoint;

/// Contacts with normal forces, and how well they explain the frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Explanation {
    pub(crate) n: usize,
    pub(crate) points: [SkinPoint; MAX_CONTACTS],
    pub(crate) forces: [f64; MAX_CONTACTS],
    /// rᵀ S⁻¹ r.
    pub(crate) chi2: f64,
    /// ln det S: more where the map's error explains much.
    pub(crate) log_det_s: f64,
    /// ln det (1 + Λ₀⁻¹ I), the price of well-determined unknowns.
    pub(crate) occam: f64,
}

impl Explanation {
    pub(crate) fn new(points: &[SkinPoint]) -> Self {
        let mut all = [SkinPoint::trusted(0, [1.0, 0.0, 0.0]); MAX_CONTACTS];
        all[..points.len()].copy_from_slice(points);
        Self {
            n: points.len(),
            points: all,
            forces: [0.0; MAX_CONTACTS],
            chi2: f64::INFINITY,
            log_det_s: 0.0,
            occam: 0.0,
        }
    }

    pub(crate) fn points(&self) -> &[SkinPoint] {
        &self.points[..self.n]
    }

    /// −2 ln likelihood, up to a constant.
    pub(crate) fn misfit(&self) -> f64 {
        self.chi2 + self.log_det_s
    }

    /// −2 ln evidence by Laplace's method, up to a constant (MacKay, Information Theory, Inference
    /// and Learning Algorithms, 2003, chapter 28): misfit, Occam factor, and the n! names that
    /// the same contacts can be given.
    pub(crate) fn cost(&self) -> f64 {
        self.misfit() + self.occam - 2.0 * self.ln_names()
    }

    /// ln n!.
    pub(crate) fn ln_names(&self) -> f64 {
        (2..=self.n).map(|i| (i as f64).ln()).sum()
    }

    pub(crate) fn push(&mut self, point: SkinPoint) {
        if self.n < MAX_CONTACTS {
            self.points[self.n] = point;
            self.n += 1;
        }
    }

    /// Drops contacts whose force is not above `least` N.
    pub(crate) fn drop_idle(&mut self, least: f64) {
        let mut kept = 0;
        for i in 0..self.n {
            if self.forces[i] > least {
                self.points[kept] = self.points[i];
                self.forces[kept] = self.forces[i];
                kept += 1;
            }
        }
        self.n = kept;
    }

    /// Whether both have as many contacts, each within `distance_m` of its match, matched greedily.
    pub(crate) fn is_same(&self, other: &Self, skin: &Skin, distance_m: f64) -> bool {
        if self.n != other.n {
            return false;
        }
        let mut taken = [false; MAX_CONTACTS];
        self.points().iter().all(|point| {
            let place = skin.position(point);
            let nearest = (0..other.n)
                .filter(|&j| !taken[j])
                .map(|j| (j, (skin.position(&other.points[j]) - place).norm()))
                .min_by(|a, b| a.1.total_cmp(&b.1));
            match nearest {
                Some((j, gap)) if gap <= distance_m => {
                    taken[j] = true;
                    true
                }
                _ => false,
            }
        })
    }
}
