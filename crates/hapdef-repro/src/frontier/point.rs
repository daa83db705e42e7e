//! What was measured of a way.

use hapdef_report::{TextCell, TextTable};
use serde::{Deserialize, Serialize};

use super::lab::Design;
use super::way::Way;
use crate::compare::score::{Row, at, mean, sorted};

/// A way from readings to contacts with its errors and its times.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Point {
    pub(super) name: String,
    /// None for the paper's chain.
    pub(super) way: Option<Way>,
    pub(super) family: Family,
    pub(super) single: Errors,
    pub(super) double: Errors,
    pub(super) design: Design,
    pub(super) frame: FrameTimes,
}

/// What the way rests on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Family {
    /// Superposition, each frame for itself.
    Searched,
    /// Superposition, contacts followed from frame to frame.
    Followed,
    /// The paper's chain; the number of contacts is given.
    Chain,
}

/// Errors on frames of one number of contacts.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Errors {
    pub(super) n_frames: usize,
    pub(super) mean_mm: f64,
    pub(super) median_mm: f64,
    pub(super) p90_mm: f64,
    pub(super) within10_pct: f64,
    pub(super) mean_n: f64,
    pub(super) count_pct: f64,
    /// Mean error of the displacement of the whole skin, µm.
    pub(super) map_um: Option<f64>,
}

/// Times of a frame of two contacts, in rounds, each beside the usual way's.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct FrameTimes {
    /// Median of the rounds' medians, µs.
    pub(super) p50_us: f64,
    /// Of all rounds, µs.
    pub(super) p99_us: f64,
    /// Largest minus smallest round, over the median.
    pub(super) spread: f64,
    /// The usual way's median in the same rounds, µs.
    pub(super) usual_us: f64,
}

impl Errors {
    pub(super) fn of(row: &Row, map_um: Option<f64>) -> Self {
        Self {
            n_frames: row.n_frames,
            mean_mm: row.mean_mm,
            median_mm: row.median_mm,
            p90_mm: row.p90_mm,
            within10_pct: row.within10_pct,
            mean_n: row.mean_n,
            count_pct: row.count_pct,
            map_um,
        }
    }
}

impl FrameTimes {
    /// Of the rounds' times and the usual way's in the same rounds, µs.
    pub(super) fn of(rounds: &[Vec<f64>], usual: &[Vec<f64>]) -> Self {
        let median = |times: &Vec<f64>| at(&sorted(times.iter().copied()), 0.5);
        let medians = sorted(rounds.iter().map(median));
        let p50_us = at(&medians, 0.5);
        let widest =
            medians.last().copied().unwrap_or(0.0) - medians.first().copied().unwrap_or(0.0);
        Self {
            p50_us,
            p99_us: at(&sorted(rounds.iter().flatten().copied()), 0.99),
            spread: widest / p50_us,
            usual_us: at(&sorted(usual.iter().map(median)), 0.5),
        }
    }

    /// The times as they would be where the usual way takes `usual_us`.
    pub(super) fn beside(&self, usual_us: f64) -> Self {
        let scale = usual_us / self.usual_us;
        Self {
            p50_us: self.p50_us * scale,
            p99_us: self.p99_us * scale,
            spread: self.spread,
            usual_us,
        }
    }
}

/// Points with all times on one footing: the mean of the usual way's times beside each.
pub(super) fn on_one_footing(points: &[Point]) -> Vec<Point> {
    let usual_us = mean(points.iter().map(|p| p.frame.usual_us));
    let scaled = |point: &Point| Point {
        frame: point.frame.beside(usual_us),
        ..point.clone()
    };
    points.iter().map(scaled).collect()
}

/// For each point whether no other is at least as good in time and error and better in one.
pub(super) fn on_front(points: &[Point], error: impl Fn(&Point) -> f64) -> Vec<bool> {
    let beats = |a: &Point, b: &Point| {
        let (ta, tb) = (a.frame.p50_us, b.frame.p50_us);
        let (ea, eb) = (error(a), error(b));
        ta <= tb && ea <= eb && (ta < tb || ea < eb)
    };
    let is_front = |p: &Point| !points.iter().any(|other| beats(other, p));
    points.iter().map(is_front).collect()
}

