//! The mean of a nodal field under a round tip.

use std::ops::Range;

use nalgebra::{Point3, Vector3};

use crate::basis::{self, NODES};
use crate::error::{InverseError, check_not_negative};
use crate::skin::Skin;
use crate::skin_point::SkinPoint;

/// Faces are split until a piece is shorter than this share of the tip radius.
const PIECE_PER_RADIUS: f64 = 0.25;

/// Splits at most, a bound for tips far smaller than a face.
const MAX_SPLITS: u32 = 12;

/// Barycentric coordinates and weight of the seven-point rule of degree 5; the weights sum to 1
/// (Dunavant, Int. J. Numer. Meth. Eng. 21, 1985, table II, p = 5).
const RULE: [([f64; 3], f64); 7] = {
    const A: f64 = 0.470_142_064_105_115_1;
    const B: f64 = 0.101_286_507_323_456_34;
    const WA: f64 = 0.132_394_152_788_506_2;
    const WB: f64 = 0.125_939_180_544_827_16;
    const T: f64 = 1.0 / 3.0;
    [
        ([T, T, T], 0.225),
        ([1.0 - 2.0 * A, A, A], WA),
        ([A, 1.0 - 2.0 * A, A], WA),
        ([A, A, 1.0 - 2.0 * A], WA),
        ([1.0 - 2.0 * B, B, B], WB),
        ([B, 1.0 - 2.0 * B, B], WB),
        ([B, B, 1.0 - 2.0 * B], WB),
    ]
};

/// Radius of the ring that smears a response as a tip of `radius_m` does, to second order, where a tip of
/// `within_m` is in the response already, m; 0 for a tip that is no wider. Under a pressure that goes
/// with (1 − (d/r)²)² the mean of d² is r²/4, on a ring the square of its radius.
#[must_use]
pub fn tip_ring_m(radius_m: f64, within_m: f64) -> f64 {
    0.5 * (radius_m * radius_m - within_m * within_m).max(0.0).sqrt()
}

/// What a round tip at each node of a skin averages over.
#[derive(Clone, Debug)]
pub struct TipMeans {
    /// Where each node's shares begin, and where the last ones end `[n_nodes + 1]`.
    starts: Vec<usize>,
    /// A node and its share of the mean; those of a tip are 1 together.
    shares: Vec<(u32, f64)>,
}

impl TipMeans {
    /// A tip of `radius_m` at every node of `skin`, whose pressure at distance d goes with
    /// (1 − (d/r)²)²; a radius of 0 is a point force.
    ///
    /// # Errors
    /// [`InverseError`] for a radius that is negative or not finite.
    pub fn new(skin: &Skin, radius_m: f64) -> Result<Self, InverseError> {
        check_not_negative("tip_radius_m", radius_m)?;
        let mut under: Vec<Vec<(u32, f64)>> = vec![Vec::new(); skin.n_nodes()];
        if radius_m > 0.0 {
            for face in 0..skin.n_faces() {
                for tip in Pressed::face(skin, face, radius_m).tips {
                    let shares = skin.face_nodes(face).iter().copied().zip(tip.shares);
                    under[tip.node].extend(shares);
                }
            }
        }
        let mut means = Self { starts: vec![0], shares: Vec::new() };
        for (node, shares) in under.into_iter().enumerate() {
            means.push(node as u32, shares);
        }
        Ok(means)
    }

    /// Nodes of the skin.
    pub(crate) fn n_nodes(&self) -> usize {
        self.starts.len() - 1
    }

    /// At every node the mean of `nodal` `[n_nodes, width]` under the tip there.
    pub(crate) fn of(&self, nodal: &[f64], width: usize) -> Vec<f64> {
        let mut means = vec![0.0; nodal.len()];
        for (out, ends) in means.chunks_exact_mut(width).zip(self.starts.windows(2)) {
            for &(node, share) in &self.shares[ends[0]..ends[1]] {
                let values = &nodal[node as usize * width..(node as usize + 1) * width];
                for (out, value) in out.iter_mut().zip(values) {
                    *out += share * value;
                }
            }
        }
        means
    }

    /// Adds the next node's shares: of each other node the sum, all of them 1 together; the node
    /// itself alone where nothing is under its tip.
    fn push(&mut self, node: u32, mut shares: Vec<(u32, f64)>) {
        let total: f64 = shares.iter().map(|(_, share)| share).sum();
        if total > 0.0 {
            shares.sort_by_key(|(other, _)| *other);
            for same in shares.chunk_by(|a, b| a.0 == b.0) {
                let sum: f64 = same.iter().map(|(_, share)| share).sum();
                self.shares.push((same[0].0, sum / total));
            }
        } else {
            self.shares.push((node, 1.0));
        }
        self.starts.push(self.shares.len());
    }
}

