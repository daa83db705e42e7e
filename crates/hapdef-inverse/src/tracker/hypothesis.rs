//! One hypothesis: contacts, what the map misses at each of them, and how sure both are.

use hapdef_contact::Phase;
use nalgebra::{Matrix3, Point3, Vector3};

use crate::estimator::{MAX_CONTACTS, Model};
use crate::skin_point::SkinPoint;
use crate::tracker::frame::ContactId;

/// A held contact is where it was if it is within this, m.
const SAME_PLACE_M: f64 = 2e-3;

/// A contact of a hypothesis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Track {
    pub(super) id: ContactId,
    pub(super) point: SkinPoint,
    pub(super) phase: Phase,
    pub(super) born: u64,
    pub(super) force_n: f64,
    /// What the noise of one frame does to it, standard deviation, N.
    pub(super) force_noise_n: f64,
    /// Mean of the last frames in which it was steady, and how many.
    pub(super) steady: (f64, usize),
    /// Frames with hardly any force, less twice those with more.
    pub(super) n_weak: usize,
    pub(super) covariance: Matrix3<f64>,
    /// Where a contact that slides began to, m, and how far it may have gone since, standard
    /// deviation, m.
    pub(super) slide: Option<(Point3<f64>, f64)>,
}

impl Track {
    pub(super) fn new(id: ContactId, point: SkinPoint, born: u64) -> Self {
        Self {
            slide: None,
            id,
            point,
            phase: Phase::Born,
            born,
            force_n: 0.0,
            force_noise_n: 0.0,
            steady: (0.0, 0),
            n_weak: 0,
            covariance: Matrix3::zeros(),
        }
    }

    pub(super) fn is_mobile(&self) -> bool {
        self.phase != Phase::Held
    }
}

/// Contact i has state (u₁, u₂, δ): its place along the tangents at `point`, m, and the error of the
/// map there, whitened by the noise, per N; a frame reads Σ Aᵢ (g(pᵢ) + δᵢ). The covariance `p` is
/// joint over the contacts. A contact that moves has u known and δ as the map's error says: its
/// place is searched, not filtered.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Hypothesis {
    pub(super) n: usize,
    pub(super) tracks: [Track; MAX_CONTACTS],
    /// States of a contact: 2, and one for each gauge where the map has errors.
    pub(super) d: usize,
    pub(super) stride: usize,
    pub(super) width: usize,
    /// `[MAX_CONTACTS, width]`.
    pub(super) delta: Vec<f64>,
    /// `[stride, stride]`.
    pub(super) p: Vec<f64>,
    /// g + δ `[MAX_CONTACTS, width]`.
    pub(super) atoms: Vec<f64>,
    /// ∂g `[MAX_CONTACTS, 2, width]`.
    pub(super) slopes: Vec<f64>,
    pub(super) tangents: [[Vector3<f64>; 2]; MAX_CONTACTS],
    /// −2 ln of how probable the frames so far are, up to what all hypotheses share.
    pub(super) data_cost: f64,
    /// The most that the forces' prior has added to that, Σ (A/σ)² with the prior's σ.
    pub(super) prior_penalty: f64,
    /// What it was behind the best hypothesis when the contacts that move came.
    pub(super) handicap: f64,
}

impl Hypothesis {
    pub(super) fn new(model: &Model) -> Self {
        let d = 2 + if model.base.is_some() { model.m } else { 0 };
        let stride = MAX_CONTACTS * d;
        let nowhere = SkinPoint::trusted(0, [1.0, 0.0, 0.0]);
        Self {
            n: 0,
            tracks: [Track::new(ContactId(0), nowhere, 0); MAX_CONTACTS],
            d,
            stride,
            width: model.width,
            delta: vec![0.0; MAX_CONTACTS * model.width],
            p: vec![0.0; stride * stride],
            atoms: vec![0.0; MAX_CONTACTS * model.width],
            slopes: vec![0.0; 2 * MAX_CONTACTS * model.width],
            tangents: [[Vector3::zeros(); 2]; MAX_CONTACTS],
            data_cost: 0.0,
            prior_penalty: 0.0,
            handicap: 0.0,
        }
    }

    pub(super) fn copy_from(&mut self, other: &Self) {
        let (n, width) = (other.n, self.width);
        self.n = n;
        self.tracks = other.tracks;
        self.tangents = other.tangents;
        self.data_cost = other.data_cost;
        self.prior_penalty = other.prior_penalty;
        self.handicap = other.handicap;
        for (mine, theirs, each) in [
            (&mut self.delta, &other.delta, width),
            (&mut self.atoms, &other.atoms, width),
            (&mut self.slopes, &other.slopes, 2 * width),
            (&mut self.p, &other.p, self.d * self.stride),
        ] {
            mine[..n * each].copy_from_slice(&theirs[..n * each]);
        }
    }

    /// −2 ln of how probable it is: smaller is better.
    pub(super) fn cost(&self) -> f64 {
        self.data_cost + self.prior_penalty
    }

    pub(super) fn set_cost(&mut self, cost: f64) {
        (self.data_cost, self.prior_penalty) = (cost, 0.0);
    }

    pub(super) fn tracks(&self) -> &[Track] {
        &self.tracks[..self.n]
    }

    pub(super) fn n_mobile(&self) -> usize {
        self.tracks().iter().filter(|track| track.is_mobile()).count()
    }

    /// Forces of the contacts that move, together.
    pub(super) fn mobile_force(&self) -> f64 {
        let mobile = self.tracks().iter().filter(|track| track.is_mobile());
        mobile.map(|track| track.force_n).sum()
    }

