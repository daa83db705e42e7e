//! Which candidates are taken for contacts.

use crate::error::KMaxError;
use crate::peaks::Peak;

/// A node with a score that says how likely it is a contact: its displacement, or the force
/// that the sensitivity net gives it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Index of the node.
    pub node: usize,
    /// Score; larger is more likely. Candidates with a score that is not finite are left out.
    pub score: f32,
}

impl From<Peak> for Candidate {
    /// Scores a peak by the value of the field there.
    fn from(peak: Peak) -> Self {
        Self { node: peak.node, score: peak.value }
    }
}

/// The `t` candidates of largest score, largest first, equal scores by ascending node; fewer if
/// there are fewer.
pub fn select_top(candidates: &[Candidate], t: usize) -> Vec<Candidate> {
    let mut sorted = sorted_by_score(candidates);
    sorted.truncate(t);
    sorted
}

/// Like [`select_top`], but takes candidate `t + 1` instead of candidate `t` if it exists, if its
/// score lies within the share `tolerance` of candidate `t`'s (0.10 in the paper), and if that
/// increases the spread of the selected nodes (section 4.4 of the paper).
///
/// The paper does not define "spread"; here it is the sum of the distances between all pairs of
/// selected nodes, so with `t = 1` nothing is ever exchanged. `points` are the positions of all
/// nodes in metres. Fails on a candidate whose node is not one of `points` and on a tolerance
/// that is negative or not finite.
pub fn select_top_with_spread(
    points: &[[f64; 3]],
    candidates: &[Candidate],
    t: usize,
    tolerance: f32,
) -> Result<Vec<Candidate>, KMaxError> {
    if !(tolerance >= 0.0 && tolerance.is_finite()) {
        return Err(KMaxError::Tolerance { tolerance });
    }
    if let Some(stray) = candidates.iter().find(|c| c.node >= points.len()) {
        return Err(KMaxError::NodeOutOfRange { node: stray.node, n_points: points.len() });
    }
    let mut sorted = sorted_by_score(candidates);
    if t >= 1 && sorted.len() > t {
        let (kept, last, next) = (&sorted[..t - 1], sorted[t - 1], sorted[t]);
        let is_close = last.score - next.score <= tolerance * last.score.abs();
        if is_close && reach(points, kept, next) > reach(points, kept, last) {
            sorted[t - 1] = next;
        }
    }
    sorted.truncate(t);
    Ok(sorted)
}

fn sorted_by_score(candidates: &[Candidate]) -> Vec<Candidate> {
    let mut sorted: Vec<Candidate> =
        candidates.iter().filter(|c| c.score.is_finite()).copied().collect();
    sorted.sort_by(|a, b| b.score.total_cmp(&a.score).then(a.node.cmp(&b.node)));
    sorted
}

/// What `candidate` adds to the spread of `kept`: the sum of its distances to them.
fn reach(points: &[[f64; 3]], kept: &[Candidate], candidate: Candidate) -> f64 {
    let p = points[candidate.node];
    kept.iter()
        .map(|c| {
            let q = points[c.node];
            (0..3).map(|a| (p[a] - q[a]).powi(2)).sum::<f64>().sqrt()
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: [[f64; 3]; 4] = [[0.0; 3], [0.01, 0.0, 0.0], [0.05, 0.0, 0.0], [0.09, 0.0, 0.0]];

    #[track_caller]
    fn check(scores: [f32; 4], t: usize, tolerance: f32, expected: &[usize]) {
        let candidates: Vec<_> =
            (0..4).map(|node| Candidate { node, score: scores[node] }).collect();
        let chosen = select_top_with_spread(&POINTS, &candidates, t, tolerance).unwrap();
        let nodes: Vec<_> = chosen.iter().map(|c| c.node).collect();
        assert_eq!(nodes, expected);
    }

    #[test]
    fn takes_the_next_when_close_in_score_and_farther_away() {
        check([10.0, 5.0, 4.6, 1.0], 2, 0.10, &[0, 2]);
    }

    #[test]
    fn keeps_the_second_when_the_next_is_too_weak() {
        check([10.0, 5.0, 4.4, 1.0], 2, 0.10, &[0, 1]);
    }

    #[test]
    fn keeps_the_second_when_the_next_is_nearer() {
        check([10.0, 4.8, 5.0, 1.0], 2, 0.10, &[0, 2]);
    }

    #[test]
    fn looks_no_further_than_one() {
        check([10.0, 5.0, 4.9, 4.9], 2, 0.10, &[0, 2]);
    }

    #[test]
    fn one_contact_has_no_spread() {
        check([10.0, 9.9, 9.8, 9.7], 1, 0.10, &[0]);
    }

    #[test]
    fn more_wanted_than_there_are_gives_all() {
        check([1.0, f32::NAN, 2.0, 3.0], 9, 0.10, &[3, 2, 0]);
    }

    #[test]
    fn none_wanted_gives_none() {
        check([1.0, 2.0, 3.0, 4.0], 0, 0.10, &[]);
    }

    #[test]
    fn a_stray_node_is_refused() {
        let stray = [Candidate { node: 4, score: 1.0 }];
        assert_eq!(
            select_top_with_spread(&POINTS, &stray, 1, 0.1),
            Err(KMaxError::NodeOutOfRange { node: 4, n_points: 4 })
        );
    }
}
