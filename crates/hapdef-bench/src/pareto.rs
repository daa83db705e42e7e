//! What is worth choosing where two costs count, such as time and error.

/// For each point whether it is on the Pareto front: no other is at most as costly in both and less in
/// one. Of equal points all are on it; a point with a cost that is NaN is not, and beats none.
#[must_use]
pub fn pareto_front(costs: &[[f64; 2]]) -> Vec<bool> {
    let beats = |a: &[f64; 2], b: &[f64; 2]| a[0] <= b[0] && a[1] <= b[1] && a != b;
    let is_on_front =
        |b: &[f64; 2]| !b[0].is_nan() && !b[1].is_nan() && !costs.iter().any(|a| beats(a, b));
    costs.iter().map(is_on_front).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_is_what_no_other_beats() {
        let costs =
            [[10.0, 5.0], [20.0, 4.0], [15.0, 5.0], [f64::NAN, 1.0], [30.0, 4.5], [10.0, 5.0]];
        assert_eq!(pareto_front(&costs), [true, true, false, false, false, true]);
    }

    #[test]
    fn of_equal_times_the_smaller_error_beats() {
        assert_eq!(pareto_front(&[[10.0, 2.0], [10.0, 1.0]]), [false, true]);
    }
}
