//! A touch of known place and force, and what the map says of it.

use nalgebra::{DMatrix, DVector, Point3, Vector3};

use crate::error::{InverseError, check_finite, check_length, check_not_negative, check_positive};
use crate::response::ResponseMap;
use crate::skin::Skin;
use crate::skin_point::SkinPoint;

/// A touch of which place and force are known from elsewhere: a hand with a force sensor, a known tool, the robot's
/// own other limb.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownTouch {
    /// Where on the skin.
    pub point: SkinPoint,
    /// The force on the skin, N.
    pub force_n: Vector3<f64>,
    /// Standard deviation of the place along each tangent, m.
    pub position_sd_m: f64,
    /// Standard deviation of each component of the force, N.
    pub force_sd_n: f64,
    /// Readings while it is held `[n_gauges]`.
    pub readings: Vec<f64>,
    /// What they are above.
    pub zero: TouchZero,
    /// Time since the touch before, 0 where it is not known, h.
    pub hours_since: f64,
}

/// The zero of a touch's readings.
#[derive(Clone, Debug, PartialEq)]
pub enum TouchZero {
    /// Taken off already.
    Tared,
    /// The zero as it is followed: untouched frames came before other touches.
    Followed,
    /// The same, and this frame just before, in which nothing touched `[n_gauges]`, shows it.
    Untouched(Vec<f64>),
}

/// What is expected of a touch before any gain has changed.
pub(super) struct Expected {
    /// s `[n_gauges]`.
    pub(super) response: DVector<f64>,
    /// Covariance of the readings' noise and of what the errors of force and place do `[n_gauges, n_gauges]`.
    pub(super) noise: DMatrix<f64>,
    /// |F|, N.
    pub(super) force_n: f64,
    pub(super) position: Point3<f64>,
}

impl KnownTouch {
    /// A touch against the normal of `skin` with tared readings, of a place and a force that are known exactly.
    #[must_use]
    pub fn against_normal(skin: &Skin, point: SkinPoint, force_n: f64, readings: Vec<f64>) -> Self {
        Self {
            force_n: -skin.normal(&point) * force_n,
            point,
            position_sd_m: 0.0,
            force_sd_n: 0.0,
            readings,
            zero: TouchZero::Tared,
            hours_since: 0.0,
        }
    }

    pub(super) fn check(&self, map: &ResponseMap) -> Result<(), InverseError> {
        let (face, n_faces) = (self.point.face(), map.skin().n_faces());
        if face >= n_faces {
            return Err(InverseError::FaceOutOfRange { face, n_faces });
        }
        let untouched = match &self.zero {
            TouchZero::Untouched(readings) => Some(readings),
            TouchZero::Tared | TouchZero::Followed => None,
        };
        for readings in std::iter::once(&self.readings).chain(untouched) {
            check_length("the readings of a touch", map.n_gauges(), readings.len())?;
            check_finite("the readings of a touch", readings)?;
        }
        check_finite("the force of a touch", self.force_n.as_slice())?;
        check_positive("a touch's force against the skin, N", self.pressing_n(map.skin()))?;
        check_not_negative("position_sd_m of a touch", self.position_sd_m)?;
        check_not_negative("force_sd_n of a touch", self.force_sd_n)?;
        check_not_negative("hours_since of a touch", self.hours_since)
    }

    fn pressing_n(&self, skin: &Skin) -> f64 {
        -self.force_n.dot(&skin.normal(&self.point))
    }
}

impl Expected {
    /// By the map as it is: s = A g(p) + G(p) t for A against the normal and t along the skin; the place adds
    /// σ² ∇s ∇sᵀ to the noise and the force σ² G Gᵀ.
    pub(super) fn of(map: &ResponseMap, touch: &KnownTouch, gauge_sd: &[f64]) -> Self {
        let (m, point) = (gauge_sd.len(), &touch.point);
        let pressing_n = touch.pressing_n(map.skin());
        let along_n = touch.force_n + map.skin().normal(point) * pressing_n;
        let sum = |normal: Vec<f64>, vector: &[Vector3<f64>]| {
            let each = normal.iter().zip(vector);
            DVector::from_iterator(m, each.map(|(g, v)| pressing_n * g + v.dot(&along_n)))
        };
        let vector = map.vector(point);
        let variances = gauge_sd.iter().map(|sd| sd * sd);
        let mut noise = DMatrix::from_diagonal(&DVector::from_iterator(m, variances));
        let per_newton = DMatrix::from_fn(m, 3, |gauge, axis| vector[gauge][axis]);
        noise += &per_newton * per_newton.transpose() * touch.force_sd_n.powi(2);
        let slopes = map.normal_gradient(point).into_iter().zip(map.vector_gradient(point));
        for (normal, vector) in slopes {
            let slope = sum(normal, &vector);
            noise += &slope * slope.transpose() * touch.position_sd_m.powi(2);
        }
        Self {
            response: sum(map.normal(point), &vector),
            noise,
            force_n: touch.force_n.norm(),
            position: map.skin().position(point),
        }
    }
}
