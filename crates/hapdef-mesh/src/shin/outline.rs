//! The outer surface of the limb.

use std::f64::consts::PI;

use nalgebra::Point3;

/// The barrel's outer surface: r(θ, y) = (r₀ + b sin πs)(1 + a cos 2θ + c cos(3θ + 0.7)) with
/// s from 0 at the lower end to 1 at the upper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShinOutline {
    /// y of the lower end, m.
    pub bottom_m: f64,
    /// Height, m.
    pub height_m: f64,
    /// r₀: mean radius at the ends, m.
    pub end_radius_m: f64,
    /// b: how much wider the middle is, m.
    pub bulge_m: f64,
    /// a: two-lobed part, relative.
    pub ovality: f64,
    /// c: three-lobed part, relative.
    pub lobes: f64,
}

impl Default for ShinOutline {
    /// 122 mm high and about 72 mm across, as the HapDefX limb.
    fn default() -> Self {
        Self {
            bottom_m: 0.040,
            height_m: 0.122,
            end_radius_m: 0.0305,
            bulge_m: 0.005,
            ovality: 0.015,
            lobes: 0.01,
        }
    }
}

impl ShinOutline {
    /// The point `depth_m` inside the surface at angle `theta` (from +x towards +z) and height
    /// `y_m`, measured towards the axis; coordinates rounded to nanometres.
    pub(super) fn point(&self, theta: f64, y_m: f64, depth_m: f64) -> Point3<f64> {
        let radius_m = self.radius_m(theta, y_m) - depth_m;
        let (sin, cos) = theta.sin_cos();
        Point3::new(nanometres(radius_m * cos), nanometres(y_m), nanometres(radius_m * sin))
    }

    fn radius_m(&self, theta: f64, y_m: f64) -> f64 {
        let lobes =
            1.0 + self.ovality * (2.0 * theta).cos() + self.lobes * (3.0 * theta + 0.7).cos();
        self.mean_radius_m(y_m) * lobes
    }

    /// The radius averaged around the axis, m.
    pub(super) fn mean_radius_m(&self, y_m: f64) -> f64 {
        let s = (y_m - self.bottom_m) / self.height_m;
        self.end_radius_m + self.bulge_m * (PI * s).sin()
    }

    /// A lower bound of the radius, m.
    pub(super) fn least_radius_m(&self) -> f64 {
        let narrowest = self.end_radius_m + self.bulge_m.min(0.0);
        narrowest * (1.0 - self.ovality.abs() - self.lobes.abs())
    }
}

fn nanometres(value_m: f64) -> f64 {
    (value_m * 1e9).round() / 1e9
}