/// The point of least error among those whose 99 % quantile is within `budget_us`, if there is one.
pub(super) fn best_within(
    points: &[Point],
    budget_us: f64,
    error: impl Fn(&Point) -> f64,
) -> Option<&Point> {
    let within = points.iter().filter(|p| p.frame.p99_us <= budget_us);
    within.min_by(|a, b| {
        let by_error = error(a).total_cmp(&error(b));
        by_error.then(a.design.all_s().total_cmp(&b.design.all_s()))
    })
}

/// What points are compared by: the mean position error of two contacts, mm.
pub(super) fn error_mm(point: &Point) -> f64 {
    point.double.mean_mm
}

/// The points as a table, the least error of two contacts first.
pub(super) fn table(points: &[Point]) -> TextTable {
    let header = [
        "way",
        "mesh",
        "gauges",
        "presses",
        "one: mm",
        "N",
        "count",
        "map, µm",
        "two: mm",
        "median",
        "10 mm",
        "N",
        "count",
        "map, µm",
        "p50, µs",
        "p99, µs",
        "design, s",
        "front",
    ];
    let front = on_front(points, error_mm);
    let mut marked: Vec<(&Point, bool)> = points.iter().zip(front).collect();
    marked.sort_by(|a, b| error_mm(a.0).total_cmp(&error_mm(b.0)));
    TextTable {
        header: header.map(str::to_owned).to_vec(),
        rows: marked
            .into_iter()
            .map(|(p, front)| cells(p, front))
            .collect(),
    }
}

fn cells(p: &Point, is_front: bool) -> Vec<TextCell> {
    let count = |e: &Errors| match p.family {
        Family::Chain => "given".to_owned(),
        _ => format!("{:.0} %", e.count_pct),
    };
    let map = |e: &Errors| e.map_um.map_or("–".to_owned(), |um| format!("{um:.2}"));
    let [way, mesh, gauges, presses] = match &p.way {
        Some(way) => way.words(),
        None => [p.name.as_str(), "", "", ""].map(str::to_owned),
    };
    let texts = [
        way,
        mesh,
        gauges,
        presses,
        format!("{:.2}", p.single.mean_mm),
        format!("{:.2}", p.single.mean_n),
        count(&p.single),
        map(&p.single),
        format!("{:.2}", p.double.mean_mm),
        format!("{:.2}", p.double.median_mm),
        format!("{:.0} %", p.double.within10_pct),
        format!("{:.2}", p.double.mean_n),
        count(&p.double),
        map(&p.double),
        format!(
            "{} ± {:.0} %",
            micros(p.frame.p50_us),
            50.0 * p.frame.spread
        ),
        micros(p.frame.p99_us),
        format!("{:.1}", p.design.all_s()),
        if is_front { "F" } else { "" }.to_owned(),
    ];
    texts.map(TextCell::plain).to_vec()
}

/// Small times with a decimal.
fn micros(time_us: f64) -> String {
    match time_us < 10.0 {
        true => format!("{time_us:.1}"),
        false => format!("{time_us:.0}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(name: &str, time_us: f64, error: f64) -> Point {
        Point {
            name: name.into(),
            way: None,
            family: Family::Searched,
            single: Errors::default(),
            double: Errors {
                mean_mm: error,
                ..Errors::default()
            },
            design: Design::default(),
            frame: FrameTimes {
                p50_us: time_us,
                p99_us: 2.0 * time_us,
                spread: 0.1,
                usual_us: 100.0,
            },
        }
    }

    #[test]
    fn the_front_is_what_nothing_beats_and_budgets_choose_from_it() {
        let points = [
            point("fast", 10.0, 5.0),
            point("slow and worse", 20.0, 6.0),
            point("good", 50.0, 1.0),
            point("best", 900.0, 0.5),
        ];
        assert_eq!(on_front(&points, error_mm), [true, false, true, true]);
        let best = |budget_us| best_within(&points, budget_us, error_mm).map(|p| p.name.as_str());
        assert_eq!(best(15.0), None);
        assert_eq!(best(100.0), Some("good"));
        assert_eq!(best(f64::INFINITY), Some("best"));
    }

    #[test]
    fn times_of_a_slower_hour_are_scaled_by_the_usual_way() {
        let mut slow = point("slow hour", 80.0, 1.0);
        slow.frame.usual_us = 200.0;
        let points = on_one_footing(&[point("a", 40.0, 1.0), slow]);
        assert_eq!(points[0].frame.p50_us, points[1].frame.p50_us);
    }
}
