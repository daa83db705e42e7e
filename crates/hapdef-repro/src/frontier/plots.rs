//! The frontier and the growths as plots.

use anyhow::Result;
use hapdef_bench::{against_time, by_cost, dotted_lines};
use hapdef_report::{Figure, LineChart, Series};

use super::Measured;
use super::configuration::Knows;
use super::point::{Family, Point, error_mm, on_front};

/// Every plot of the page.
pub(super) fn figures(measured: &Measured) -> Result<Vec<Figure>> {
    let mut figures = vec![Figure::lines(
        "frontier.svg",
        "Position error with two contacts (GOSPA over their number) against the time of a frame. \
         Lines: the fronts of frames that are searched each for itself, and of contacts that are \
         followed.",
        &cloud(&measured.points),
    )?];
    for with in ["nodes", "gauges", "contacts", "frames"] {
        let series = measured
            .growths
            .iter()
            .filter(|g| g.with == with)
            .map(|g| Series { name: g.what.into(), points: g.points.clone() });
        let labels = [&format!("number of {with}"), "as named"];
        let chart = dotted_lines(format!("Growth with {with}"), labels, [true, true], series);
        figures.push(Figure::lines(
            format!("growth-{with}.svg"),
            format!("How time and memory grow with {with}."),
            &chart,
        )?);
    }
    Ok(figures)
}

/// Place of a point in the plot.
fn at(p: &Point) -> (f64, f64) {
    (p.frame.p50_us, error_mm(p))
}

/// The front of the configurations that know the same before.
fn front(points: &[Point], knows: Knows, name: &str) -> Series {
    let marked = points.iter().zip(on_front(points));
    let of_front = marked.filter(|(p, is_front)| *is_front && p.family.knows() == knows);
    by_cost(name, of_front.map(|(p, _)| at(p)))
}

fn cloud(points: &[Point]) -> LineChart {
    let dots = |family: Family, name: &str| Series {
        name: name.into(),
        // what is not finite breaks the line
        points: points
            .iter()
            .filter(|p| p.family == family)
            .flat_map(|p| [at(p), (f64::NAN, f64::NAN)])
            .collect(),
    };
    let series = vec![
        front(points, Knows::Nothing, "front, searched"),
        front(points, Knows::Before, "front, followed"),
        dots(Family::Searched, "searched"),
        dots(Family::Followed, "followed"),
        dots(Family::Chain, "the paper's chain"),
    ];
    let y_label = "GOSPA of two contacts over their number, mm";
    against_time("Position error against run time", y_label, series)
}
