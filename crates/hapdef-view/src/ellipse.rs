//! From a covariance in the skin's tangent plane to the half axes of an ellipse.

/// The half axes, one standard deviation long, `[3]` each, m: the larger first.
///
/// `tangents` are two unit vectors at right angles, `covariance_m2` `[[xx, xy], [yx, yy]]` along
/// them, m². With `m = (xx + yy)/2` and `r = √(((xx − yy)/2)² + xy²)` the variances are `m ± r`, and
/// the larger lies at the angle `½ atan2(2 xy, xx − yy)` from the first tangent.
/// A variance that rounding made negative counts as none.
#[must_use]
pub fn semi_axes(tangents: [[f64; 3]; 2], covariance_m2: [[f64; 2]; 2]) -> [[f64; 3]; 2] {
    let [[xx, xy], [_, yy]] = covariance_m2;
    let mean = 0.5 * (xx + yy);
    let radius = (0.5 * (xx - yy)).hypot(xy);
    let (sin, cos) = (0.5 * (2.0 * xy).atan2(xx - yy)).sin_cos();
    let sd = |variance: f64| variance.max(0.0).sqrt();
    let (large, small) = (sd(mean + radius), sd(mean - radius));
    let along = |a: f64, b: f64| std::array::from_fn(|k| a * tangents[0][k] + b * tangents[1][k]);
    [along(large * cos, large * sin), along(-small * sin, small * cos)]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::semi_axes;

    proptest! {
        /// a aᵀ + b bᵀ is the covariance again.
        #[test]
        fn axes_square_to_the_covariance(l in 0.0..1e-2_f64, m in -1e-2..1e-2_f64, n in 0.0..1e-2_f64) {
            let covariance = [[l * l, l * m], [l * m, m * m + n * n]];
            let [a, b] = semi_axes([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], covariance);
            for i in 0..2 {
                for j in 0..2 {
                    let back = a[i + 1] * a[j + 1] + b[i + 1] * b[j + 1];
                    prop_assert!((back - covariance[i][j]).abs() < 1e-15, "{back} {}", covariance[i][j]);
                }
            }
            prop_assert!(a[0] == 0.0 && b[0] == 0.0);
        }
    }

    #[test]
    fn larger_axis_comes_first_along_its_tangent() {
        let [a, b] = semi_axes([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], [[1e-6, 0.0], [0.0, 9e-6]]);
        assert!((a[2].abs() - 3e-3).abs() < 1e-15, "{a:?}");
        assert!((b[0].abs() - 1e-3).abs() < 1e-15, "{b:?}");
    }
}
