//! Presses turned to residuals of the map per newton, with their noise and mode columns.

use nalgebra::Point3;

use crate::calibration::kernel::{Around, around};
use crate::calibration::output::BeyondPrior;
use crate::calibration::params::{CalibrationParams, ModeMap, ModeScope};
use crate::calibration::press::Press;
use crate::error::{InverseError, check_length, check_not_negative};
use crate::response::{Mix, ResponseMap};
use crate::skin_point::SkinPoint;

/// Presses without which no calibration is tried: fewer leave hardly a neighbour to check any of them by.
pub const LEAST_PRESSES: usize = 12;

/// A cause this many standard deviations of its prior away is worth a warning: by chance one of 16,000 is.
const BEYOND_SDS: f64 = 4.0;

/// Readings over the map's that a coarse mesh or a wrong stiffness may explain. Beyond, a unit, a sign or
/// a channel is wrong, and a fit would hide it in the gains.
const SCALES: [f64; 2] = [0.05, 20.0];

/// The presses' extent is at least this share of the skin's: presses in one spot would leave a map that
/// says it is calibrated, and is so only there.
const LEAST_EXTENT: f64 = 0.1;

/// The modes as columns, scaled so that every coefficient has a prior of unit variance.
pub(crate) struct Basis<'a> {
    pub(crate) map: &'a ResponseMap,
    pub(crate) modes: &'a [ModeMap<'a>],
    pub(crate) gain_sd: f64,
    /// `[n_gauges, n_gauges]`: scale of what gauge i takes from gauge j; empty for no mix.
    mix: Vec<f64>,
}

impl<'a> Basis<'a> {
    pub(crate) fn new(
        map: &'a ResponseMap,
        modes: &'a [ModeMap<'a>],
        params: &CalibrationParams,
        mean_squares: &[f64],
    ) -> Result<Self, InverseError> {
        for mode in modes {
            check_length("a mode's gauges", map.n_gauges(), mode.map.n_gauges())?;
            let (n, found) = (map.skin().n_nodes(), mode.map.skin().n_nodes());
            check_length("a mode's nodes", n, found)?;
            check_not_negative("a mode's prior_sd", mode.prior_sd)?;
        }
        let m = map.n_gauges();
        let mut mix = Vec::new();
        if params.mix_sd > 0.0 {
            for i in 0..m {
                for j in 0..m {
                    let ratio = (mean_squares[i] / mean_squares[j]).sqrt();
                    mix.push(if i == j { 0.0 } else { params.mix_sd * ratio });
                }
            }
        }
        Ok(Self { map, modes, gain_sd: params.gain_sd, mix })
    }

    /// Columns with a coefficient for each gauge.
    pub(crate) fn n_own(&self) -> usize {
        let mixed = if self.mix.is_empty() { 0 } else { self.map.n_gauges() };
        1 + mixed + self.modes_of(ModeScope::EachGauge).count()
    }

    /// Columns in all.
    pub(crate) fn n_columns(&self) -> usize {
        self.n_own() + self.modes_of(ModeScope::Shared).count()
    }

    pub(crate) fn modes_of(&self, scope: ModeScope) -> impl Iterator<Item = (usize, &ModeMap<'a>)> {
        let is_of = move |(_, mode): &(usize, &ModeMap<'a>)| mode.scope == scope;
        self.modes.iter().enumerate().filter(is_of)
    }

    /// g `[n_gauges]` at `point`, and the columns `[n_gauges, n_columns]`.
    pub(crate) fn at(&self, point: &SkinPoint) -> (Vec<f64>, Vec<f64>) {
        let (m, n_columns) = (self.map.n_gauges(), self.n_columns());
        let g = self.map.normal(point);
        let mut columns = Vec::with_capacity(m * n_columns);
        let in_order = self.modes_of(ModeScope::EachGauge).chain(self.modes_of(ModeScope::Shared));
        let values: Vec<(f64, Vec<f64>)> =
            in_order.map(|(_, mode)| (mode.prior_sd, mode.map.normal(point))).collect();
        for i in 0..m {
            columns.push(self.gain_sd * g[i]);
            if !self.mix.is_empty() {
                columns.extend((0..m).map(|j| self.mix[i * m + j] * g[j]));
            }
            columns.extend(values.iter().map(|(sd, h)| sd * h[i]));
        }
        (g, columns)
    }

    /// The terms of a corrected map for scaled coefficients `theta` `[n_gauges][n_columns]`.
    pub(crate) fn terms(&self, theta: &[Vec<f64>]) -> Vec<(&'a ResponseMap, Mix)> {
        let m = self.map.n_gauges();
        let mut own = vec![0.0; m * m];
        for i in 0..m {
            own[i * m + i] = self.gain_sd * theta[i][0];
            for j in 0..if self.mix.is_empty() { 0 } else { m } {
                own[i * m + j] += self.mix[i * m + j] * theta[i][1 + j];
            }
        }
        let mut terms = vec![(self.map, Mix::All(own))];
        let in_order = self.modes_of(ModeScope::EachGauge).chain(self.modes_of(ModeScope::Shared));
        let first = self.n_columns() - self.modes.len();
        for (place, (_, mode)) in in_order.enumerate() {
            let factors = theta.iter().map(|row| mode.prior_sd * row[first + place]).collect();
            terms.push((mode.map, Mix::Each(factors)));
        }
        terms
    }

    /// The coefficients in the modes' units, in the order of the modes.
    pub(crate) fn coefficients(&self, theta: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let mut coefficients = vec![Vec::new(); self.modes.len()];
        let in_order = self.modes_of(ModeScope::EachGauge).chain(self.modes_of(ModeScope::Shared));
        let first = self.n_columns() - self.modes.len();
        for (place, (index, mode)) in in_order.enumerate() {
            let n = if mode.scope == ModeScope::Shared { 1 } else { theta.len() };
            let of_gauge = |row: &Vec<f64>| mode.prior_sd * row[first + place];
            coefficients[index] = theta[..n].iter().map(of_gauge).collect();
        }
        coefficients
    }

    /// Gains and coefficients farther than [`BEYOND_SDS`] from what was expected.
    pub(crate) fn beyond_prior(&self, theta: &[Vec<f64>]) -> Vec<BeyondPrior> {
        let in_order = self.modes_of(ModeScope::EachGauge).chain(self.modes_of(ModeScope::Shared));
        let first = self.n_columns() - self.modes.len();
        let modes = in_order.enumerate().map(|(place, (index, mode))| {
            let is_shared = mode.scope == ModeScope::Shared;
            (Some(index), first + place, is_shared)
        });
        let columns = std::iter::once((None, 0, false)).chain(modes);
        let mut beyond = Vec::new();
        for (mode, column, is_shared) in columns {
            let gauges = theta.iter().enumerate();
            for (gauge, row) in gauges.take(if is_shared { 1 } else { theta.len() }) {
                let gauge = (!is_shared).then_some(gauge);
                let sds = row[column];
                if sds.abs() > BEYOND_SDS {
                    beyond.push(BeyondPrior { mode, gauge, sds });
                }
            }
        }
        beyond
    }
}

