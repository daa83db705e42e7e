//! The nearest point of a triangle.

use nalgebra::Point3;

/// Weights of the corners of the point of a triangle that is nearest to `x`: their sum is 1, none is below 0
/// (Ericson, Real-Time Collision Detection, 2005, section 5.1.5).
pub(super) fn closest_weights([a, b, c]: &[Point3<f64>; 3], x: &Point3<f64>) -> [f64; 3] {
    let (ab, ac) = (b - a, c - a);
    let from = |corner: &Point3<f64>| (ab.dot(&(x - corner)), ac.dot(&(x - corner)));
    let (d1, d2) = from(a);
    let (d3, d4) = from(b);
    let (d5, d6) = from(c);
    let share = |part: f64, other: f64| {
        let whole = part + other;
        if whole > 0.0 { part / whole } else { 0.0 }
    };
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let v = share(d1, -d3);
        return [1.0 - v, v, 0.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let w = share(d2, -d6);
        return [1.0 - w, 0.0, w];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let w = share(d4 - d3, d5 - d6);
        return [0.0, 1.0 - w, w];
    }
    let whole = va + vb + vc;
    [va / whole, vb / whole, vc / whole]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn point() -> impl Strategy<Value = Point3<f64>> {
        prop::array::uniform3(-1.0..1.0).prop_map(Point3::from)
    }

    fn at(corners: &[Point3<f64>; 3], w: [f64; 3]) -> Point3<f64> {
        let sum = corners.iter().zip(w).map(|(p, w)| p.coords * w);
        Point3::from(sum.sum::<nalgebra::Vector3<f64>>())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// No point of a fine grid on the triangle is nearer.
        #[test]
        fn nothing_is_nearer(corners in prop::array::uniform3(point()), x in point()) {
            let w = closest_weights(&corners, &x);
            prop_assert!(w.iter().all(|w| *w >= 0.0));
            prop_assert!((w.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let found = (at(&corners, w) - x).norm();
            for i in 0..=20 {
                for j in 0..=20 - i {
                    let (u, v) = (f64::from(i) / 20.0, f64::from(j) / 20.0);
                    let other = (at(&corners, [1.0 - u - v, u, v]) - x).norm();
                    prop_assert!(found <= other + 1e-9, "{found} but {other}");
                }
            }
        }
    }
}
