//! Full scans of the sites: the best place for one contact, beside others that are held.

use hapdef_contact::MAX_CONTACTS;

use crate::dense::{cholesky, dot};
use crate::estimator::Model;

/// Squared sine of the angle to the held atoms below which a site can't be distinguished from them.
const LEAST_SINE_2: f32 = 1e-4;

/// Sites looked at together.
const LANES: usize = 16;

/// A site and the χ² that a contact there explains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gain {
    pub(crate) site: usize,
    pub(crate) gain: f32,
}

/// Contacts beside which a site is looked for: products of their unit atoms with every site's.
#[derive(Clone, Debug)]
pub(crate) struct Company {
    /// u_j·u_t `[MAX_CONTACTS, n_sites]`.
    rows: Vec<f32>,
    atoms: Vec<f64>,
    /// u_j·z.
    along: [f64; MAX_CONTACTS],
    n_sites: usize,
}

/// Unit atoms with what the held contacts explain taken out `[n_sites]`.
#[derive(Clone, Debug)]
pub(crate) struct Beside {
    /// One over what is left of each unit atom's length; 0 where too little is.
    pub(crate) scales: Vec<f32>,
    /// Products of what is left, made unit again, with the frame.
    pub(crate) c: Vec<f32>,
    /// Products of one of them with all others.
    pub(crate) products: Vec<f32>,
    /// Coordinates of the unit atoms in the held ones made orthonormal, times `scales`
    /// `[MAX_CONTACTS, n_sites]`.
    pub(crate) q: Vec<f32>,
}

impl Beside {
    pub(crate) fn new(n_sites: usize) -> Self {
        let zeros = vec![0.0; n_sites];
        Self {
            scales: zeros.clone(),
            c: zeros.clone(),
            products: zeros,
            q: vec![0.0; MAX_CONTACTS * n_sites],
        }
    }
}

impl Company {
    pub(crate) fn new(model: &Model) -> Self {
        Self {
            rows: vec![0.0; MAX_CONTACTS * model.n_sites()],
            atoms: vec![0.0; MAX_CONTACTS * model.width],
            along: [0.0; MAX_CONTACTS],
            n_sites: model.n_sites(),
        }
    }

    /// Puts the unit atom `atom` in place `j`.
    pub(crate) fn set_atom(&mut self, model: &Model, j: usize, atom: &[f64], z: &[f64]) {
        let row = &mut self.rows[j * self.n_sites..(j + 1) * self.n_sites];
        for (site, product) in row.iter_mut().enumerate() {
            *product = dot(model.atom(site), atom) as f32;
        }
        self.keep(model, j, atom, z);
    }

    /// Puts `site` in place `j`.
    pub(crate) fn set_site(&mut self, model: &Model, j: usize, site: usize, z: &[f64]) {
        let n = self.n_sites;
        self.rows[j * n..(j + 1) * n].copy_from_slice(&model.gram()[site * n..(site + 1) * n]);
        self.keep(model, j, model.atom(site), z);
    }

    /// Copies contact `j` of `other`.
    pub(crate) fn copy(&mut self, other: &Self, j: usize) {
        let (n, width) = (self.n_sites, self.atoms.len() / MAX_CONTACTS);
        let (row, atom) = (j * n..(j + 1) * n, j * width..(j + 1) * width);
        self.rows[row.clone()].copy_from_slice(&other.rows[row]);
        self.atoms[atom.clone()].copy_from_slice(&other.atoms[atom]);
        self.along[j] = other.along[j];
    }

    fn keep(&mut self, model: &Model, j: usize, atom: &[f64], z: &[f64]) {
        self.atoms[j * model.width..(j + 1) * model.width].copy_from_slice(atom);
        self.along[j] = dot(atom, z);
    }

    fn atom(&self, j: usize) -> &[f64] {
        let width = self.atoms.len() / MAX_CONTACTS;
        &self.atoms[j * width..(j + 1) * width]
    }