/// Places with what the kernel and the modes need there.
pub(crate) struct Places {
    pub(crate) points: Vec<SkinPoint>,
    pub(crate) positions: Vec<Point3<f64>>,
    /// The map around them `[n, n_gauges]`.
    around: Vec<Around>,
    /// `[n, n_gauges, n_columns]`.
    pub(crate) columns: Vec<f64>,
    pub(crate) n_columns: usize,
    pub(crate) n_gauges: usize,
}

impl Places {
    pub(crate) fn new(
        basis: &Basis<'_>,
        nodal: &[f64],
        points: Vec<SkinPoint>,
        widths_m: [f64; 2],
    ) -> Self {
        let skin = basis.map.skin();
        let n_gauges = basis.map.n_gauges();
        let nodes = basis.map.value_positions();
        let positions: Vec<_> = points.iter().map(|p| skin.position(p)).collect();
        Self {
            around: around(&nodes, nodal, n_gauges, &positions, widths_m),
            columns: points.iter().flat_map(|p| basis.at(p).1).collect(),
            n_columns: basis.n_columns(),
            n_gauges,
            points,
            positions,
        }
    }

    /// The columns of `gauge` at place `i` `[n_columns]`.
    pub(crate) fn columns_of(&self, i: usize, gauge: usize) -> &[f64] {
        let at = (i * self.n_gauges + gauge) * self.n_columns;
        &self.columns[at..at + self.n_columns]
    }

    pub(crate) fn around(&self, i: usize, gauge: usize) -> Around {
        self.around[i * self.n_gauges + gauge]
    }
}

/// The presses in a shuffled order.
pub(crate) struct Samples {
    /// Index in the caller's list.
    pub(crate) index: Vec<usize>,
    pub(crate) places: Places,
    /// Measured response per newton `[n, n_gauges]`.
    pub(crate) response: Vec<f64>,
    /// That less the map's.
    pub(crate) residual: Vec<f64>,
    /// Variance of their noise `[n, n_gauges]`.
    pub(crate) noise: Vec<f64>,
}

