//! Whether more noise than was assumed, and fewer contacts, would explain a frame as well.

use crate::estimator::explanation::Explanation;

/// What is believed of the noise: the logarithm of its true size over the one assumed has a Cauchy
/// distribution of this half width, so that factors of two are rare and of ten not impossible.
const LN_HALF_WIDTH: f64 = 0.3;

/// −2 ln evidence of `e` on `m` gauges if the noise and the map's error were s times what was assumed,
/// s² = χ²/ν the most likely with ν degrees of freedom, and 1 at least: χ² falls by s², ln det S and
/// the Occam factor follow, and s has its own prior. Infinite without a degree of freedom.
pub(crate) fn cost_with_more_noise(e: &Explanation, m: usize) -> f64 {
    let n_unknowns = 3 * e.n;
    if m <= n_unknowns {
        return f64::INFINITY;
    }
    let ln_s2 = (e.chi2 / (m - n_unknowns) as f64).max(1.0).ln();
    let misfit = e.chi2 / ln_s2.exp() + e.log_det_s + m as f64 * ln_s2;
    let occam = (e.occam - n_unknowns as f64 * ln_s2).max(0.0);
    let prior = 2.0 * (0.5 * ln_s2 / LN_HALF_WIDTH).powi(2).ln_1p();
    misfit + occam - 2.0 * e.ln_names() + prior
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where the residual is as the noise says, nothing changes; where it is ten times larger, the
    /// doubt costs far less than the residual.
    #[test]
    fn doubt_pays_only_where_the_residual_is_large() {
        let explained = |chi2: f64| Explanation { chi2, ..Explanation::new(&[]) };
        assert_eq!(cost_with_more_noise(&explained(9.0), 10), 9.0);
        let (assumed, doubted) = (1000.0, cost_with_more_noise(&explained(1000.0), 10));
        // 10 + 10 ln 100 + 2 ln (1 + (ln 10 / 0.3)²)
        assert!((doubted - 64.243).abs() < 1e-2, "{doubted} of {assumed}");
    }
}