    /// What a pushing contact at each site explains when the forces of contacts `held` are solved
    /// again: (c_t − Σ bᵢ q_ti)² / (1 − Σ q_ti²) where the first is positive, with q the coordinates
    /// of u_t in the held atoms made orthogonal, b those of z, c_t = u_t·z.
    pub(crate) fn gains(&self, model: &Model, c: &[f32], held: &[usize], gains: &mut [f32]) {
        let (inverse, kept) = self.orthogonal(held);
        let rows = |i: usize| &self.rows[held[kept[i.min(kept.len() - 1)]] * self.n_sites..];
        let b = |i: usize| -> f32 {
            (0..=i).map(|j| inverse[i][j] * self.along[held[kept[j]]]).sum::<f64>() as f32
        };
        let t = inverse.map(|row| row.map(|v| v as f32));
        let arch = pulp::Arch::new();
        match kept.len() {
            0 => plain(c, gains),
            1 => arch.dispatch(|| beside(c, [rows(0)], [b(0)], &t, gains)),
            2 => arch.dispatch(|| beside(c, [rows(0), rows(1)], [b(0), b(1)], &t, gains)),
            3 => {
                let (rows, b) = (std::array::from_fn(rows), std::array::from_fn(b));
                arch.dispatch(|| beside::<3>(c, rows, b, &t, gains));
            }
            4 => {
                let (rows, b) = (std::array::from_fn(rows), std::array::from_fn(b));
                arch.dispatch(|| beside::<4>(c, rows, b, &t, gains));
            }
            _ => {
                let (rows, b) = (std::array::from_fn(rows), std::array::from_fn(b));
                arch.dispatch(|| beside::<5>(c, rows, b, &t, gains));
            }
        }
        debug_assert_eq!(gains.len(), model.n_sites());
    }

    /// Takes contacts 0 to `n_held` out of the atoms and of their products `c` with the frame; how many of
    /// them are no sum of the others.
    pub(crate) fn project(&self, c: &[f32], n_held: usize, out: &mut Beside) -> usize {
        let held: [usize; MAX_CONTACTS] = std::array::from_fn(|i| i);
        let (inverse, kept) = self.orthogonal(&held[..n_held]);
        let n = self.n_sites;
        let Beside { scales, c: left_c, q, .. } = out;
        scales.fill(1.0);
        left_c.copy_from_slice(c);
        for i in 0..kept.len() {
            let row = &mut q[i * n..(i + 1) * n];
            row.fill(0.0);
            let mut b = 0.0;
            for j in 0..=i {
                let weight = inverse[i][j] as f32;
                let atom = &self.rows[kept[j] * n..(kept[j] + 1) * n];
                row.iter_mut().zip(atom).for_each(|(q, product)| *q += weight * product);
                b += inverse[i][j] * self.along[kept[j]];
            }
            for ((left, c), q) in scales.iter_mut().zip(left_c.iter_mut()).zip(row.iter()) {
                *left -= q * q;
                *c -= b as f32 * q;
            }
        }
        for (site, left) in scales.iter_mut().enumerate() {
            let scale = if *left > LEAST_SINE_2 { 1.0 / left.sqrt() } else { 0.0 };
            *left = scale;
            left_c[site] *= scale;
            (0..kept.len()).for_each(|i| q[i * n + site] *= scale);
        }
        kept.len()
    }

    /// What contact `j`'s own atom explains beside `held`.
    pub(crate) fn own_gain(&self, j: usize, held: &[usize]) -> f64 {
        let (inverse, kept) = self.orthogonal(held);
        let (mut along, mut left) = (self.along[j], 1.0);
        for i in 0..kept.len() {
            let of = |f: &dyn Fn(usize) -> f64| -> f64 {
                (0..=i).map(|p| inverse[i][p] * f(held[kept[p]])).sum()
            };
            let q = of(&|p| dot(self.atom(p), self.atom(j)));
            along -= of(&|p| self.along[p]) * q;
            left -= q * q;
        }
        if along > 0.0 && left > f64::from(LEAST_SINE_2) { along * along / left } else { 0.0 }
    }

    /// What the contacts `held` explain together, signs of their forces left free.
    pub(crate) fn explained(&self, held: &[usize]) -> f64 {
        let (inverse, kept) = self.orthogonal(held);
        let b =
            |i: usize| -> f64 { (0..=i).map(|j| inverse[i][j] * self.along[held[kept[j]]]).sum() };
        (0..kept.len()).map(|i| b(i) * b(i)).sum()
    }

    /// L⁻¹ of the held atoms' Gram matrix L Lᵀ, and which of them were kept: those in the span of
    /// the ones before are left out.
    fn orthogonal(&self, held: &[usize]) -> ([[f64; MAX_CONTACTS]; MAX_CONTACTS], Kept) {
        let mut kept = Kept::default();
        let mut inverse = [[0.0; MAX_CONTACTS]; MAX_CONTACTS];
        for place in 0..held.len() {
            kept.push(place);
            let n = kept.len();
            let mut l = [0.0; MAX_CONTACTS * MAX_CONTACTS];
            for i in 0..n {
                for j in 0..n {
                    l[i * n + j] = dot(self.atom(held[kept[i]]), self.atom(held[kept[j]]));
                }
            }
            if !cholesky(&mut l[..n * n], n, 1e-8) {
                kept.pop();
                continue;
            }
            for j in 0..n {
                for i in j..n {
                    let unit = if i == j { 1.0 } else { 0.0 };
                    let sum: f64 = (j..i).map(|p| l[i * n + p] * inverse[p][j]).sum();
                    inverse[i][j] = (unit - sum) / l[i * n + i];
                }
            }
        }
        (inverse, kept)
    }
}

