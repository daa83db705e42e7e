//! The χ² distribution.

/// P(χ²_n > x), the probability that noise alone gives at least `x`; 1 without degrees of freedom.
///
/// Q(n/2, x/2) by series or continued fraction (Press et al., Numerical Recipes, 3rd ed., section
/// 6.2).
#[must_use]
pub fn upper_tail(x: f64, n_dof: usize) -> f64 {
    if n_dof == 0 || x.is_nan() || x <= 0.0 {
        return 1.0;
    }
    if x.is_infinite() {
        return 0.0;
    }
    let (a, x) = (0.5 * n_dof as f64, 0.5 * x);
    let scale = (a * x.ln() - x - ln_gamma_half(n_dof)).exp();
    if x < a + 1.0 { 1.0 - scale * lower_series(a, x) } else { scale * upper_fraction(a, x) }
        .clamp(0.0, 1.0)
}

/// The χ² that noise exceeds with probability `p`, by bisection; infinite without degrees of freedom.
pub(crate) fn tail_point(p: f64, n_dof: usize) -> f64 {
    if n_dof == 0 {
        return f64::INFINITY;
    }
    let (mut low, mut high) = (0.0, 1e4);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if upper_tail(middle, n_dof) > p {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

fn lower_series(a: f64, x: f64) -> f64 {
    let mut term = 1.0 / a;
    let mut sum = term;
    for k in 1..1000 {
        term *= x / (a + f64::from(k));
        sum += term;
        if term < sum * 1e-16 {
            break;
        }
    }
    sum
}

/// Lentz's method.
fn upper_fraction(a: f64, x: f64) -> f64 {
    let tiny = 1e-300;
    let mut b = x + 1.0 - a;
    let mut c = 1.0 / tiny;
    let mut d = 1.0 / b;
    let mut h = d;
    for k in 1..1000 {
        let k = f64::from(k);
        let an = -k * (k - a);
        b += 2.0;
        d = an * d + b;
        d = 1.0 / if d.abs() < tiny { tiny } else { d };
        c = b + an / c;
        if c.abs() < tiny {
            c = tiny;
        }
        let factor = d * c;
        h *= factor;
        if (factor - 1.0).abs() < 1e-15 {
            break;
        }
    }
    h
}

/// ln Γ(n/2), by the recurrence from Γ(½) = √π and Γ(1) = 1.
fn ln_gamma_half(n: usize) -> f64 {
    let (start, mut ln) =
        if n.is_multiple_of(2) { (1.0, 0.0) } else { (0.5, 0.5 * std::f64::consts::PI.ln()) };
    let mut z = start;
    while z < 0.5 * n as f64 - 0.25 {
        ln += f64::ln(z);
        z += 1.0;
    }
    ln
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Abramowitz and Stegun, table 26.8: percentage points of the χ² distribution.
    #[test]
    fn percentage_points_of_the_table() {
        for (n_dof, x, q) in [
            (1, 3.841_46, 0.05),
            (2, 5.991_47, 0.05),
            (7, 14.067_1, 0.05),
            (10, 23.209_3, 0.01),
            (5, 0.831_211, 0.975),
            (30, 43.772_9, 0.05),
        ] {
            let found = upper_tail(x, n_dof);
            assert!((found - q).abs() < 2e-6, "χ²_{n_dof} > {x}: {found}, {q}");
        }
        assert_eq!(upper_tail(f64::INFINITY, 3), 0.0);
        assert_eq!(upper_tail(5.0, 0), 1.0);
    }

    /// Abramowitz and Stegun, table 26.8: P = 0.001 at 10.828 with one, 29.588 with ten degrees.
    #[test]
    fn the_tail_point_has_its_tail() {
        for (n_dof, expected) in [(1, 10.828), (10, 29.588)] {
            let found = tail_point(1e-3, n_dof);
            assert!((found - expected).abs() < 1e-3, "{found} for {expected}");
        }
        assert_eq!(tail_point(1e-3, 0), f64::INFINITY);
    }
}
