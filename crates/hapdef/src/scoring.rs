//! How far detected contacts lie from the true ones.
//!
//! A contact is a position, m, and a normal force, N. Two rules: the paper's lenient one, where
//! each detected point is measured to the closest true contact however often that is used, and
//! the strict one, where detected and true contacts are paired one to one at least total
//! distance. [`gospa()`] puts positions and counts into one metric.

mod gospa;

pub use gospa::{Gospa, GospaParams, gospa};

/// A position, m, and a force, N.
pub type ScoredContact = ([f64; 3], f64);

/// Most contacts on either side of [`score_one_to_one`]; it tries every pairing.
pub const MAX_ONE_TO_ONE: usize = 8;

/// One detected contact measured against one true contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPair {
    /// Index in the detected list.
    pub detected: usize,
    /// Index in the true list.
    pub truth: usize,
    /// Distance between the two positions, m.
    pub position_error_m: f64,
    /// Detected minus true force, N.
    pub force_error_n: f64,
}

/// The best one-to-one pairing.
#[derive(Clone, Debug, PartialEq)]
pub struct OneToOne {
    /// As many pairs as the shorter list has contacts, by rising index of the true contact.
    pub pairs: Vec<ContactPair>,
    /// True contacts without a detected one, rising.
    pub missed: Vec<usize>,
    /// Detected contacts without a true one, rising.
    pub spurious: Vec<usize>,
}

impl OneToOne {
    /// Whether every contact has its match within `distance_m`.
    #[must_use]
    pub fn is_within(&self, distance_m: f64) -> bool {
        let is_near = |pair: &ContactPair| pair.position_error_m <= distance_m;
        self.missed.is_empty() && self.spurious.is_empty() && self.pairs.iter().all(is_near)
    }
}

/// Why contacts could not be scored.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum ScoringError {
    #[error("scoring: no true contacts; count false detections instead")]
    NoTruth,
    #[error("scoring: {list} contact {index} is not finite: {contact:?}")]
    NotFinite { list: &'static str, index: usize, contact: ScoredContact },
    #[error("scoring: {found} {list} contacts, one-to-one pairing takes at most {most}")]
    TooMany { list: &'static str, found: usize, most: usize },
    #[error(
        "GOSPA: cut-off {cutoff_m} m and p = {p}; expected a positive cut-off and p of at least 1"
    )]
    Gospa { cutoff_m: f64, p: f64 },
}

/// The paper's rule (Sun & Martius 2019, section on double contacts): with T = `truth.len()`,
/// the T detected contacts of largest force are each measured to the closest true contact.
///
/// Strongest first; ties in force go to the earlier detected contact, ties in distance to the
/// earlier true one. Fewer than T detected contacts give fewer entries, and a true contact that
/// nobody is near costs nothing: the rule is lenient.
///
/// # Errors
/// No true contact, or a value that is not finite.
pub fn score_lenient(
    detected: &[ScoredContact],
    truth: &[ScoredContact],
) -> Result<Vec<ContactPair>, ScoringError> {
    check_finite("detected", detected)?;
    check_finite("true", truth)?;
    if truth.is_empty() {
        return Err(ScoringError::NoTruth);
    }
    let mut order: Vec<usize> = (0..detected.len()).collect();
    order.sort_by(|&a, &b| detected[b].1.total_cmp(&detected[a].1).then(a.cmp(&b)));
    order.truncate(truth.len());
    let closest = |d: usize| {
        (0..truth.len())
            .map(|t| measure(detected, truth, d, t))
            .min_by(|a, b| a.position_error_m.total_cmp(&b.position_error_m))
    };
    Ok(order.into_iter().filter_map(closest).collect())
}

/// Pairs contacts one to one so that the sum of distances is least, by trying every pairing.
///
/// `min(detected, true)` pairs are formed; the rest is missed or spurious. Among equal sums the
/// pairing found first wins, with true contacts in order trying detected ones in order. Either
/// list may be empty.
///
/// # Errors
/// A value that is not finite, or more than [`MAX_ONE_TO_ONE`] contacts in a list.
pub fn score_one_to_one(
    detected: &[ScoredContact],
    truth: &[ScoredContact],
) -> Result<OneToOne, ScoringError> {
    for (list, contacts) in [("detected", detected), ("true", truth)] {
        check_finite(list, contacts)?;
        let (found, most) = (contacts.len(), MAX_ONE_TO_ONE);
        if found > most {
            return Err(ScoringError::TooMany { list, found, most });
        }
    }
    let mut search = Search {
        detected,
        truth,
        chosen: vec![],
        used: vec![false; detected.len()],
        skips_left: truth.len().saturating_sub(detected.len()),
        best_sum_m: f64::INFINITY,
        best: vec![],
    };
    search.assign(0.0);
    Ok(search.finish())
}

