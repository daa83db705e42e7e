//! Every configuration as a row, once for its errors and once for its times.

use hapdef_bench::{Column, or_dash, table};
use hapdef_report::TextTable;

use super::configuration::Knows;
use super::point::{Family, Point, error_mm, on_front};

/// A point and whether it is on its front.
type Ranked<'a> = (&'a Point, bool);

fn error_columns<'a>() -> [Column<Ranked<'a>>; 15] {
    [
        Column::new("configuration", |(p, _)| words(p, 0)),
        Column::new("mesh", |(p, _)| words(p, 1)),
        Column::new("gauges", |(p, _)| words(p, 2)),
        Column::new("presses", |(p, _)| words(p, 3)),
        Column::new("one: GOSPA, mm", |(p, _)| format!("{:.2}", p.single.gospa_mm)),
        Column::new("N", |(p, _)| format!("{:.2}", p.single.mean_n)),
        Column::new("clean", |(p, _)| format!("{:.0} %", p.single.clean_pct)),
        Column::new("two: GOSPA, mm", |(p, _)| format!("{:.2}", p.double.gospa_mm)),
        Column::new("mean, mm", |(p, _)| format!("{:.2}", p.double.mean_mm)),
        Column::new("median", |(p, _)| format!("{:.2}", p.double.median_mm)),
        Column::new("N", |(p, _)| format!("{:.2}", p.double.mean_n)),
        Column::new("missed", |(p, _)| counted(p, format!("{:.1} %", p.double.missed_pct))),
        Column::new("spurious", |(p, _)| counted(p, format!("{:.1}", p.double.spurious_pct))),
        Column::new("clean", |(p, _)| format!("{:.0} %", p.double.clean_pct)),
        Column::new("map, µm", |(p, _)| or_dash(p.double.map_um.map(|um| format!("{um:.2}")))),
    ]
}

fn time_columns<'a>() -> [Column<Ranked<'a>>; 11] {
    [
        Column::new("configuration", |(p, _)| words(p, 0)),
        Column::new("mesh", |(p, _)| words(p, 1)),
        Column::new("gauges", |(p, _)| words(p, 2)),
        Column::new("presses", |(p, _)| words(p, 3)),
        Column::new("two: GOSPA, mm", |(p, _)| format!("{:.2}", error_mm(p))),
        Column::new("p50, µs", |(p, _)| with_spread(p.frame.p50_us, p.frame.p50_spread)),
        Column::new("p99, µs", |(p, _)| with_spread(p.frame.p99_us, p.frame.p99_spread)),
        Column::new("slowest, µs", |(p, _)| micros(p.frame.slowest_us)),
        Column::new("n", |(p, _)| p.frame.n.to_string()),
        Column::new("design, s", |(p, _)| format!("{:.1}", p.design.all_s())),
        Column::new("front", |(p, is_front)| match (is_front, p.family.knows()) {
            (false, _) => String::new(),
            (true, Knows::Nothing) => "S".into(),
            (true, Knows::Before) => "F".into(),
        }),
    ]
}

/// Errors of the points, the least of two contacts first.
pub(super) fn errors(points: &[Point]) -> TextTable {
    table(&error_columns(), &ranked(points))
}

/// Times of the points in the same order, and which are on a front.
pub(super) fn times(points: &[Point]) -> TextTable {
    table(&time_columns(), &ranked(points))
}

fn ranked(points: &[Point]) -> Vec<Ranked<'_>> {
    let mut marked: Vec<Ranked<'_>> = points.iter().zip(on_front(points)).collect();
    marked.sort_by(|a, b| error_mm(a.0).total_cmp(&error_mm(b.0)));
    marked
}

/// Search, mesh, gauges or presses of a configuration; of the paper's chain its name alone.
fn words(p: &Point, i: usize) -> String {
    match &p.configuration {
        Some(configuration) => configuration.words()[i].clone(),
        None if i == 0 => p.name.clone(),
        None => String::new(),
    }
}

/// What depends on the number of contacts, which the paper's chain is given.
fn counted(p: &Point, share: String) -> String {
    match p.family {
        Family::Chain => "given".to_owned(),
        Family::Searched | Family::Followed => share,
    }
}

fn with_spread(time_us: f64, spread: f64) -> String {
    format!("{} ± {:.0} %", micros(time_us), 50.0 * spread)
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
    use super::super::point::tests::point;
    use super::*;

    #[test]
    fn ways_are_ranked_with_what_they_miss_and_make_up_beside() {
        let mut near = point("near", 900.0, 1.0);
        near.double.missed_pct = 2.5;
        near.double.spurious_pct = 3.0;
        near.double.clean_pct = 95.0;
        let given = Point { family: Family::Chain, ..point("chain", 50.0, 40.0) };
        let points = [given, point("beaten", 1000.0, 2.0), near];
        let text = errors(&points).to_markdown();
        let rows: Vec<&str> = text.lines().skip(2).collect();
        assert!(rows[0].starts_with("| near |"), "{text}");
        assert!(rows[0].contains("| 2.5 % | 3.0 | 95 % |"), "{text}");
        assert!(rows[2].contains("| given | given |"), "{text}");
        let text = times(&points).to_markdown();
        let rows: Vec<&str> = text.lines().skip(2).collect();
        assert!(rows[0].contains("| 900 ± 5 % | 1800 ± 10 % | 2700 | 1000 |"), "{text}");
        let marks = rows.iter().map(|row| row.ends_with("| S |"));
        assert_eq!(marks.collect::<Vec<_>>(), [true, false, true], "{text}");
    }
}
