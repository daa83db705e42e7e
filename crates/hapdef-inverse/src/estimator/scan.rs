//! Full scans of the sites: the best place for one contact, given others.

use crate::dense::{add_scaled, dot};
use crate::estimator::Model;
use crate::estimator::explanation::MAX_CONTACTS;

/// A site and the χ² that a contact there explains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gain {
    pub(crate) site: usize,
    pub(crate) gain: f64,
}

/// Unit atoms of contacts that are held, made orthogonal.
#[derive(Clone, Debug)]
pub(crate) struct Held {
    basis: Vec<f64>,
    n: usize,
}

impl Held {
    pub(crate) fn with_width(width: usize) -> Self {
        Self {
            basis: vec![0.0; MAX_CONTACTS * width],
            n: 0,
        }
    }

    pub(crate) fn clear(&mut self) {
        self.n = 0;
    }

    pub(crate) fn n(&self) -> usize {
        self.n
    }

    pub(crate) fn row(&self, i: usize, width: usize) -> &[f64] {
        &self.basis[i * width..(i + 1) * width]
    }

    /// Adds `atom`; nothing if it is in the span of those before.
    pub(crate) fn push(&mut self, atom: &[f64]) {
        let width = atom.len();
        if self.n == MAX_CONTACTS {
            return;
        }
        let (before, rest) = self.basis.split_at_mut(self.n * width);
        let new = &mut rest[..width];
        new.copy_from_slice(atom);
        let full = dot(new, new);
        for _ in 0..2 {
            for row in before.chunks_exact(width) {
                let share = dot(row, new);
                add_scaled(new, -share, row);
            }
        }
        let left = dot(new, new);
        if left > 1e-8 * full && left > 0.0 {
            let scale = 1.0 / left.sqrt();
            new.iter_mut().for_each(|v| *v *= scale);
            self.n += 1;
        }
    }

    /// Takes the span out of `r`.
    pub(crate) fn project(&self, r: &mut [f64]) {
        for i in 0..self.n {
            let row = self.row(i, r.len());
            let share = dot(row, r);
            add_scaled(r, -share, row);
        }
    }
}

impl Model {
    /// What a pushing contact at each site explains of `r`, from which the span of `held` has been
    /// taken out, when the held forces are solved again: (u·r)² / (1 − |Qu|²) if u·r > 0.
    pub(crate) fn gains(&self, r: &[f64], held: &Held, gains: &mut [f64]) {
        for (site, gain) in gains.iter_mut().enumerate() {
            let atom = self.atom(site);
            let along = dot(atom, r);
            let mut left = 1.0;
            for i in 0..held.n() {
                let share = dot(held.row(i, self.width), atom);
                left -= share * share;
            }
            let is_usable = along > 0.0 && left > 1e-4;
            *gain = if is_usable { along * along / left } else { 0.0 };
        }
    }

    /// The largest local maxima of `gains`, largest first, at most `n`.
    pub(crate) fn peaks(&self, gains: &[f64], n: usize, out: &mut Vec<Gain>) {
        out.clear();
        for (site, &gain) in gains.iter().enumerate() {
            let is_peak = gain > 0.0
                && self
                    .sites
                    .near(site)
                    .iter()
                    .all(|&other| gains[other as usize] <= gain);
            if !is_peak || (out.len() == n && gain <= out[n - 1].gain) {
                continue;
            }
            let place = out.partition_point(|other| other.gain >= gain);
            if out.len() == n {
                out.pop();
            }
            out.insert(place, Gain { site, gain });
        }
    }

    /// The site with the largest gain.
    pub(crate) fn best_site(gains: &[f64]) -> Gain {
        let mut best = Gain { site: 0, gain: 0.0 };
        for (site, &gain) in gains.iter().enumerate() {
            if gain > best.gain {
                best = Gain { site, gain };
            }
        }
        best
    }
}