/// Depth-first search over the detected contact of each true one.
struct Search<'a> {
    detected: &'a [ScoredContact],
    truth: &'a [ScoredContact],
    /// Detected contact of each true one so far; `None` for missed.
    chosen: Vec<Option<usize>>,
    used: Vec<bool>,
    /// True contacts that may still go without.
    skips_left: usize,
    best_sum_m: f64,
    best: Vec<Option<usize>>,
}

impl Search<'_> {
    fn assign(&mut self, sum_m: f64) {
        if sum_m >= self.best_sum_m {
            return;
        }
        let truth = self.chosen.len();
        if truth == self.truth.len() {
            self.best_sum_m = sum_m;
            self.best.clone_from(&self.chosen);
            return;
        }
        for detected in 0..self.detected.len() {
            if !self.used[detected] {
                let step = distance(&self.detected[detected].0, &self.truth[truth].0);
                self.used[detected] = true;
                self.chosen.push(Some(detected));
                self.assign(sum_m + step);
                self.chosen.pop();
                self.used[detected] = false;
            }
        }
        if self.skips_left > 0 {
            self.skips_left -= 1;
            self.chosen.push(None);
            self.assign(sum_m);
            self.chosen.pop();
            self.skips_left += 1;
        }
    }

    fn finish(self) -> OneToOne {
        let paired =
            |(t, d): (usize, &Option<usize>)| d.map(|d| measure(self.detected, self.truth, d, t));
        let pairs: Vec<ContactPair> = self.best.iter().enumerate().filter_map(paired).collect();
        let missed = (0..self.truth.len()).filter(|&t| self.best[t].is_none()).collect();
        let spurious =
            (0..self.detected.len()).filter(|d| pairs.iter().all(|p| p.detected != *d)).collect();
        OneToOne { pairs, missed, spurious }
    }
}

fn measure(detected: &[ScoredContact], truth: &[ScoredContact], d: usize, t: usize) -> ContactPair {
    ContactPair {
        detected: d,
        truth: t,
        position_error_m: distance(&detected[d].0, &truth[t].0),
        force_error_n: detected[d].1 - truth[t].1,
    }
}

fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