    pub(super) fn forces(&self) -> [f64; MAX_CONTACTS] {
        std::array::from_fn(|i| if i < self.n { self.tracks[i].force_n } else { 0.0 })
    }

    pub(super) fn set_forces(&mut self, forces: &[f64; MAX_CONTACTS], scale: f64) {
        for (track, force) in self.tracks[..self.n].iter_mut().zip(forces) {
            track.force_n = force / scale;
        }
    }

    /// Adds a contact that moves.
    pub(super) fn push(&mut self, model: &Model, track: Track) {
        if self.n == MAX_CONTACTS {
            return;
        }
        let i = self.n;
        self.n += 1;
        self.tracks[i] = track;
        self.forget(model, i);
    }

    /// Lets contact `i` move: what was learnt of the map at its place holds no more.
    pub(super) fn forget(&mut self, model: &Model, i: usize) {
        let (d, n, width) = (self.d, self.n * self.d, self.width);
        for a in i * d..(i + 1) * d {
            for b in 0..n {
                self.p[a * self.stride + b] = 0.0;
                self.p[b * self.stride + a] = 0.0;
            }
        }
        self.delta[i * width..(i + 1) * width].fill(0.0);
        self.set_map_error(model, i);
        self.linearise(model, i);
    }

    /// Lets all held contacts move that `trusted` doesn't hold in the same place.
    pub(super) fn doubt(&mut self, model: &Model, trusted: &Self) {
        let place = |track: &Track| model.skin().position(&track.point);
        for i in 0..self.n {
            let track = self.tracks[i];
            let is_same = |other: &Track| {
                other.id == track.id && (place(other) - place(&track)).norm() <= SAME_PLACE_M
            };
            if !track.is_mobile() && !trusted.tracks().iter().any(is_same) {
                self.tracks[i].phase = Phase::Born;
                self.forget(model, i);
            }
        }
    }

    /// Standard deviation of what the places of sliding contacts are behind by, m: for the residuals of frames, not where
    /// places are searched.
    pub(super) fn set_lag(&mut self, sd_m: f64) {
        for i in (0..self.n).filter(|&i| self.tracks[i].phase == Phase::Sliding) {
            for a in i * self.d..i * self.d + 2 {
                self.p[a * self.stride + a] = sd_m * sd_m;
            }
        }
    }

    /// The map's error at contact `i` as the map reports it.
    pub(super) fn set_map_error(&mut self, model: &Model, i: usize) {
        if self.d == 2 {
            return;
        }
        let m = model.m;
        let error = model.error_at(&self.tracks[i].point);
        let first = i * self.d + 2;
        for (a, row) in error.chunks_exact(m).enumerate() {
            let at = (first + a) * self.stride + first;
            self.p[at..at + m].copy_from_slice(row);
        }
    }

    /// Atom and slopes of contact `i` where it is.
    pub(super) fn linearise(&mut self, model: &Model, i: usize) {
        let width = self.width;
        let point = &self.tracks[i].point;
        let frame = model.skin().frame(point);
        let weights = model.interpolant().weights(&point.bary(), &frame);
        let (rows, interpolant) = (model.rows(), model.interpolant());
        let atom = &mut self.atoms[i * width..(i + 1) * width];
        interpolant.combine(rows, point, &weights.value, atom);
        crate::dense::add_scaled(atom, 1.0, &self.delta[i * width..(i + 1) * width]);
        let slopes = &mut self.slopes[2 * i * width..2 * (i + 1) * width];
        for (slope, weights) in slopes.chunks_exact_mut(width).zip(&weights.slope) {
            interpolant.combine(rows, point, weights, slope);
        }
        self.tangents[i] = frame.tangents;
    }

    /// Lets contact `i` go; the others know what they knew.
    pub(super) fn remove(&mut self, i: usize) {
        let (d, n, width) = (self.d, self.n * self.d, self.width);
        for a in 0..n {
            let row = a * self.stride;
            self.p.copy_within(row + (i + 1) * d..row + n, row + i * d);
        }
        for a in (i + 1) * d..n {
            let from = a * self.stride;
            self.p.copy_within(from..from + n, from - d * self.stride);
        }
        let end = self.n * width;
        self.delta.copy_within((i + 1) * width..end, i * width);
        self.atoms.copy_within((i + 1) * width..end, i * width);
        self.slopes.copy_within(2 * (i + 1) * width..2 * end, 2 * i * width);
        self.tracks.copy_within(i + 1..self.n, i);
        self.tangents.copy_within(i + 1..self.n, i);
        self.n -= 1;
    }

    /// Moves contact `i` to `point`, its tangents' covariance with it.
    pub(super) fn carry(&mut self, model: &Model, i: usize, point: SkinPoint) {
        let old = self.tangents[i];
        self.tracks[i].point = point;
        self.linearise(model, i);
        let new = self.tangents[i];
        let turn = |p: usize, q: usize| new[p].dot(&old[q]);
        let (first, n, stride) = (i * self.d, self.n * self.d, self.stride);
        for b in 0..n {
            let [x, y] = [self.p[first * stride + b], self.p[(first + 1) * stride + b]];
            for p in 0..2 {
                self.p[(first + p) * stride + b] = turn(p, 0) * x + turn(p, 1) * y;
            }
        }
        for a in 0..n {
            let [x, y] = [self.p[a * stride + first], self.p[a * stride + first + 1]];
            for p in 0..2 {
                self.p[a * stride + first + p] = turn(p, 0) * x + turn(p, 1) * y;
            }
        }
    }
}
