//! One quantity along what it grows with, and the power that fits it.

use serde::Serialize;

/// One quantity along what it grows with.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Growth {
    /// What was measured, with its unit.
    pub(super) what: &'static str,
    /// What it grows with.
    pub(super) with: &'static str,
    /// Name of the exponent's metric, behind `frontier.`.
    pub(super) metric: &'static str,
    /// What theory says of the exponent.
    pub(super) theory: &'static str,
    /// Sizes, rising, and measured values.
    pub(super) points: Vec<(f64, f64)>,
    /// Smallest and largest size of the fit.
    pub(super) fitted: [f64; 2],
    /// Slope of the straight line through the logarithms of the sizes that were fitted.
    pub(super) exponent: f64,
}

impl Growth {
    /// Fits all but the smallest third of the sizes; there must be two at least.
    pub(super) fn new(
        what: &'static str,
        with: &'static str,
        metric: &'static str,
        theory: &'static str,
        points: Vec<(f64, f64)>,
    ) -> Self {
        let larger = &points[points.len() / 3..];
        let size = |point: Option<&(f64, f64)>| point.map_or(f64::NAN, |(x, _)| *x);
        Self {
            what,
            with,
            metric,
            theory,
            fitted: [size(larger.first()), size(larger.last())],
            exponent: slope(larger),
            points,
        }
    }
}

/// Least-squares slope of ln value over ln size.
fn slope(points: &[(f64, f64)]) -> f64 {
    let logs = points.iter().map(|(x, y)| (x.ln(), y.ln()));
    let n = points.len() as f64;
    let (sx, sy) = logs.clone().fold((0.0, 0.0), |s, (x, y)| (s.0 + x, s.1 + y));
    let (mx, my) = (sx / n, sy / n);
    let (sxy, sxx) =
        logs.fold((0.0, 0.0), |s, (x, y)| (s.0 + (x - mx) * (y - my), s.1 + (x - mx).powi(2)));
    sxy / sxx
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(points: &[(f64, f64)]) -> Growth {
        Growth::new("work, s", "sizes", "exponent", "1.25", points.to_vec())
    }

    #[test]
    fn the_exponent_of_a_power_is_found_from_all_but_the_smallest_third() {
        let mut points: Vec<(f64, f64)> =
            (1..7).map(|i| f64::from(1 << i)).map(|x| (x, 3.0 * x.powf(1.25))).collect();
        points[0].1 *= 40.0;
        points[1].1 *= 10.0;
        for (n, first) in [(6, 8.0), (5, 8.0), (4, 16.0)] {
            let growth = of(&points[6 - n..]);
            assert_eq!(growth.fitted, [first, 64.0], "{n} sizes");
            assert!((growth.exponent - 1.25).abs() < 1e-12, "{growth:?}");
        }
    }

    #[test]
    fn two_sizes_are_both_fitted() {
        let growth = of(&[(2.0, 4.0), (4.0, 16.0)]);
        assert_eq!(growth.fitted, [2.0, 4.0]);
        assert!((growth.exponent - 2.0).abs() < 1e-12, "{growth:?}");
    }
}