/// A short list without allocation.
#[derive(Clone, Copy, Debug, Default)]
struct Kept {
    places: [usize; MAX_CONTACTS],
    n: usize,
}

impl Kept {
    fn push(&mut self, place: usize) {
        if self.n < MAX_CONTACTS {
            self.places[self.n] = place;
            self.n += 1;
        }
    }

    fn pop(&mut self) {
        self.n = self.n.saturating_sub(1);
    }
}

impl std::ops::Deref for Kept {
    type Target = [usize];

    fn deref(&self) -> &[usize] {
        &self.places[..self.n]
    }
}

fn plain(c: &[f32], gains: &mut [f32]) {
    for (gain, c) in gains.iter_mut().zip(c) {
        let c = c.max(0.0);
        *gain = c * c;
    }
}

#[inline(always)]
fn beside<const K: usize>(
    c: &[f32],
    rows: [&[f32]; K],
    b: [f32; K],
    t: &[[f32; MAX_CONTACTS]; MAX_CONTACTS],
    gains: &mut [f32],
) {
    let n = gains.len();
    let (c, rows) = (&c[..n], rows.map(|row| &row[..n]));
    let n_whole = n - n % LANES;
    for first in (0..n_whole).step_by(LANES) {
        let at = |row: &[f32]| std::array::from_fn::<f32, LANES, _>(|lane| row[first + lane]);
        let found = gains_of(&at(c), &rows.map(at), &b, t);
        gains[first..first + LANES].copy_from_slice(&found);
    }
    for site in n_whole..n {
        [gains[site]] = gains_of(&[c[site]], &rows.map(|row| [row[site]]), &b, t);
    }
}

#[inline(always)]
fn gains_of<const K: usize, const N: usize>(
    c: &[f32; N],
    rows: &[[f32; N]; K],
    b: &[f32; K],
    t: &[[f32; MAX_CONTACTS]; MAX_CONTACTS],
) -> [f32; N] {
    let (mut along, mut left) = (*c, [1.0; N]);
    for i in 0..K {
        let mut q = [0.0; N];
        for j in 0..=i {
            for lane in 0..N {
                q[lane] += t[i][j] * rows[j][lane];
            }
        }
        for lane in 0..N {
            along[lane] -= b[i] * q[lane];
            left[lane] -= q[lane] * q[lane];
        }
    }
    std::array::from_fn(|lane| {
        let is_usable = (along[lane] > 0.0) & (left[lane] > LEAST_SINE_2);
        let gain = along[lane] * along[lane] / left[lane];
        if is_usable { gain } else { 0.0 }
    })
}

impl Model {
    /// The largest local maxima of `gains`, largest first, at most `n`.
    pub(crate) fn peaks(&self, gains: &[f32], n: usize, out: &mut Vec<Gain>) {
        let is_peak = |site: usize| {
            let near = self.sites.near(site);
            near.iter().all(|&other| gains[other as usize] <= gains[site])
        };
        ranked(gains, n, is_peak, out);
    }

    /// The sites with the largest `gains`, largest first, at most `n`.
    pub(crate) fn largest(&self, gains: &[f32], n: usize, out: &mut Vec<Gain>) {
        ranked(gains, n, |_| true, out);
    }

    /// The site with the largest gain.
    pub(crate) fn best_site(gains: &[f32]) -> Gain {
        let mut best = Gain { site: 0, gain: 0.0 };
        for (site, &gain) in gains.iter().enumerate() {
            if gain > best.gain {
                best = Gain { site, gain };
            }
        }
        best
    }
}

/// The largest of those `gains` that are above 0 and `wanted`, largest first, at most `n`.
fn ranked(gains: &[f32], n: usize, wanted: impl Fn(usize) -> bool, out: &mut Vec<Gain>) {
    out.clear();
    for (site, &gain) in gains.iter().enumerate() {
        let is_low = gain <= 0.0 || (out.len() == n && gain <= out[n - 1].gain);
        if is_low || !wanted(site) {
            continue;
        }
        let place = out.partition_point(|other| other.gain >= gain);
        if out.len() == n {
            out.pop();
        }
        out.insert(place, Gain { site, gain });
    }
}
