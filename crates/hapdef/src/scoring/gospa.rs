//! One number for position errors and wrong counts together: the GOSPA metric.

use super::{MAX_ONE_TO_ONE, ScoredContact, ScoringError, check_finite, distance};

/// Parameters of [`gospa`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GospaParams {
    /// Cut-off c, m: a pair farther apart is one missed and one false contact instead.
    pub cutoff_m: f64,
    /// Exponent p, at least 1: 1 adds distances, 2 punishes large ones more.
    pub p: f64,
}

/// The metric and what it is made of: `total_mᵖ = localisation + cᵖ/2 · (n_missed + n_false)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gospa {
    /// The metric, m.
    pub total_m: f64,
    /// Sum of the pairs' distances to the power p, mᵖ.
    pub localisation: f64,
    /// Pairs within the cut-off.
    pub n_pairs: usize,
    /// True contacts without a pair.
    pub n_missed: usize,
    /// Detected contacts without a pair.
    pub n_false: usize,
}

/// Generalized optimal sub-pattern assignment with α = 2 on positions; forces play no part.
///
/// `min over pairings γ of (Σ d(x, y)ᵖ + cᵖ/2 · (|X| + |Y| − 2|γ|))^(1/p)` (A. S. Rahmathullah,
/// Á. F. García-Fernández and L. Svensson, "Generalized optimal sub-pattern assignment metric",
/// FUSION 2017, proposition 1). Every pairing is tried. Either list may be empty.
///
/// # Errors
/// A value that is not finite, more than [`MAX_ONE_TO_ONE`] contacts in a list, a cut-off that is
/// not positive, or an exponent below 1.
pub fn gospa(
    detected: &[ScoredContact],
    truth: &[ScoredContact],
    params: &GospaParams,
) -> Result<Gospa, ScoringError> {
    let GospaParams { cutoff_m, p } = *params;
    if !(cutoff_m > 0.0 && cutoff_m.is_finite() && p >= 1.0 && p.is_finite()) {
        return Err(ScoringError::Gospa { cutoff_m, p });
    }
    for (list, contacts) in [("detected", detected), ("true", truth)] {
        check_finite(list, contacts)?;
        let (found, most) = (contacts.len(), MAX_ONE_TO_ONE);
        if found > most {
            return Err(ScoringError::TooMany { list, found, most });
        }
    }
    let alone = cutoff_m.powf(p) / 2.0;
    let cost = |t: &ScoredContact| {
        let to = |d: &ScoredContact| distance(&d.0, &t.0);
        let within = detected.iter().map(|d| Some(to(d)).filter(|d| *d < cutoff_m));
        within.map(|d| d.map(|d| d.powf(p))).collect()
    };
    let mut search = Search {
        cost: truth.iter().map(cost).collect(),
        alone,
        used: vec![false; detected.len()],
        best: (alone * (truth.len() + detected.len()) as f64, 0.0, 0),
    };
    search.assign(0, 0.0, 0);
    let (sum, localisation, n_pairs) = search.best;
    Ok(Gospa {
        total_m: sum.powf(1.0 / p),
        localisation,
        n_pairs,
        n_missed: truth.len() - n_pairs,
        n_false: detected.len() - n_pairs,
    })
}

/// Depth-first search over the detected contact of each true one, or none.
struct Search {
    /// `[true][detected]`, mᵖ; none beyond the cut-off.
    cost: Vec<Vec<Option<f64>>>,
    /// Cost of a contact without a pair, mᵖ.
    alone: f64,
    used: Vec<bool>,
    /// Least sum so far, its localisation part, its pairs.
    best: (f64, f64, usize),
}

