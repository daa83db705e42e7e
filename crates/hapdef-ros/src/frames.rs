//! Frames at contacts: z along the outward normal.

use nalgebra::Vector3;

use crate::msg::Quaternion;

/// Three unit axes at right angles, right-handed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Axes {
    pub(crate) x: Vector3<f64>,
    pub(crate) y: Vector3<f64>,
    pub(crate) z: Vector3<f64>,
}

/// A frame with z along `normal` and x as near to `along` as that allows; world axes stand in for a
/// vector that has no direction.
pub(crate) fn frame_of(normal: Vector3<f64>, along: Option<Vector3<f64>>) -> Axes {
    let z = unit(normal).unwrap_or(Vector3::z());
    let across = |v: Vector3<f64>| unit(v - z * v.dot(&z));
    let least = if z.x.abs() <= z.y.abs().max(z.z.abs()) { Vector3::x() } else { Vector3::y() };
    let x = along.and_then(across).or_else(|| across(least)).unwrap_or(Vector3::x());
    Axes { x, y: z.cross(&x), z }
}

impl Axes {
    /// The rotation whose matrix has these axes as columns (Shepperd, "Quaternion from rotation
    /// matrix", J. Guidance and Control 1(3), 1978): the largest component is formed first.
    pub(crate) fn rotation(&self) -> Quaternion {
        let (x, y, z) = (self.x, self.y, self.z);
        let squares = [
            1.0 + x[0] - y[1] - z[2],
            1.0 - x[0] + y[1] - z[2],
            1.0 - x[0] - y[1] + z[2],
            1.0 + x[0] + y[1] + z[2],
        ];
        let largest = (0..4).max_by(|&a, &b| squares[a].total_cmp(&squares[b]));
        let largest = largest.unwrap_or(3);
        let two = squares[largest].sqrt();
        let part = |sum: f64| 0.5 * sum / two;
        let [x, y, z, w] = match largest {
            0 => [0.5 * two, part(x[1] + y[0]), part(z[0] + x[2]), part(y[2] - z[1])],
            1 => [part(x[1] + y[0]), 0.5 * two, part(y[2] + z[1]), part(z[0] - x[2])],
            2 => [part(z[0] + x[2]), part(y[2] + z[1]), 0.5 * two, part(x[1] - y[0])],
            _ => [part(y[2] - z[1]), part(z[0] - x[2]), part(x[1] - y[0]), 0.5 * two],
        };
        Quaternion { x, y, z, w }
    }
}

fn unit(vector: Vector3<f64>) -> Option<Vector3<f64>> {
    vector.try_normalize(1e-12).filter(|unit| unit.iter().all(|c| c.is_finite()))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A vector turned by a quaternion: v + 2 w (q × v) + 2 q × (q × v).
    fn turned(q: Quaternion, v: Vector3<f64>) -> Vector3<f64> {
        let axis = Vector3::new(q.x, q.y, q.z);
        let once = axis.cross(&v);
        v + once * (2.0 * q.w) + axis.cross(&once) * 2.0
    }

    fn far(a: Vector3<f64>, b: Vector3<f64>) -> f64 {
        (a - b).norm()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(256))]

        #[test]
        fn the_rotation_turns_the_worlds_axes_into_the_frames(
            normal in prop::array::uniform3(-1.0..1.0f64),
            along in prop::option::of(prop::array::uniform3(-1.0..1.0f64)),
        ) {
            let normal = Vector3::from(normal);
            let axes = frame_of(normal, along.map(Vector3::from));
            let q = axes.rotation();
            let size = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
            prop_assert!((size - 1.0).abs() < 1e-12);
            for (world, axis) in [(Vector3::x(), axes.x), (Vector3::y(), axes.y), (Vector3::z(), axes.z)] {
                prop_assert!(far(turned(q, world), axis) < 1e-12, "{axes:?} {q:?}");
            }
            if let Some(unit) = unit(normal) {
                prop_assert!(far(axes.z, unit) < 1e-12);
            }
        }
    }

    #[test]
    fn half_turns_have_a_rotation_too() {
        for normal in [[0.0, 0.0, -1.0], [0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0; 3]] {
            let axes = frame_of(normal.into(), None);
            assert!(far(turned(axes.rotation(), Vector3::z()), axes.z) < 1e-12);
        }
    }
}
