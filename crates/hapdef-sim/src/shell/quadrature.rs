//! Gauss points of the triangle.

/// Barycentric points and weights (summing to 1) of the seven-point rule, exact to degree 5
/// (Radon 1948; Zienkiewicz, Taylor and Zhu, 6th ed., table 5.3).
pub(super) fn seven_points() -> [([f64; 3], f64); 7] {
    let root = 15.0_f64.sqrt();
    let (a, b) = ((6.0 - root) / 21.0, (6.0 + root) / 21.0);
    let (wa, wb) = ((155.0 - root) / 1200.0, (155.0 + root) / 1200.0);
    let corner = |p: f64, i: usize| {
        let mut l = [p; 3];
        l[i] = 1.0 - 2.0 * p;
        l
    };
    [
        ([1.0 / 3.0; 3], 9.0 / 40.0),
        (corner(a, 0), wa),
        (corner(a, 1), wa),
        (corner(a, 2), wa),
        (corner(b, 0), wb),
        (corner(b, 1), wb),
        (corner(b, 2), wb),
    ]
}

/// Barycentric coordinates of the centroid.
pub(super) fn centroid() -> [f64; 3] {
    [1.0 / 3.0; 3]
}
