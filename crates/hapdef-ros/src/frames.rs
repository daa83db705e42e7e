//! Frames at contacts: z along the outward normal.

use crate::msg::Quaternion;

/// Three unit axes at right angles, right-handed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Axes {
    pub(crate) x: [f64; 3],
    pub(crate) y: [f64; 3],
    pub(crate) z: [f64; 3],
}

/// A frame with z along `normal` and x as near to `along` as that allows; world axes stand in for a
/// vector that has no direction.
pub(crate) fn frame_of(normal: [f64; 3], along: Option<[f64; 3]>) -> Axes {
    let z = unit(normal).unwrap_or([0.0, 0.0, 1.0]);
    let across = |v: [f64; 3]| unit(minus(v, scaled(z, dot(v, z))));
    let least =
        if z[0].abs() <= z[1].abs().max(z[2].abs()) { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let x = along.and_then(across).or_else(|| across(least));
    let x = x.unwrap_or([1.0, 0.0, 0.0]);
    Axes { x, y: cross(z, x), z }
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

pub(crate) fn plus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(crate) fn scaled(a: [f64; 3], by: f64) -> [f64; 3] {
    a.map(|v| v * by)
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    plus(a, scaled(b, -1.0))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(a: [f64; 3]) -> Option<[f64; 3]> {
    let length = dot(a, a).sqrt();
    (length > 1e-12 && length.is_finite()).then(|| scaled(a, 1.0 / length))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A vector turned by a quaternion: v + 2 w (q × v) + 2 q × (q × v).
    fn turned(q: Quaternion, v: [f64; 3]) -> [f64; 3] {
        let axis = [q.x, q.y, q.z];
        let once = cross(axis, v);
        let twice = cross(axis, once);
        plus(v, plus(scaled(once, 2.0 * q.w), scaled(twice, 2.0)))
    }

    fn far(a: [f64; 3], b: [f64; 3]) -> f64 {
        let gap = minus(a, b);
        dot(gap, gap).sqrt()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(256))]

        #[test]
        fn the_rotation_turns_the_worlds_axes_into_the_frames(
            normal in prop::array::uniform3(-1.0..1.0f64),
            along in prop::option::of(prop::array::uniform3(-1.0..1.0f64)),
        ) {
            let axes = frame_of(normal, along);
            let q = axes.rotation();
            let size = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
            prop_assert!((size - 1.0).abs() < 1e-12);
            for (world, axis) in [([1.0, 0.0, 0.0], axes.x), ([0.0, 1.0, 0.0], axes.y), ([0.0, 0.0, 1.0], axes.z)] {
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
            let axes = frame_of(normal, None);
            assert!(far(turned(axes.rotation(), [0.0, 0.0, 1.0]), axes.z) < 1e-12);
        }
    }
}
