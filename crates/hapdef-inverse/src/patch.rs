//! The mean of a nodal field under a round tip.

use nalgebra::{Point3, Vector3};

use crate::basis::{self, NODES};
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

/// At every node the mean of `nodal` `[n_nodes, width]` under a tip of radius r there, whose
/// pressure at distance d goes with (1 − (d/r)²)².
pub(crate) fn patch_means(skin: &Skin, nodal: &[f64], width: usize, radius_m: f64) -> Vec<f64> {
    let balls: Vec<_> = (0..skin.n_faces()).map(|f| ball(skin, f)).collect();
    let mut means = vec![0.0; nodal.len()];
    for node in 0..skin.n_nodes() {
        let tip = Tip {
            skin,
            centre: skin.nodes()[node],
            radius_m,
        };
        let out = &mut means[node * width..(node + 1) * width];
        let mut total = 0.0;
        for (face, (middle, reach_m)) in balls.iter().enumerate() {
            if (middle - tip.centre).norm() > radius_m + reach_m {
                continue;
            }
            let mut shares = [0.0; 6];
            tip.integrate(face as u32, &[NODES[0], NODES[1], NODES[2]], 0, &mut shares);
            total += shares.iter().sum::<f64>();
            for (&n, share) in skin.face_nodes(face).iter().zip(shares) {
                let values = &nodal[n as usize * width..(n as usize + 1) * width];
                for (out, value) in out.iter_mut().zip(values) {
                    *out += share * value;
                }
            }
        }
        if total > 0.0 {
            out.iter_mut().for_each(|v| *v /= total);
        } else {
            out.copy_from_slice(&nodal[node * width..(node + 1) * width]);
        }
    }
    means
}

/// A ball around a face: a quadratic map stays within the hull of its Bézier points, which reach
/// at most as far beyond the mid-side nodes as these beyond the edges' middles.
fn ball(skin: &Skin, face: usize) -> (Point3<f64>, f64) {
    let nodes: Vec<Vector3<f64>> = skin
        .face_nodes(face)
        .iter()
        .map(|&n| skin.nodes()[n as usize].coords)
        .collect();
    let middle: Vector3<f64> = nodes[..3].iter().sum::<Vector3<f64>>() / 3.0;
    let reach = nodes
        .iter()
        .map(|p| (p - middle).norm())
        .fold(0.0, f64::max);
    (Point3::from(middle), 1.5 * reach)
}

struct Tip<'a> {
    skin: &'a Skin,
    centre: Point3<f64>,
    radius_m: f64,
}

impl Tip<'_> {
    /// Adds ∫ Nᵢ κ dA over the piece of `face` with the given corners.
    fn integrate(&self, face: u32, piece: &[[f64; 3]; 3], splits: u32, shares: &mut [f64; 6]) {
        let at = |b: [f64; 3]| self.skin.position(&SkinPoint::trusted(face, b));
        let middle = at(within(piece, &[1.0 / 3.0; 3]));
        let reach_m = piece
            .iter()
            .chain(&mids(piece))
            .map(|&b| (at(b) - middle).norm())
            .fold(0.0, f64::max);
        if (middle - self.centre).norm() > self.radius_m + 1.5 * reach_m {
            return;
        }
        if reach_m > PIECE_PER_RADIUS * self.radius_m && splits < MAX_SPLITS {
            let [a, b, c] = *piece;
            let [ab, bc, ca] = mids(piece);
            for part in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]] {
                self.integrate(face, &part, splits + 1, shares);
            }
            return;
        }
        for (inner, weight) in RULE {
            let b = within(piece, &inner);
            let d_2 = (at(b) - self.centre).norm_squared() / (self.radius_m * self.radius_m);
            if d_2 < 1.0 {
                let pressure = (1.0 - d_2) * (1.0 - d_2);
                let area = self.skin.area_vector(face, &b).norm() * 0.25_f64.powi(splits as i32);
                let n = if self.skin.is_quadratic() {
                    basis::quadratic(&b)
                } else {
                    [b[0], b[1], b[2], 0.0, 0.0, 0.0]
                };
                for (share, n) in shares.iter_mut().zip(n) {
                    *share += n * weight * area * pressure;
                }
            }
        }
    }
}

fn within(piece: &[[f64; 3]; 3], inner: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|c| (0..3).map(|i| piece[i][c] * inner[i]).sum())
}

fn mids(piece: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    std::array::from_fn(|e| std::array::from_fn(|c| 0.5 * (piece[e][c] + piece[(e + 1) % 3][c])))
}
