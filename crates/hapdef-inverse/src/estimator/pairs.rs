//! The exhaustive scan of all pairs of sites, on the Gram matrix, beside contacts that are held.

use crate::estimator::Model;
use crate::estimator::scan::{Beside, Company};

/// Squared sine below which two atoms are too alike to be distinguished on the scan: f32 knows a squared sine
/// to 1e-7, a thousandth of this.
const LEAST_SINE_2: f32 = 1e-4;

/// Pairs looked at together.
const LANES: usize = 16;

/// Two sites and the χ² they explain with both forces positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pair {
    pub(crate) sites: [u32; 2],
    pub(crate) energy: f32,
}

/// Buffers of the scan `[n_sites]`.
#[derive(Clone, Debug)]
pub(crate) struct PairBuffers {
    energies: Vec<f32>,
    best: Vec<f32>,
    partner: Vec<f32>,
    order: Vec<Pair>,
    pub(crate) beside: Beside,
}

impl PairBuffers {
    pub(crate) fn new(n_sites: usize) -> Self {
        let zeros = vec![0.0; n_sites];
        Self {
            energies: zeros.clone(),
            best: zeros.clone(),
            partner: zeros,
            order: Vec::with_capacity(n_sites),
            beside: Beside::new(n_sites),
        }
    }
}

impl Model {
    /// The best pairs for atom products `c` `[n_sites]` = u·z: for each site its best partner among
    /// all others; of these the `n` best that are in different places, best first. The energy of a
    /// pair with product γ is (c₁² + c₂² − 2γ c₁c₂) / (1 − γ²); it counts only where both forces,
    /// which go with c₁ − γ c₂ and c₂ − γ c₁, are positive.
    pub(crate) fn best_pairs(
        &self,
        c: &[f32],
        n: usize,
        buffers: &mut PairBuffers,
        out: &mut Vec<Pair>,
    ) {
        let n_sites = self.n_sites();
        buffers.best.fill(0.0);
        buffers.partner.fill(-1.0);
        let gram = self.gram();
        pulp::Arch::new().dispatch(|| scan_all(gram, c, n_sites, buffers));
        self.distinct_pairs(n, buffers, out);
    }

    /// The same beside contacts 0 to `n_held` of `company`, whose forces are solved again for each pair:
    /// their atoms are taken out of the frame and of all sites by projection, which changes products of
    /// atoms by as many terms as there are contacts.
    pub(crate) fn best_pairs_beside(
        &self,
        c: &[f32],
        company: &Company,
        n_held: usize,
        n: usize,
        buffers: &mut PairBuffers,
        out: &mut Vec<Pair>,
    ) {
        let n_kept = company.project(c, n_held, &mut buffers.beside);
        buffers.best.fill(0.0);
        buffers.partner.fill(-1.0);
        let (gram, n_sites) = (self.gram(), self.n_sites());
        let arch = pulp::Arch::new();
        match n_kept {
            0 => arch.dispatch(|| scan_beside::<0>(gram, n_sites, buffers)),
            1 => arch.dispatch(|| scan_beside::<1>(gram, n_sites, buffers)),
            2 => arch.dispatch(|| scan_beside::<2>(gram, n_sites, buffers)),
            3 => arch.dispatch(|| scan_beside::<3>(gram, n_sites, buffers)),
            _ => arch.dispatch(|| scan_beside::<4>(gram, n_sites, buffers)),
        }
        self.distinct_pairs(n, buffers, out);
    }

    /// The `n` best pairs in different places of the scan that `buffers` holds.
    fn distinct_pairs(&self, n: usize, buffers: &mut PairBuffers, out: &mut Vec<Pair>) {
        buffers.order.clear();
        for (s, (&energy, &partner)) in buffers.best.iter().zip(&buffers.partner).enumerate() {
            if partner >= 0.0 {
                let sites = [s as u32, partner as u32];
                buffers.order.push(Pair { sites, energy });
            }
        }
        buffers
            .order
            .sort_unstable_by(|a, b| b.energy.total_cmp(&a.energy).then(a.sites.cmp(&b.sites)));
        out.clear();
        let near = 1.2 * self.sites.spacing_m();
        for pair in &buffers.order {
            if out.len() == n {
                break;
            }
            if out.iter().all(|other| !self.is_near(pair, other, near)) {
                out.push(*pair);
            }
        }
    }

