//! Line charts and scatters.

use plotters::prelude::*;
use serde::Serialize;

use super::axes::Axis;
use super::style::{self, INK, font, message, series_colour, tick};
use crate::argument::{ArgumentError, check_len};
use crate::error::ReportError;

/// A named line.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Series {
    /// For the legend.
    pub name: String,
    /// (x, y); points that are not finite, or not above 0 on a log axis, break the line.
    pub points: Vec<(f64, f64)>,
}

/// Lines against a common x axis: error against force, loss against steps, error against the
/// number of virtual gauges.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LineChart {
    /// Above the chart.
    pub title: String,
    /// Quantity and unit of x.
    pub x_label: String,
    /// Quantity and unit of y.
    pub y_label: String,
    /// Logarithmic x axis.
    pub log_x: bool,
    /// Logarithmic y axis; else linear from 0 or below.
    pub log_y: bool,
    /// Whether each point also gets a dot; the later a series, the smaller, so that none hides another.
    pub dots: bool,
    /// The lines.
    pub series: Vec<Series>,
}

/// Draws a line chart, 640 × 400 px, with its legend at the right, 200 px.
///
/// # Errors
/// No point that can be drawn.
pub fn lines_svg(chart: &LineChart) -> Result<String, ReportError> {
    let points = || chart.series.iter().flat_map(|s| s.points.iter().copied());
    let x = style::range(points().map(|p| p.0), chart.log_x);
    let y = style::range(points().map(|p| p.1), chart.log_y);
    let (Some(x), Some(mut y)) = (x, y) else {
        let found = points().count();
        let what = "line chart (no point that can be drawn)";
        return Err(ReportError::TooFew { what, needed: 1, found });
    };
    style::svg("line chart", (840, 400), |root| {
        let (main, side) = root.split_horizontally(640);
        legend(&side, chart)?;
        if !chart.log_y {
            y.0 = y.0.min(0.0);
        }
        let (x, y) = (Axis::new(x.0..x.1, chart.log_x), Axis::new(y.0..y.1, chart.log_y));
        draw_lines(&main, chart, x, y)
    })
}

/// Letters of a line of the legend: 160 px at 12 px.
const LEGEND_LETTERS: usize = 25;

fn legend(side: &style::Area<'_>, chart: &LineChart) -> Result<(), String> {
    let mut y = 44;
    for (index, series) in chart.series.iter().enumerate() {
        let line = [(4, y), (24, y)];
        let colour = series_colour(index).stroke_width(3);
        side.draw(&PathElement::new(line, colour)).map_err(message)?;
        for text in wrapped(&series.name, LEGEND_LETTERS) {
            side.draw(&Text::new(text, (32, y - 6), font(12))).map_err(message)?;
            y += 14;
        }
        y += 8;
    }
    Ok(())
}

/// Lines of at most `most` letters, broken between words; a longer word has its own line.
fn wrapped(text: &str, most: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= most => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

fn draw_lines(root: &style::Area<'_>, chart: &LineChart, x: Axis, y: Axis) -> Result<(), String> {
    let mut area = ChartBuilder::on(root)
        .caption(&chart.title, font(16))
        .margin(10)
        .x_label_area_size(42)
        .y_label_area_size(64)
        .build_cartesian_2d(x, y)
        .map_err(message)?;
    style::draw_axes(&mut area, &chart.x_label, &chart.y_label, &|v| tick(*v))?;
    for (index, series) in chart.series.iter().enumerate() {
        let colour = series_colour(index);
        let can_be = |v: f64, is_log: bool| v.is_finite() && (!is_log || v > 0.0);
        let fit = |p: &(f64, f64)| can_be(p.0, chart.log_x) && can_be(p.1, chart.log_y);
        for run in series.points.split(|p| !fit(p)).filter(|run| !run.is_empty()) {
            let line = LineSeries::new(run.iter().copied(), colour.stroke_width(2));
            area.draw_series(line).map_err(message)?;
        }
        let dots = series.points.iter().filter(|p| fit(p) && chart.dots);
        let radius_px = dot_radius_px(chart.series.len() - index);
        area.draw_series(dots.map(|p| Circle::new(*p, radius_px, colour.filled())))
            .map_err(message)?;
    }
    Ok(())
}

fn dot_radius_px(n_to_draw: usize) -> i32 {
    2 + n_to_draw.min(4) as i32
}

/// Predicted against true values.
#[derive(Clone, Debug, PartialEq)]
pub struct Scatter<'a> {
    /// Above the chart.
    pub title: &'a str,
    /// Quantity and unit; "true" and "predicted" are put before it.
    pub quantity: &'a str,
    /// True values, `[n]`.
    pub truth: &'a [f64],
    /// Predicted values, `[n]`.
    pub predicted: &'a [f64],
    /// Most points to draw; more are thinned by an even stride.
    pub max_points: usize,
}

/// Draws predicted against true values with the line of equality, 440 × 440 px.
///
/// # Errors
/// Lengths that differ, `max_points` of 0, or no finite pair.
pub fn scatter_svg(scatter: &Scatter<'_>) -> Result<String, ReportError> {
    check_len("scatter predictions", scatter.truth.len(), scatter.predicted.len())?;
    if scatter.max_points == 0 {
        let expected = "at least 1";
        return Err(ArgumentError::Parameter { what: "max_points", value: 0.0, expected }.into());
    }
    let pairs = || scatter.truth.iter().copied().zip(scatter.predicted.iter().copied());
    let fit: Vec<(f64, f64)> = pairs().filter(|p| p.0.is_finite() && p.1.is_finite()).collect();
    let Some((low, high)) = style::range(fit.iter().flat_map(|p| [p.0, p.1]), false) else {
        return Err(ReportError::TooFew {
            what: "scatter (no finite pair)",
            needed: 1,
            found: pairs().count(),
        });
    };
    let stride = fit.len().div_ceil(scatter.max_points);
    let dots: Vec<(f64, f64)> = fit.into_iter().step_by(stride).collect();
    style::svg("scatter", (440, 440), |root| draw_scatter(root, scatter, &dots, low..high))
}

fn draw_scatter(
    root: &style::Area<'_>,
    scatter: &Scatter<'_>,
    dots: &[(f64, f64)],
    range: std::ops::Range<f64>,
) -> Result<(), String> {
    let mut area = ChartBuilder::on(root)
        .caption(scatter.title, font(16))
        .margin(10)
        .x_label_area_size(42)
        .y_label_area_size(64)
        .build_cartesian_2d(Axis::new(range.clone(), false), Axis::new(range.clone(), false))
        .map_err(message)?;
    let labels = ["true", "predicted"].map(|word| format!("{word} {}", scatter.quantity));
    style::draw_axes(&mut area, &labels[0], &labels[1], &|v| tick(*v))?;
    let dot = |p: &(f64, f64)| Circle::new(*p, 2, series_colour(0).mix(0.35).filled());
    area.draw_series(dots.iter().map(dot)).map_err(message)?;
    let equal = [range.start, range.end].map(|v| (v, v));
    area.draw_series(LineSeries::new(equal, INK.stroke_width(1))).map_err(message)?;
    Ok(())
}
