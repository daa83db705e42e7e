//! The residual's covariance between points of the skin.

use nalgebra::Point3;

/// Where the map is averaged, at most this many widths away.
const REACH: f64 = 3.5;

/// k(p, q) = s² a(p) a(q) M(|p − q| / ℓ) + t² b(p) b(q) M(|p − q| / λ), with a Matérn covariance M of
/// smoothness 5/2 (Rasmussen & Williams 2006, equation 4.17), which is positive definite in space and
/// so on any surface in it. a is the map's size near p, since where a gauge answers more it errs more.
/// b is how much the map varies there within millimetres, as it does around a gauge: what is not known
/// of the gauge's place and of the wall under it shows there, and nowhere else.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Kernel {
    /// ℓ, m.
    pub(crate) length_m: f64,
    /// s.
    pub(crate) size: f64,
    /// Part of the gauge's mean square over the skin in a².
    pub(crate) floor: f64,
    /// λ, m.
    pub(crate) steep_length_m: f64,
    /// t.
    pub(crate) steep_size: f64,
}

/// A map around a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Around {
    /// Mean square within the envelope.
    pub(crate) square: f64,
    /// Variance within millimetres.
    pub(crate) variance: f64,
}

/// Standard deviations of the two parts of the process at a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Amplitude {
    broad: f64,
    steep: f64,
}

impl Kernel {
    /// s a and t b at a point, `mean_square` being the map's over the skin.
    pub(crate) fn amplitude(&self, around: Around, mean_square: f64) -> Amplitude {
        Amplitude {
            broad: self.size * (around.square + self.floor * mean_square).sqrt(),
            steep: self.steep_size * around.variance.sqrt(),
        }
    }

    /// k of two points from their amplitudes and squared distance, m².
    #[inline]
    pub(crate) fn covariance(&self, p: Amplitude, q: Amplitude, distance_2: f64) -> f64 {
        let broad = p.broad * q.broad * matern(distance_2, self.length_m);
        let steep = p.steep * q.steep;
        if steep > 0.0 { broad + steep * matern(distance_2, self.steep_length_m) } else { broad }
    }

    /// k of a point with itself.
    pub(crate) fn variance(p: Amplitude) -> f64 {
        p.broad * p.broad + p.steep * p.steep
    }
}

/// M at a squared distance, m².
#[inline]
fn matern(distance_2: f64, length_m: f64) -> f64 {
    let r = (5.0 * distance_2).sqrt() / length_m;
    (1.0 + r + r * r / 3.0) * (-r).exp()
}

/// Values `nodal` `[n_nodes, n_gauges]` at `nodes` around each of `points`, by Gaussian weights, mean
/// squares of the width `envelope_m`, variances of `steep_m`: `[n_points, n_gauges]`.
pub(crate) fn around(
    nodes: &[Point3<f64>],
    nodal: &[f64],
    n_gauges: usize,
    points: &[Point3<f64>],
    [envelope_m, steep_m]: [f64; 2],
) -> Vec<Around> {
    let mut found = Vec::with_capacity(points.len() * n_gauges);
    for x in points {
        let (mut far, mut near) = (Moments::new(n_gauges), Moments::new(n_gauges));
        let mut nearest = (f64::INFINITY, 0);
        for (node, row) in nodal.chunks_exact(n_gauges).enumerate() {
            let distance_2 = (x - nodes[node]).norm_squared();
            if distance_2 < nearest.0 {
                nearest = (distance_2, node);
            }
            far.add(row, distance_2, envelope_m);
            near.add(row, distance_2, steep_m);
        }
        let alone = &nodal[nearest.1 * n_gauges..][..n_gauges];
        found.extend((0..n_gauges).map(|gauge| {
            let square = far.mean(&far.squares, gauge);
            Around {
                square: square.unwrap_or(alone[gauge] * alone[gauge]),
                variance: near.variance(gauge),
            }
        }));
    }
    found
}

/// Weighted sums of values and their squares.
struct Moments {
    weight: f64,
    values: Vec<f64>,
    squares: Vec<f64>,
}

impl Moments {
    fn new(n: usize) -> Self {
        Self { weight: 0.0, values: vec![0.0; n], squares: vec![0.0; n] }
    }

    fn add(&mut self, row: &[f64], distance_2: f64, width_m: f64) {
        if distance_2 > (REACH * width_m).powi(2) {
            return;
        }
        let weight = (-0.5 * distance_2 / (width_m * width_m)).exp();
        self.weight += weight;
        for (i, value) in row.iter().enumerate() {
            self.values[i] += weight * value;
            self.squares[i] += weight * value * value;
        }
    }

    fn mean(&self, sums: &[f64], gauge: usize) -> Option<f64> {
        (self.weight > 0.0).then(|| sums[gauge] / self.weight)
    }

    fn variance(&self, gauge: usize) -> f64 {
        let mean = self.mean(&self.values, gauge).unwrap_or(0.0);
        let square = self.mean(&self.squares, gauge).unwrap_or(0.0);
        (square - mean * mean).max(0.0)
    }
}