    fn is_near(&self, a: &Pair, b: &Pair, distance_m: f64) -> bool {
        let x = self.sites.positions();
        let close = |i: u32, j: u32| {
            (x[i as usize] - x[j as usize]).norm_squared() <= distance_m * distance_m
        };
        let ([a0, a1], [b0, b1]) = (a.sites, b.sites);
        (close(a0, b0) && close(a1, b1)) || (close(a0, b1) && close(a1, b0))
    }
}

struct Best<'a> {
    energies: &'a mut [f32],
    best: &'a mut [f32],
    partner: &'a mut [f32],
}

#[inline(always)]
fn scan_all(gram: &[f32], c: &[f32], n_sites: usize, buffers: &mut PairBuffers) {
    for s in 0..n_sites {
        let tail = s + 1..n_sites;
        let row = &gram[s * n_sites..(s + 1) * n_sites];
        let out = Best {
            energies: &mut buffers.energies[tail.clone()],
            best: &mut buffers.best[tail.clone()],
            partner: &mut buffers.partner[tail.clone()],
        };
        scan_row(c[s], s as f32, &row[tail.clone()], &c[tail.clone()], out);
        let energies = &buffers.energies[tail];
        let top = max(energies);
        if top > buffers.best[s] {
            let place = energies.iter().position(|&e| e == top).unwrap_or(0);
            buffers.best[s] = top;
            buffers.partner[s] = (s + 1 + place) as f32;
        }
    }
}

/// [`scan_all`] on the projected atoms, of which `K` held contacts were taken out.
#[inline(always)]
fn scan_beside<const K: usize>(gram: &[f32], n_sites: usize, buffers: &mut PairBuffers) {
    let PairBuffers { energies, best, partner, beside, .. } = buffers;
    let Beside { scales, c, products, q } = beside;
    for s in 0..n_sites {
        if scales[s] == 0.0 {
            continue;
        }
        let tail = s + 1..n_sites;
        let row = &gram[s * n_sites..(s + 1) * n_sites];
        let held: [&[f32]; K] = std::array::from_fn(|i| &q[i * n_sites..(i + 1) * n_sites]);
        let own: [f32; K] = std::array::from_fn(|i| held[i][s]);
        let scale = scales[s];
        for t in tail.clone() {
            let mut product = row[t] * scale * scales[t];
            for i in 0..K {
                product -= own[i] * held[i][t];
            }
            products[t] = product;
        }
        let out = Best {
            energies: &mut energies[tail.clone()],
            best: &mut best[tail.clone()],
            partner: &mut partner[tail.clone()],
        };
        scan_row(c[s], s as f32, &products[tail.clone()], &c[tail.clone()], out);
        let energies = &energies[tail];
        let top = max(energies);
        if top > best[s] {
            let place = energies.iter().position(|&e| e == top).unwrap_or(0);
            best[s] = top;
            partner[s] = (s + 1 + place) as f32;
        }
    }
}

/// Energies of one site with those after it, and their best partners so far.
#[inline(always)]
fn scan_row(c_s: f32, s: f32, gram: &[f32], c: &[f32], out: Best<'_>) {
    let (grams, gram_rest) = gram.as_chunks::<LANES>();
    let (cs, c_rest) = c.as_chunks::<LANES>();
    let (energies, energy_rest) = out.energies.as_chunks_mut::<LANES>();
    let (bests, best_rest) = out.best.as_chunks_mut::<LANES>();
    let (partners, partner_rest) = out.partner.as_chunks_mut::<LANES>();
    for i in 0..grams.len() {
        let e = pair_energies(c_s, &grams[i], &cs[i]);
        energies[i] = e;
        let (mut best, mut partner) = (bests[i], partners[i]);
        for lane in 0..LANES {
            let is_better = e[lane] > best[lane];
            best[lane] = if is_better { e[lane] } else { best[lane] };
            partner[lane] = if is_better { s } else { partner[lane] };
        }
        (bests[i], partners[i]) = (best, partner);
    }
    for t in 0..gram_rest.len() {
        let [energy] = pair_energies(c_s, &[gram_rest[t]], &[c_rest[t]]);
        energy_rest[t] = energy;
        if energy > best_rest[t] {
            (best_rest[t], partner_rest[t]) = (energy, s);
        }
    }
}