/// A ball around a face: a quadratic map stays within the hull of its Bézier points, which reach
/// at most as far beyond the mid-side nodes as these beyond the edges' middles.
fn ball(skin: &Skin, face: usize) -> (Point3<f64>, f64) {
    let nodes: Vec<Vector3<f64>> =
        skin.face_nodes(face).iter().map(|&n| skin.nodes()[n as usize].coords).collect();
    let middle: Vector3<f64> = nodes[..3].iter().sum::<Vector3<f64>>() / 3.0;
    let reach = nodes.iter().map(|p| (p - middle).norm()).fold(0.0, f64::max);
    (Point3::from(middle), 1.5 * reach)
}

/// A face under the tips that may reach it. A piece is looked at once for all of them.
struct Pressed<'a> {
    skin: &'a Skin,
    face: u32,
    radius_m: f64,
    tips: Vec<Tip>,
    /// Tips that may reach the piece that is looked at, after those of the pieces that it is part of.
    near: Vec<usize>,
}

/// A tip at a node, and ∫ Nᵢ κ dA over the face under it.
struct Tip {
    node: usize,
    centre: Point3<f64>,
    shares: [f64; 6],
}

impl<'a> Pressed<'a> {
    fn face(skin: &'a Skin, face: usize, radius_m: f64) -> Self {
        let (middle, reach_m) = ball(skin, face);
        let is_near = |centre: &Point3<f64>| (middle - centre).norm() <= radius_m + reach_m;
        let tips: Vec<Tip> = skin
            .nodes()
            .iter()
            .enumerate()
            .filter(|(_, centre)| is_near(centre))
            .map(|(node, &centre)| Tip { node, centre, shares: [0.0; 6] })
            .collect();
        let mut pressed =
            Self { skin, face: face as u32, radius_m, near: (0..tips.len()).collect(), tips };
        pressed.integrate(&[NODES[0], NODES[1], NODES[2]], 0, 0..pressed.tips.len());
        pressed
    }

    /// Adds the integrals over the piece of the face with the given corners for the tips in the
    /// places `above` of `near`.
    fn integrate(&mut self, piece: &[[f64; 3]; 3], splits: u32, above: Range<usize>) {
        let middle = self.at(within(piece, &[1.0 / 3.0; 3]));
        let reach_m = piece
            .iter()
            .chain(&mids(piece))
            .map(|&b| (self.at(b) - middle).norm())
            .fold(0.0, f64::max);
        let first = self.near.len();
        for place in above {
            let tip = self.near[place];
            if (middle - self.tips[tip].centre).norm() <= self.radius_m + 1.5 * reach_m {
                self.near.push(tip);
            }
        }
        let here = first..self.near.len();
        if !here.is_empty() && reach_m > PIECE_PER_RADIUS * self.radius_m && splits < MAX_SPLITS {
            let [a, b, c] = *piece;
            let [ab, bc, ca] = mids(piece);
            for part in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]] {
                self.integrate(&part, splits + 1, here.clone());
            }
        } else {
            self.add(piece, splits, here);
        }
        self.near.truncate(first);
    }

    /// Adds what the points of the rule on one piece give.
    fn add(&mut self, piece: &[[f64; 3]; 3], splits: u32, here: Range<usize>) {
        if here.is_empty() {
            return;
        }
        for (inner, weight) in RULE {
            let b = within(piece, &inner);
            let point = self.at(b);
            let area = self.skin.area_vector(self.face, &b).norm() * 0.25_f64.powi(splits as i32);
            let n = if self.skin.is_quadratic() {
                basis::quadratic(&b)
            } else {
                [b[0], b[1], b[2], 0.0, 0.0, 0.0]
            };
            let n_area = n.map(|n| n * weight * area);
            for &tip in &self.near[here.clone()] {
                let tip = &mut self.tips[tip];
                let d_2 = (point - tip.centre).norm_squared() / (self.radius_m * self.radius_m);
                if d_2 < 1.0 {
                    let pressure = (1.0 - d_2) * (1.0 - d_2);
                    for (share, n_area) in tip.shares.iter_mut().zip(n_area) {
                        *share += n_area * pressure;
                    }
                }
            }
        }
    }

    fn at(&self, b: [f64; 3]) -> Point3<f64> {
        self.skin.position(&SkinPoint::trusted(self.face, b))
    }
}

fn within(piece: &[[f64; 3]; 3], inner: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|c| (0..3).map(|i| piece[i][c] * inner[i]).sum())
}

fn mids(piece: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    std::array::from_fn(|e| std::array::from_fn(|c| 0.5 * (piece[e][c] + piece[(e + 1) % 3][c])))
}
