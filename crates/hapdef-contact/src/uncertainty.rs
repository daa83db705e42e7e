//! How sure a contact is.

use nalgebra::{Matrix3, Vector3};

/// Covariance of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uncertainty {
    /// Two unit tangents of the skin, at right angles.
    pub tangents: [Vector3<f64>; 2],
    /// Covariance of (position along tangent 1, along tangent 2, force), m and N.
    pub covariance: Matrix3<f64>,
}

impl Uncertainty {
    /// √(σ₁² + σ₂²) of the position, m.
    #[must_use]
    pub fn position_sd_m(&self) -> f64 {
        (self.covariance[(0, 0)] + self.covariance[(1, 1)]).sqrt()
    }

    /// Standard deviation of the force, N.
    #[must_use]
    pub fn force_sd_n(&self) -> f64 {
        self.covariance[(2, 2)].sqrt()
    }

    /// Covariance of the position in space, m²: T C Tᵀ with the tangents T; singular along the
    /// normal.
    #[must_use]
    pub fn position_covariance_m2(&self) -> Matrix3<f64> {
        let mut sum = Matrix3::zeros();
        for i in 0..2 {
            for j in 0..2 {
                let outer = self.tangents[i] * self.tangents[j].transpose();
                sum += outer * self.covariance[(i, j)];
            }
        }
        sum
    }

    /// Standard deviations of the position along the axes of its ellipse, m, the larger first, and the
    /// angle of that axis from tangent 1 towards tangent 2: for the covariance `[[a, b], [b, d]]` with
    /// m = (a + d)/2 and r = √(((a − d)/2)² + b²) the variances are m ± r, the angle is
    /// ½ atan2(2 b, a − d). A variance that rounding made negative counts as none.
    #[must_use]
    pub fn principal_sds_m(&self) -> ([f64; 2], f64) {
        let c = &self.covariance;
        let (a, b, d) = (c[(0, 0)], c[(0, 1)], c[(1, 1)]);
        let (mean, half) = (0.5 * (a + d), 0.5 * (a - d));
        let radius = half.hypot(b);
        let sds = [mean + radius, mean - radius].map(|variance| variance.max(0.0).sqrt());
        (sds, 0.5 * b.atan2(half))
    }

    /// The half axes of that ellipse, one standard deviation long, m: the larger first.
    #[must_use]
    pub fn semi_axes_m(&self) -> [Vector3<f64>; 2] {
        let ([large, small], angle) = self.principal_sds_m();
        let (sin, cos) = angle.sin_cos();
        let [t1, t2] = self.tangents;
        [t1 * (large * cos) + t2 * (large * sin), t1 * (-small * sin) + t2 * (small * cos)]
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;
    use proptest::prelude::*;

    use super::{Uncertainty, Vector3};

    fn along_yz(a: f64, b: f64, d: f64) -> Uncertainty {
        Uncertainty {
            tangents: [Vector3::y(), Vector3::z()],
            covariance: Matrix3::new(a, b, 0.0, b, d, 0.0, 0.0, 0.0, 0.25),
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(128))]

        /// a aᵀ + b bᵀ is the covariance again.
        #[test]
        fn axes_square_to_the_covariance(l in 0.0..1e-2_f64, m in -1e-2..1e-2_f64, n in 0.0..1e-2_f64) {
            let sure = along_yz(l * l, l * m, m * m + n * n);
            let [a, b] = sure.semi_axes_m();
            let off = a * a.transpose() + b * b.transpose() - sure.position_covariance_m2();
            prop_assert!(off.amax() < 1e-15, "{off}");
            prop_assert!(a[0] == 0.0 && b[0] == 0.0);
        }

        #[test]
        fn principal_axes_are_those_that_the_covariance_was_made_of(
            l in prop::array::uniform2(0.1..5.0f64),
            t in -3.0..3.0f64,
        ) {
            let (c, s) = (t.cos(), t.sin());
            let b = (l[0] - l[1]) * c * s;
            let made = along_yz(l[0] * c * c + l[1] * s * s, b, l[0] * s * s + l[1] * c * c);
            let (sds, angle) = made.principal_sds_m();
            let v = sds.map(|sd| sd * sd);
            let (c, s) = (angle.cos(), angle.sin());
            prop_assert!(v[0] >= v[1]);
            prop_assert!((v[0] * c * c + v[1] * s * s - made.covariance[(0, 0)]).abs() < 1e-12);
            prop_assert!((v[0] * s * s + v[1] * c * c - made.covariance[(1, 1)]).abs() < 1e-12);
            prop_assert!(((v[0] - v[1]) * c * s - b).abs() < 1e-12);
        }
    }

    #[test]
    fn larger_axis_comes_first_along_its_tangent() {
        let [a, b] = along_yz(1e-6, 0.0, 9e-6).semi_axes_m();
        assert!((a[2].abs() - 3e-3).abs() < 1e-15, "{a:?}");
        assert!((b[1].abs() - 1e-3).abs() < 1e-15, "{b:?}");
    }
}