#[inline(always)]
pub(crate) fn pair_energies<const N: usize>(c_s: f32, gram: &[f32; N], c: &[f32; N]) -> [f32; N] {
    let mut energies = [0.0; N];
    for lane in 0..N {
        let (gamma, c_t) = (gram[lane], c[lane]);
        let (a, b) = (c_s - gamma * c_t, c_t - gamma * c_s);
        let sine_2 = 1.0 - gamma * gamma;
        let is_usable = (a > 0.0) & (b > 0.0) & (sine_2 > LEAST_SINE_2);
        let energy = (c_s * a + c_t * b) / sine_2;
        energies[lane] = if is_usable { energy } else { 0.0 };
    }
    energies
}

#[inline(always)]
fn max(values: &[f32]) -> f32 {
    let (chunks, rest) = values.as_chunks::<LANES>();
    let mut lanes = [0.0_f32; LANES];
    for chunk in chunks {
        for lane in 0..LANES {
            let is_more = chunk[lane] > lanes[lane];
            lanes[lane] = if is_more { chunk[lane] } else { lanes[lane] };
        }
    }
    rest.iter().chain(&lanes).fold(0.0, |a, &b| a.max(b))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use nalgebra::{DMatrix, DVector};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::dense::dot;
    use crate::noise::NoiseParams;
    use crate::response::waves;
    use crate::sites::ScanSites;
    use crate::skin::plate;

    const N_GAUGES: usize = 8;

    /// Gauges on a plate of 8 by 8 cells that see waves of their own.
    fn model(rng: &mut ChaCha8Rng) -> Model {
        let map = waves(plate(8, 5e-3), N_GAUGES, 120.0, rng);
        let sites = ScanSites::farthest(map.skin(), 60).unwrap();
        let noise = NoiseParams::uniform(N_GAUGES, 0.01);
        Model::new(Arc::new(map), Arc::new(sites), &noise, &[true; N_GAUGES]).unwrap()
    }

    /// What the atoms of `sites` explain of `z` by least squares, and the coefficients.
    fn explained(model: &Model, sites: &[usize], z: &[f64]) -> (f64, Vec<f64>) {
        let n = sites.len();
        let gram = DMatrix::from_fn(n, n, |i, j| dot(model.atom(sites[i]), model.atom(sites[j])));
        let b = DVector::from_iterator(n, sites.iter().map(|&s| dot(model.atom(s), z)));
        let x = gram.cholesky().map_or_else(|| DVector::zeros(n), |l| l.solve(&b));
        (x.dot(&b), x.iter().copied().collect())
    }

    /// Every pair by least squares, one by one.
    #[test]
    fn the_best_pair_beside_held_contacts_is_that_of_all_pairs() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let model = model(&mut rng);
        let n = model.n_sites();
        for n_held in [1, 2] {
            let held: Vec<usize> = (0..n_held).map(|_| rng.random_range(0..n)).collect();
            let mut z: Vec<f64> = (0..model.width).map(|_| rng.random_range(-0.1..0.1)).collect();
            for site in held.iter().copied().chain([3, 40]) {
                z.iter_mut().zip(model.atom(site)).for_each(|(z, u)| *z += u);
            }
            let c: Vec<f32> = (0..n).map(|s| dot(model.atom(s), &z) as f32).collect();
            let mut company = Company::new(&model);
            for (j, &site) in held.iter().enumerate() {
                company.set_site(&model, j, site, &z);
            }
            let (mut buffers, mut found) = (PairBuffers::new(n), Vec::new());
            model.best_pairs_beside(&c, &company, n_held, 3, &mut buffers, &mut found);
            let alone = explained(&model, &held, &z).0;
            let mut best = (0.0, [0, 0]);
            for s in 0..n {
                for t in s + 1..n {
                    if held.contains(&s) || held.contains(&t) {
                        continue;
                    }
                    let (energy, x) = explained(&model, &[&held[..], &[s, t]].concat(), &z);
                    if x[n_held] > 0.0 && x[n_held + 1] > 0.0 && energy - alone > best.0 {
                        best = (energy - alone, [s as u32, t as u32]);
                    }
                }
            }
            let mut sites = found[0].sites;
            sites.sort_unstable();
            assert_eq!(sites, best.1, "beside {n_held}");
            let off = f64::from(found[0].energy) / best.0 - 1.0;
            assert!(off.abs() < 1e-4, "beside {n_held}: {off:e}");
        }
    }
}
