//! A tetrahedron rule for integrals of higher degree than stiffness.

/// Gauss–Legendre points and weights on (0, 1), five points, exact to degree 9
/// (Abramowitz and Stegun, Handbook of Mathematical Functions, table 25.4).
const GAUSS5: [(f64, f64); 5] = [
    (0.046_910_077_030_668_004, 0.118_463_442_528_094_54),
    (0.230_765_344_947_158_45, 0.239_314_335_249_683_23),
    (0.5, 0.284_444_444_444_444_44),
    (0.769_234_655_052_841_6, 0.239_314_335_249_683_23),
    (0.953_089_922_969_332, 0.118_463_442_528_094_54),
];

/// 125 points (ξ, η, ζ) and weights on the parent tetrahedron, exact to degree 7.
///
/// The cube's Gauss rule under Duffy's map (ξ, η, ζ) = (a, b(1 − a), c(1 − a)(1 − b))
/// (Duffy, SIAM J. Numer. Anal. 19, 1982), whose Jacobian (1 − a)²(1 − b) takes two of the nine
/// degrees. Nᵢ Nⱼ det J on curved elements has degree 7.
pub fn tet_rule() -> impl Iterator<Item = ([f64; 3], f64)> {
    GAUSS5.into_iter().flat_map(|(a, wa)| {
        GAUSS5.into_iter().flat_map(move |(b, wb)| {
            GAUSS5.into_iter().map(move |(c, wc)| {
                let (ra, rb) = (1.0 - a, 1.0 - b);
                ([a, b * ra, c * ra * rb], wa * wb * wc * ra * ra * rb)
            })
        })
    })
}

#[cfg(test)]
mod tests {
    use super::tet_rule;

    /// ∫ ξᵃ ηᵇ ζᶜ = a! b! c! / (a + b + c + 3)! on the unit tetrahedron.
    #[track_caller]
    fn check(a: i32, b: i32, c: i32) {
        let factorial = |n: i32| (1..=n).map(f64::from).product::<f64>();
        let exact = factorial(a) * factorial(b) * factorial(c) / factorial(a + b + c + 3);
        let sum: f64 =
            tet_rule().map(|(r, w)| w * r[0].powi(a) * r[1].powi(b) * r[2].powi(c)).sum();
        assert!((sum - exact).abs() < 1e-13 * exact, "ξ^{a} η^{b} ζ^{c}: {sum} against {exact}");
    }

    #[test]
    fn monomials_to_degree_seven_are_exact() {
        for a in 0..=7 {
            for b in 0..=7 - a {
                for c in 0..=7 - a - b {
                    check(a, b, c);
                }
            }
        }
    }
}
