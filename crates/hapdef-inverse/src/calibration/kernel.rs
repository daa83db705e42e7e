//! The residual's covariance between points of the skin.

use nalgebra::Point3;

use crate::skin::Skin;

/// Where the map's size is averaged, at most this many widths away.
const REACH: f64 = 3.5;

/// k(p, q) = s² a(p) a(q) M(|p − q| / ℓ): a Matérn covariance of smoothness 5/2 (Rasmussen &
/// Williams 2006, equation 4.17), which is positive definite in space and so on any surface in it,
/// scaled by the map's size a near p, since where a gauge answers more it errs more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Kernel {
    /// ℓ, m.
    pub(crate) length_m: f64,
    /// s.
    pub(crate) size: f64,
    /// Part of the gauge's mean square over the skin in a².
    pub(crate) floor: f64,
}

impl Kernel {
    /// a(p) from the map's local mean square and that over the skin.
    pub(crate) fn amplitude(&self, local_square: f64, mean_square: f64) -> f64 {
        self.size * (local_square + self.floor * mean_square).sqrt()
    }

    /// M at a squared distance, m².
    #[inline]
    pub(crate) fn correlation(&self, distance_2: f64) -> f64 {
        let r = (5.0 * distance_2).sqrt() / self.length_m;
        (1.0 + r + r * r / 3.0) * (-r).exp()
    }
}

/// Mean squares of `nodal` `[n_nodes, n_gauges]` around each of `points`, by Gaussian weights of
/// width `width_m`: `[n_points, n_gauges]`.
pub(crate) fn local_squares(
    skin: &Skin,
    nodal: &[f64],
    n_gauges: usize,
    points: &[Point3<f64>],
    width_m: f64,
) -> Vec<f64> {
    let mut squares = vec![0.0; points.len() * n_gauges];
    let reach_2 = (REACH * width_m).powi(2);
    for (x, out) in points.iter().zip(squares.chunks_exact_mut(n_gauges)) {
        let mut total = 0.0;
        let mut nearest = (f64::INFINITY, 0);
        for (node, y) in skin.nodes().iter().enumerate() {
            let d_2 = (x - y).norm_squared();
            if d_2 < nearest.0 {
                nearest = (d_2, node);
            }
            if d_2 > reach_2 {
                continue;
            }
            let weight = (-0.5 * d_2 / (width_m * width_m)).exp();
            total += weight;
            for (out, g) in out.iter_mut().zip(&nodal[node * n_gauges..]) {
                *out += weight * g * g;
            }
        }
        if total > 0.0 {
            out.iter_mut().for_each(|v| *v /= total);
        } else {
            let row = &nodal[nearest.1 * n_gauges..];
            out.iter_mut().zip(row).for_each(|(v, g)| *v = g * g);
        }
    }
    squares
}