fn check_finite(list: &'static str, contacts: &[ScoredContact]) -> Result<(), ScoringError> {
    let bad = |c: &ScoredContact| !(c.1.is_finite() && c.0.iter().all(|v| v.is_finite()));
    match contacts.iter().position(bad) {
        None => Ok(()),
        Some(index) => Err(ScoringError::NotFinite { list, index, contact: contacts[index] }),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn at(x: f64, force_n: f64) -> ScoredContact {
        ([x, 0.0, 0.0], force_n)
    }

    /// Both detected points lie near the first true contact: lenient hides the missed second.
    #[test]
    fn lenient_forgives_what_one_to_one_does_not() {
        let truth = [at(0.0, 30.0), at(1.0, 10.0)];
        let detected = [at(0.1, 8.0), at(0.2, 25.0), at(5.0, 1.0)];
        let lenient = score_lenient(&detected, &truth).unwrap();
        let found: Vec<_> = lenient.iter().map(|p| (p.detected, p.truth)).collect();
        assert_eq!(found, [(1, 0), (0, 0)]);
        assert!((lenient[0].position_error_m - 0.2).abs() < 1e-15);
        assert!((lenient[1].force_error_n + 22.0).abs() < 1e-15);
        let strict = score_one_to_one(&detected, &truth).unwrap();
        let found: Vec<_> = strict.pairs.iter().map(|p| (p.detected, p.truth)).collect();
        assert_eq!(
            (found, strict.missed, strict.spurious),
            (vec![(0, 0), (1, 1)], vec![], vec![2])
        );
    }

    /// Taking the nearest first (0 for 0.4) would leave 10: the sum decides.
    #[test]
    fn the_total_is_least_not_the_first_pair() {
        let truth = [at(0.0, 1.0), at(1.0, 1.0)];
        let detected = [at(0.45, 1.0), at(-9.0, 1.0)];
        let strict = score_one_to_one(&detected, &truth).unwrap();
        let found: Vec<_> = strict.pairs.iter().map(|p| p.detected).collect();
        assert_eq!(found, [1, 0]);
    }

    #[test]
    fn missed_and_empty_lists() {
        let truth = [at(0.0, 1.0), at(1.0, 1.0), at(2.0, 1.0)];
        let strict = score_one_to_one(&[at(1.9, 1.0)], &truth).unwrap();
        assert_eq!((strict.pairs[0].truth, strict.missed), (2, vec![0, 1]));
        let none = score_one_to_one(&[], &truth).unwrap();
        assert_eq!((none.pairs.len(), none.missed), (0, vec![0, 1, 2]));
        let extra = score_one_to_one(&[at(1.0, 1.0)], &[]).unwrap();
        assert_eq!(extra.spurious, [0]);
        assert!(score_lenient(&[], &truth).unwrap().is_empty());
    }

    #[test]
    fn bad_contacts_are_refused() {
        assert_eq!(score_lenient(&[at(0.0, 1.0)], &[]), Err(ScoringError::NoTruth));
        let nan = [at(0.0, 1.0), at(f64::NAN, 1.0)];
        let error = score_one_to_one(&[at(0.0, 1.0)], &nan).unwrap_err();
        assert!(matches!(error, ScoringError::NotFinite { list: "true", index: 1, .. }), "{error}");
        let error = score_one_to_one(&[at(0.0, 1.0); 9], &[at(0.0, 1.0)]).unwrap_err();
        assert_eq!(
            error.to_string(),
            "scoring: 9 detected contacts, one-to-one pairing takes at most 8"
        );
    }

    /// Sum of distances of the best pairing by listing all injections of the shorter list.
    fn least_sum(a: &[ScoredContact], b: &[ScoredContact]) -> f64 {
        let Some((first, rest)) = a.split_first() else {
            return 0.0;
        };
        (0..b.len())
            .map(|i| {
                let mut left = b.to_vec();
                let hit = left.remove(i);
                distance(&first.0, &hit.0) + least_sum(rest, &left)
            })
            .fold(f64::INFINITY, f64::min)
    }

    fn contact() -> impl Strategy<Value = ScoredContact> {
        (prop::array::uniform3(-0.1..0.1f64), 0.0..34.0f64)
    }

    fn contacts() -> impl Strategy<Value = Vec<ScoredContact>> {
        prop::collection::vec(contact(), 0..5)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]

        #[test]
        fn pairing_is_optimal_and_complete(detected in contacts(), truth in contacts()) {
            let found = score_one_to_one(&detected, &truth).unwrap();
            let n = detected.len().min(truth.len());
            prop_assert_eq!(found.pairs.len(), n);
            prop_assert_eq!(found.missed.len(), truth.len() - n);
            prop_assert_eq!(found.spurious.len(), detected.len() - n);
            let sum: f64 = found.pairs.iter().map(|p| p.position_error_m).sum();
            let (short, long) = if detected.len() <= truth.len() {
                (&detected, &truth)
            } else {
                (&truth, &detected)
            };
            let least = least_sum(short, long);
            prop_assert!((sum - least).abs() <= 1e-12, "{sum} vs {least}");
        }

        /// The order of the lists changes no error, and lenient is never above one-to-one when
        /// the counts agree.
        #[test]
        fn order_is_irrelevant_and_lenient_is_lenient(
            both in prop::collection::vec((contact(), contact()), 1..5),
        ) {
            let (detected, truth): (Vec<_>, Vec<_>) = both.into_iter().unzip();
            let strict = score_one_to_one(&detected, &truth).unwrap();
            let mut reversed = detected.clone();
            reversed.reverse();
            let again = score_one_to_one(&reversed, &truth).unwrap();
            let sum = |pairs: &[ContactPair]| pairs.iter().map(|p| p.position_error_m).sum::<f64>();
            prop_assert!((sum(&strict.pairs) - sum(&again.pairs)).abs() <= 1e-12);
            let lenient = score_lenient(&detected, &truth).unwrap();
            prop_assert!(sum(&lenient) <= sum(&strict.pairs) + 1e-12);
        }
    }
}
