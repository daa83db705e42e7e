//! Every way as a row, once for its errors and once for its times.

use hapdef_report::{TextCell, TextTable};

use super::point::{Family, Point, error_mm, on_front};
use super::way::Knows;

/// Errors of the points, the least of two contacts first.
pub(super) fn errors(points: &[Point]) -> TextTable {
    let header = [
        "way",
        "mesh",
        "gauges",
        "presses",
        "one: GOSPA, mm",
        "N",
        "clean",
        "two: GOSPA, mm",
        "mean, mm",
        "median",
        "N",
        "missed",
        "spurious",
        "clean",
        "map, µm",
    ];
    TextTable {
        header: header.map(str::to_owned).to_vec(),
        rows: ranked(points).map(|(p, _)| error_cells(p)).collect(),
    }
}

/// Times of the points in the same order, and which are on a front.
pub(super) fn times(points: &[Point]) -> TextTable {
    let header = [
        "way",
        "mesh",
        "gauges",
        "presses",
        "two: GOSPA, mm",
        "p50, µs",
        "p99, µs",
        "slowest, µs",
        "n",
        "design, s",
        "front",
    ];
    let rows = ranked(points).map(|(p, is_front)| time_cells(p, is_front));
    TextTable { header: header.map(str::to_owned).to_vec(), rows: rows.collect() }
}

/// Every point and whether it is on its front.
fn ranked(points: &[Point]) -> impl Iterator<Item = (&Point, bool)> {
    let mut marked: Vec<(&Point, bool)> = points.iter().zip(on_front(points)).collect();
    marked.sort_by(|a, b| error_mm(a.0).total_cmp(&error_mm(b.0)));
    marked.into_iter()
}

fn words(p: &Point) -> [String; 4] {
    match &p.way {
        Some(way) => way.words(),
        None => [p.name.as_str(), "", "", ""].map(str::to_owned),
    }
}

fn error_cells(p: &Point) -> Vec<TextCell> {
    let (one, two) = (&p.single, &p.double);
    let count = |share: String| match p.family {
        Family::Chain => "given".to_owned(),
        Family::Searched | Family::Followed => share,
    };
    let texts = [
        format!("{:.2}", one.gospa_mm),
        format!("{:.2}", one.mean_n),
        format!("{:.0} %", one.clean_pct),
        format!("{:.2}", two.gospa_mm),
        format!("{:.2}", two.mean_mm),
        format!("{:.2}", two.median_mm),
        format!("{:.2}", two.mean_n),
        count(format!("{:.1} %", two.missed_pct)),
        count(format!("{:.1}", two.spurious_pct)),
        format!("{:.0} %", two.clean_pct),
        two.map_um.map_or("–".to_owned(), |um| format!("{um:.2}")),
    ];
    let texts = words(p).into_iter().chain(texts);
    texts.map(TextCell::plain).collect()
}

fn time_cells(p: &Point, is_front: bool) -> Vec<TextCell> {
    let frame = &p.frame;
    let spread =
        |time_us: f64, spread: f64| format!("{} ± {:.0} %", micros(time_us), 50.0 * spread);
    let front = match (is_front, p.family.knows()) {
        (false, _) => "",
        (true, Knows::Nothing) => "S",
        (true, Knows::Before) => "F",
    };
    let texts = [
        format!("{:.2}", error_mm(p)),
        spread(frame.p50_us, frame.p50_spread),
        spread(frame.p99_us, frame.p99_spread),
        micros(frame.slowest_us),
        frame.n.to_string(),
        format!("{:.1}", p.design.all_s()),
        front.to_owned(),
    ];
    let texts = words(p).into_iter().chain(texts);
    texts.map(TextCell::plain).collect()
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
