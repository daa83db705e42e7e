//! Shape functions on the parent triangle, by barycentric coordinates b with (ξ, η) = (b₁, b₂).

/// The six quadratic shape functions; nodes 3, 4, 5 lie between corners 0–1, 1–2, 2–0
/// (Zienkiewicz, Taylor and Zhu, The Finite Element Method, 6th ed., section 4.7).
pub(crate) fn quadratic(b: &[f64; 3]) -> [f64; 6] {
    [
        b[0] * (2.0 * b[0] - 1.0),
        b[1] * (2.0 * b[1] - 1.0),
        b[2] * (2.0 * b[2] - 1.0),
        4.0 * b[0] * b[1],
        4.0 * b[1] * b[2],
        4.0 * b[2] * b[0],
    ]
}

/// (∂/∂ξ, ∂/∂η) of [`quadratic`], as two rows.
pub(crate) fn quadratic_gradient(b: &[f64; 3]) -> [[f64; 6]; 2] {
    let corner = 1.0 - 4.0 * b[0];
    [
        [corner, 4.0 * b[1] - 1.0, 0.0, 4.0 * (b[0] - b[1]), 4.0 * b[2], -4.0 * b[2]],
        [corner, 0.0, 4.0 * b[2] - 1.0, -4.0 * b[1], 4.0 * b[1], 4.0 * (b[0] - b[2])],
    ]
}

/// Number of control values of a cubic Bézier triangle.
pub(crate) const N_CUBIC: usize = 10;

/// The cubic Bernstein polynomials: corners 0, 1, 2; then on edge e from corner e to e + 1 the
/// control value near e (3 + 2e) and near e + 1 (4 + 2e); then the middle (Farin, Curves and
/// Surfaces for CAGD, 5th ed., section 17.1).
pub(crate) fn cubic(b: &[f64; 3]) -> [f64; N_CUBIC] {
    let [u, v, w] = *b;
    [
        u * u * u,
        v * v * v,
        w * w * w,
        3.0 * u * u * v,
        3.0 * u * v * v,
        3.0 * v * v * w,
        3.0 * v * w * w,
        3.0 * w * w * u,
        3.0 * w * u * u,
        6.0 * u * v * w,
    ]
}

/// (∂/∂ξ, ∂/∂η) of [`cubic`], as two rows: ∂/∂v − ∂/∂u and ∂/∂w − ∂/∂u.
pub(crate) fn cubic_gradient(b: &[f64; 3]) -> [[f64; N_CUBIC]; 2] {
    let [u, v, w] = *b;
    let by_u = [
        3.0 * u * u,
        0.0,
        0.0,
        6.0 * u * v,
        3.0 * v * v,
        0.0,
        0.0,
        3.0 * w * w,
        6.0 * w * u,
        6.0 * v * w,
    ];
    let by_v = [
        0.0,
        3.0 * v * v,
        0.0,
        3.0 * u * u,
        6.0 * u * v,
        6.0 * v * w,
        3.0 * w * w,
        0.0,
        0.0,
        6.0 * u * w,
    ];
    let by_w = [
        0.0,
        0.0,
        3.0 * w * w,
        0.0,
        0.0,
        3.0 * v * v,
        6.0 * v * w,
        6.0 * w * u,
        3.0 * u * u,
        6.0 * u * v,
    ];
    [std::array::from_fn(|i| by_v[i] - by_u[i]), std::array::from_fn(|i| by_w[i] - by_u[i])]
}

/// Barycentric coordinates of the six nodes of a face.
pub(crate) const NODES: [[f64; 3]; 6] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.5, 0.5, 0.0],
    [0.0, 0.5, 0.5],
    [0.5, 0.0, 0.5],
];

#[cfg(test)]
mod tests {
    use super::*;

    fn moved(b: &[f64; 3], by: [f64; 2]) -> [f64; 3] {
        [b[0] - by[0] - by[1], b[1] + by[0], b[2] + by[1]]
    }

    #[track_caller]
    fn check_gradient<const N: usize>(
        value: impl Fn(&[f64; 3]) -> [f64; N],
        gradient: impl Fn(&[f64; 3]) -> [[f64; N]; 2],
    ) {
        let (b, h) = ([0.36, 0.23, 0.41], 1e-5);
        let found = gradient(&b);
        for (axis, step) in [[h, 0.0], [0.0, h]].into_iter().enumerate() {
            let (up, down) = (value(&moved(&b, step)), value(&moved(&b, step.map(|s| -s))));
            for i in 0..N {
                let expected = (up[i] - down[i]) / (2.0 * h);
                assert!(
                    (found[axis][i] - expected).abs() < 1e-9,
                    "∂{axis} of {i}: {} and {expected}",
                    found[axis][i]
                );
            }
        }
    }

    #[test]
    fn gradients_are_central_differences() {
        check_gradient(quadratic, quadratic_gradient);
        check_gradient(cubic, cubic_gradient);
    }

    #[test]
    fn both_sum_to_one() {
        let b = [0.2, 0.7, 0.1];
        assert!((quadratic(&b).iter().sum::<f64>() - 1.0).abs() < 1e-15);
        assert!((cubic(&b).iter().sum::<f64>() - 1.0).abs() < 1e-15);
        for (i, node) in NODES.iter().enumerate() {
            for (j, n) in quadratic(node).into_iter().enumerate() {
                assert!((n - f64::from(u8::from(i == j))).abs() < 1e-15);
            }
        }
    }
}