impl Search {
    fn assign(&mut self, truth: usize, localisation: f64, n_pairs: usize) {
        if truth == self.cost.len() {
            let n_alone = self.cost.len() + self.used.len() - 2 * n_pairs;
            let sum = localisation + self.alone * n_alone as f64;
            if sum < self.best.0 {
                self.best = (sum, localisation, n_pairs);
            }
            return;
        }
        for detected in 0..self.used.len() {
            if let (false, Some(cost)) = (self.used[detected], self.cost[truth][detected]) {
                self.used[detected] = true;
                self.assign(truth + 1, localisation + cost, n_pairs + 1);
                self.used[detected] = false;
            }
        }
        self.assign(truth + 1, localisation, n_pairs);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const ONE: GospaParams = GospaParams { cutoff_m: 0.02, p: 1.0 };
    const TWO: GospaParams = GospaParams { cutoff_m: 0.02, p: 2.0 };

    fn at(x: f64) -> ScoredContact {
        ([x, 0.0, 0.0], 1.0)
    }

    /// One pair 3 mm apart, one missed, two false: 3 + 3 · 10 mm.
    #[test]
    fn parts_by_hand() {
        let detected = [at(0.003), at(0.5), at(0.9)];
        let found = gospa(&detected, &[at(0.0), at(0.2)], &ONE).unwrap();
        assert!((found.total_m - 0.033).abs() < 1e-15, "{found:?}");
        assert_eq!((found.n_pairs, found.n_missed, found.n_false), (1, 1, 2));
        let found = gospa(&detected[..1], &[at(0.0)], &TWO).unwrap();
        assert!((found.total_m - 0.003).abs() < 1e-15, "{found:?}");
    }

    #[test]
    fn nothing_at_all_is_perfect_and_too_far_is_no_pair() {
        assert_eq!(gospa(&[], &[], &TWO).unwrap().total_m, 0.0);
        let far = gospa(&[at(0.0)], &[at(0.021)], &ONE).unwrap();
        assert_eq!((far.n_pairs, far.total_m), (0, 0.02));
    }

    #[test]
    fn knobs_out_of_range_are_refused() {
        for (cutoff_m, p) in [(0.0, 1.0), (f64::NAN, 1.0), (0.02, 0.5), (0.02, f64::INFINITY)] {
            let error = gospa(&[], &[], &GospaParams { cutoff_m, p }).unwrap_err();
            assert!(matches!(error, ScoringError::Gospa { .. }), "{error}");
        }
        let error = gospa(&[at(0.0); 9], &[], &ONE).unwrap_err();
        assert!(matches!(error, ScoringError::TooMany { .. }), "{error}");
    }

    /// Within a few cut-offs of each other, so that pairs, misses and false contacts all occur.
    fn contacts() -> impl Strategy<Value = Vec<ScoredContact>> {
        let place = prop::array::uniform3(-0.015..0.015f64);
        prop::collection::vec(place.prop_map(|p| (p, 1.0)), 0..4)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(150))]

        #[test]
        fn it_is_a_metric(x in contacts(), y in contacts(), z in contacts()) {
            for params in [ONE, TWO] {
                let d = |a: &[ScoredContact], b: &[ScoredContact]| gospa(a, b, &params).unwrap();
                prop_assert_eq!(d(&x, &x).total_m, 0.0);
                let (forth, back) = (d(&x, &y), d(&y, &x));
                prop_assert!((forth.total_m - back.total_m).abs() <= 1e-12);
                prop_assert_eq!((forth.n_missed, forth.n_false), (back.n_false, back.n_missed));
                prop_assert!(x == y || forth.total_m > 0.0);
                let detour = d(&x, &z).total_m + d(&z, &y).total_m;
                prop_assert!(forth.total_m <= detour + 1e-12, "{} > {detour}", forth.total_m);
            }
        }

        #[test]
        fn the_parts_make_the_total(x in contacts(), y in contacts()) {
            for params in [ONE, TWO] {
                let found = gospa(&x, &y, &params).unwrap();
                let alone = (found.n_missed + found.n_false) as f64;
                let sum = found.localisation + params.cutoff_m.powf(params.p) / 2.0 * alone;
                prop_assert!((found.total_m.powf(params.p) - sum).abs() <= 1e-15);
                prop_assert_eq!(found.n_pairs + found.n_missed, y.len());
                prop_assert_eq!(found.n_pairs + found.n_false, x.len());
            }
        }

        /// With p = 1 and a cut-off that nothing reaches, it is the one-to-one sum plus c/2 for
        /// each contact left over.
        #[test]
        fn a_large_cutoff_pairs_one_to_one(x in contacts(), y in contacts()) {
            let params = GospaParams { cutoff_m: 10.0, p: 1.0 };
            let pairs = super::super::score_one_to_one(&x, &y).unwrap().pairs;
            let sum: f64 = pairs.iter().map(|p| p.position_error_m).sum();
            let left_over = 5.0 * x.len().abs_diff(y.len()) as f64;
            let found = gospa(&x, &y, &params).unwrap();
            prop_assert!((found.total_m - sum - left_over).abs() <= 1e-12);
        }
    }
}
