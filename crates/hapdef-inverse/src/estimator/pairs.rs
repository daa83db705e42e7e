//! The exhaustive scan of all pairs of sites, on the Gram matrix.

use crate::estimator::Model;

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
}

impl PairBuffers {
    pub(crate) fn new(n_sites: usize) -> Self {
        let zeros = vec![0.0; n_sites];
        Self {
            energies: zeros.clone(),
            best: zeros.clone(),
            partner: zeros,
            order: Vec::with_capacity(n_sites),
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

    /// The `n` best pairs in different places of the scan that `buffers` holds.
    pub(crate) fn distinct_pairs(&self, n: usize, buffers: &mut PairBuffers, out: &mut Vec<Pair>) {
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
