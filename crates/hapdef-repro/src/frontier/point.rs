//! What was measured of a configuration, and how configurations are ranked.

use hapdef_bench::pareto_front;
use hapdef_bench::stats::mean;
use serde::{Deserialize, Serialize};

use super::configuration::{Configuration, Knows};
use super::lab::Design;
use super::times::FrameTimes;
use crate::compare::score::Errors;

/// A configuration from readings to contacts with its errors and its times.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Point {
    pub(super) name: String,
    /// None for the paper's chain.
    pub(super) configuration: Option<Configuration>,
    pub(super) family: Family,
    pub(super) single: Errors,
    pub(super) double: Errors,
    pub(super) design: Design,
    pub(super) frame: FrameTimes,
}

/// What the configuration rests on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Family {
    /// Superposition, each frame for itself.
    Searched,
    /// Superposition, contacts followed from frame to frame.
    Followed,
    /// The paper's chain, each frame for itself; the number of contacts is given.
    Chain,
}

impl Family {
    /// What is known of a frame before: only configurations that know the same solve the same problem.
    pub(super) fn knows(self) -> Knows {
        match self {
            Self::Searched | Self::Chain => Knows::Nothing,
            Self::Followed => Knows::Before,
        }
    }
}

/// Points with all times on one footing: the mean of the usual configuration's times beside each.
pub(super) fn on_one_footing(points: &[Point]) -> Vec<Point> {
    let usual_us = mean(points.iter().map(|p| p.frame.usual_us));
    let scaled = |point: &Point| Point { frame: point.frame.beside(usual_us), ..point.clone() };
    points.iter().map(scaled).collect()
}

/// What points are ranked by: GOSPA of two contacts over their number, mm, in which a missed or
/// spurious contact costs 10 mm, so that no configuration gains by leaving out what is hard to find.
pub(super) fn error_mm(point: &Point) -> f64 {
    point.double.gospa_mm
}

/// For each point whether no other that knows the same before is at least as good in time and error
/// and better in one.
pub(super) fn on_front(points: &[Point]) -> Vec<bool> {
    let front_of = |knows: Knows| {
        let error = |p: &Point| if p.family.knows() == knows { error_mm(p) } else { f64::NAN };
        pareto_front(&points.iter().map(|p| [p.frame.p50_us, error(p)]).collect::<Vec<_>>())
    };
    let fronts = front_of(Knows::Nothing).into_iter().zip(front_of(Knows::Before));
    fronts.map(|(searched, followed)| searched || followed).collect()
}

/// The point of a family of least error among those whose 99 % quantile is within `budget_us`, if
/// there is one; of equals the one that is made in less time.
pub(super) fn best_within(points: &[Point], family: Family, budget_us: f64) -> Option<&Point> {
    let of_family = points.iter().filter(|p| p.family == family);
    let within = of_family.filter(|p| p.frame.p99_us <= budget_us);
    within.min_by(|a, b| {
        let by_error = error_mm(a).total_cmp(&error_mm(b));
        by_error.then(a.design.all_s().total_cmp(&b.design.all_s()))
    })
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A searched point.
    pub(in crate::frontier) fn point(name: &str, time_us: f64, gospa_mm: f64) -> Point {
        Point {
            name: name.into(),
            configuration: None,
            family: Family::Searched,
            single: Errors::default(),
            double: Errors { gospa_mm, ..Errors::default() },
            design: Design::default(),
            frame: FrameTimes {
                n: 1000,
                p50_us: time_us,
                p50_spread: 0.1,
                p99_us: 2.0 * time_us,
                p99_spread: 0.2,
                slowest_us: 3.0 * time_us,
                usual_us: 100.0,
            },
        }
    }

    fn followed(name: &str, time_us: f64, gospa_mm: f64) -> Point {
        Point { family: Family::Followed, ..point(name, time_us, gospa_mm) }
    }

    #[test]
    fn the_front_is_what_nothing_beats_and_budgets_choose_from_it() {
        let points = [
            point("fast", 10.0, 5.0),
            point("slow and worse", 20.0, 6.0),
            point("good", 50.0, 1.0),
            point("best", 900.0, 0.5),
        ];
        assert_eq!(on_front(&points), [true, false, true, true]);
        let best = |budget_us| {
            let best = best_within(&points, Family::Searched, budget_us);
            best.map(|p| p.name.as_str())
        };
        assert_eq!(best(15.0), None);
        assert_eq!(best(100.0), Some("good"));
        assert_eq!(best(f64::INFINITY), Some("best"));
    }

    /// What is followed is faster and nearer than any search, and answers another question.
    #[test]
    fn ways_that_know_different_things_before_are_ranked_apart() {
        let points = [
            point("search", 900.0, 1.0),
            followed("follow", 1.0, 0.5),
            followed("worse", 2.0, 0.6),
        ];
        assert_eq!(on_front(&points), [true, true, false]);
        let best = |family| best_within(&points, family, f64::INFINITY).map(|p| p.name.as_str());
        assert_eq!(best(Family::Searched), Some("search"));
        assert_eq!(best(Family::Followed), Some("follow"));
        assert_eq!(best(Family::Chain), None);
        let chain = Point { family: Family::Chain, ..point("chain", 500.0, 0.9) };
        let points = [points[0].clone(), chain];
        assert_eq!(on_front(&points), [false, true]);
    }

    /// A configuration that finds one contact of two exactly is not nearer than one that finds both roughly.
    #[test]
    fn missed_contacts_count_in_the_ranking() {
        let mut exact_or_missed = point("half", 10.0, 5.0);
        exact_or_missed.double.mean_mm = 0.0;
        let mut both = point("both", 10.0, 2.0);
        both.double.mean_mm = 2.0;
        let points = [exact_or_missed, both];
        assert_eq!(on_front(&points), [false, true]);
        let best = best_within(&points, Family::Searched, 100.0);
        assert_eq!(best.map(|p| p.name.as_str()), Some("both"));
    }

    #[test]
    fn times_of_a_slower_hour_are_scaled_by_the_usual_way() {
        let mut slow = point("slow hour", 80.0, 1.0);
        slow.frame.usual_us = 200.0;
        let points = on_one_footing(&[point("a", 40.0, 1.0), slow]);
        assert_eq!(points[0].frame, points[1].frame);
    }
}