impl Samples {
    pub(crate) fn new(
        basis: &Basis<'_>,
        nodal: &[f64],
        presses: &[Press],
        params: &CalibrationParams,
    ) -> Result<Self, InverseError> {
        let m = basis.map.n_gauges();
        check_presses(basis.map, presses)?;
        let mut index = shuffled(presses.len());
        index.truncate(params.max_presses);
        let points = index.iter().map(|&i| presses[i].point).collect();
        let places = Places::new(basis, nodal, points, params.widths_m());
        check_extent(basis.map, &places.positions)?;
        let n = index.len();
        let mut samples = Self {
            response: Vec::with_capacity(n * m),
            residual: Vec::with_capacity(n * m),
            noise: Vec::with_capacity(n * m),
            places,
            index,
        };
        for i in 0..n {
            let press = &presses[samples.index[i]];
            let g = basis.map.normal(&press.point);
            let slopes = basis.map.normal_gradient(&press.point);
            for gauge in 0..m {
                let response = press.readings[gauge] / press.force_n;
                let slope_2 = slopes.iter().map(|s| s[gauge] * s[gauge]).sum::<f64>();
                let force_part = (response * params.force_sd_n).powi(2);
                let own = (params.gauge_sd[gauge].powi(2) + force_part) / press.force_n.powi(2);
                samples.response.push(response);
                samples.residual.push(response - g[gauge]);
                samples.noise.push(own + slope_2 * params.position_sd_m.powi(2));
            }
        }
        samples.check_scales()?;
        Ok(samples)
    }

    /// Refuses a gauge whose readings have another sign or size than the map's: the s of least
    /// Σ |y − s g|, the median of y/g weighted with |g|, which a few bad presses don't move.
    fn check_scales(&self) -> Result<(), InverseError> {
        let (m, [least, most]) = (self.n_gauges(), SCALES);
        for gauge in 0..m {
            let press = |i: usize| {
                let response = self.response[i * m + gauge];
                let predicted = response - self.residual[i * m + gauge];
                (predicted != 0.0).then(|| (response / predicted, predicted.abs()))
            };
            let mut ratios: Vec<(f64, f64)> = (0..self.len()).filter_map(press).collect();
            ratios.sort_by(|a, b| a.0.total_cmp(&b.0));
            let half = 0.5 * ratios.iter().map(|(_, weight)| weight).sum::<f64>();
            let mut below = 0.0;
            let median = ratios.iter().find(|(_, weight)| {
                below += weight;
                below >= half
            });
            let ratio = median.map_or(1.0, |(ratio, _)| *ratio);
            if !(least..=most).contains(&ratio) {
                return Err(InverseError::PressScale { gauge, ratio, least, most });
            }
        }
        Ok(())
    }

    pub(crate) fn len(&self) -> usize {
        self.index.len()
    }

    pub(crate) fn n_gauges(&self) -> usize {
        self.places.n_gauges
    }
}

fn check_presses(map: &ResponseMap, presses: &[Press]) -> Result<(), InverseError> {
    let (found, needed) = (presses.len(), LEAST_PRESSES);
    if found < needed {
        return Err(InverseError::TooFewPresses { found, needed });
    }
    for (press, p) in presses.iter().enumerate() {
        check_length("the readings of a press", map.n_gauges(), p.readings.len())?;
        if !(p.force_n.is_finite() && p.force_n > 0.0) {
            let found = p.force_n;
            return Err(InverseError::PressForce { press, found });
        }
        if let Some(gauge) = p.readings.iter().position(|r| !r.is_finite()) {
            let found = p.readings[gauge];
            return Err(InverseError::PressReading { press, gauge, found });
        }
        let (face, n_faces) = (p.point.face(), map.skin().n_faces());
        if face >= n_faces {
            return Err(InverseError::FaceOutOfRange { face, n_faces });
        }
    }
    Ok(())
}

fn check_extent(map: &ResponseMap, positions: &[Point3<f64>]) -> Result<(), InverseError> {
    let (extent_m, skin_extent_m) = (diagonal_m(positions), diagonal_m(map.skin().nodes()));
    if extent_m < LEAST_EXTENT * skin_extent_m {
        return Err(InverseError::PressesInOneSpot { extent_m, skin_extent_m });
    }
    Ok(())
}

/// The diagonal of the box around `points`, m.
fn diagonal_m(points: &[Point3<f64>]) -> f64 {
    let first = points.first().copied().unwrap_or_default();
    let low = points.iter().fold(first, |a, b| a.inf(b));
    let high = points.iter().fold(first, |a, b| a.sup(b));
    (high - low).norm()
}

/// 0…n in an order that is the same every time (splitmix64, Fisher–Yates).
fn shuffled(n: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..n).collect();
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    for i in (1..n).rev() {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        order.swap(i, ((z ^ (z >> 31)) % (i as u64 + 1)) as usize);
    }
    order
}
