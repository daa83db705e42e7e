//! Grouped bars with a tick where the paper stands.

use plotters::prelude::*;
use serde::Serialize;

use super::axes::Axis;
use super::style::{self, INK, font, message, series_colour};
use crate::argument::{ArgumentError, check_len};
use crate::error::ReportError;

/// One panel of grouped bars.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BarPanel {
    /// Above the panel.
    pub title: String,
    /// `[series][group]`; `None` or a value that is not finite leaves a gap.
    pub values: Vec<Vec<Option<f64>>>,
    /// The paper's values, same shape, drawn as ticks; empty for none.
    pub paper: Vec<Vec<Option<f64>>>,
    /// Half lengths of error bars, same shape; empty for none.
    pub spread: Vec<Vec<Option<f64>>>,
}

/// Panels side by side that share groups, series and the y axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BarChart {
    /// Quantity and unit of y.
    pub y_label: String,
    /// What the groups are, under the axis.
    pub x_label: String,
    /// Logarithmic y axis; else linear from 0.
    pub log_y: bool,
    /// Group names, `[n_groups]`.
    pub groups: Vec<String>,
    /// Series names, `[n_series]`.
    pub series: Vec<String>,
    /// From left to right.
    pub panels: Vec<BarPanel>,
}

/// Draws grouped bars, 80 px for margins plus 60 px per group of each panel wide, 380 px high.
///
/// # Errors
/// A panel whose shape is not `[n_series][n_groups]`, or no bar that can be drawn.
pub fn bars_svg(chart: &BarChart) -> Result<String, ReportError> {
    for panel in &chart.panels {
        check_shape(chart, "bar chart values", &panel.values)?;
        if !panel.paper.is_empty() {
            check_shape(chart, "bar chart paper values", &panel.paper)?;
        }
        if !panel.spread.is_empty() {
            check_shape(chart, "bar chart error bars", &panel.spread)?;
        }
    }
    let cells = chart.panels.iter().flat_map(|panel| {
        let plain = panel.values.iter().chain(&panel.paper).flatten().flatten();
        plain.copied().chain(error_bars(panel).map(|bar| bar.3))
    });
    let Some((low, high)) = style::range(cells, chart.log_y) else {
        let what = "bar chart (no bar that can be drawn)";
        return Err(ReportError::TooFew { what, needed: 1, found: 0 });
    };
    let n_panels = chart.panels.len() as u32;
    let width = n_panels * (60 + 60 * chart.groups.len() as u32) + 20;
    style::svg("bar chart", (width.max(320), 380), |root| {
        let (head, body) = root.split_vertically(34);
        legend(&head, chart)?;
        for (panel, area) in chart.panels.iter().zip(body.split_evenly((1, chart.panels.len()))) {
            let base = if chart.log_y { low } else { 0.0 };
            let y = Axis::new(base..high.max(1e-12), chart.log_y);
            draw_panel(&area, chart, panel, y, base)?;
        }
        Ok(())
    })
}

fn check_shape(
    chart: &BarChart,
    what: &'static str,
    rows: &[Vec<Option<f64>>],
) -> Result<(), ArgumentError> {
    check_len(what, chart.series.len(), rows.len())?;
    rows.iter().try_for_each(|row| check_len(what, chart.groups.len(), row.len()))
}

fn legend(head: &style::Area<'_>, chart: &BarChart) -> Result<(), String> {
    let mut x = 70;
    for (index, name) in chart.series.iter().enumerate() {
        let colour = series_colour(index);
        head.draw(&Rectangle::new([(x, 12), (x + 14, 26)], colour.filled())).map_err(message)?;
        head.draw(&Text::new(name.clone(), (x + 20, 13), font(13))).map_err(message)?;
        x += 40 + 8 * name.chars().count() as i32;
    }
    if chart.panels.iter().any(|p| !p.paper.is_empty()) {
        let line = PathElement::new([(x, 19), (x + 16, 19)], INK.stroke_width(3));
        head.draw(&line).map_err(message)?;
        head.draw(&Text::new("paper", (x + 22, 13), font(13))).map_err(message)?;
    }
    Ok(())
}

fn draw_panel(
    area: &style::Area<'_>,
    chart: &BarChart,
    panel: &BarPanel,
    y: Axis,
    base: f64,
) -> Result<(), String> {
    let n_groups = chart.groups.len();
    let name = |x: &f64| {
        let group = (x - 0.5).round();
        let near = (x - 0.5 - group).abs() < 1e-6 && group >= 0.0;
        chart.groups.get(group as usize).filter(|_| near).cloned().unwrap_or_default()
    };
    let mut plot = ChartBuilder::on(area)
        .caption(&panel.title, font(14))
        .margin(6)
        .x_label_area_size(40)
        .y_label_area_size(52)
        .build_cartesian_2d(
            Axis::marked(0.0..n_groups as f64, (0..n_groups).map(|g| g as f64 + 0.5)),
            y,
        )
        .map_err(message)?;
    style::draw_axes(&mut plot, &chart.x_label, &chart.y_label, &name)?;
    let bar = 0.8 / chart.series.len() as f64;
    for (index, row) in panel.values.iter().enumerate() {
        let bars = drawable(row, chart.log_y).map(|(group, value)| {
            let left = group as f64 + 0.1 + bar * index as f64;
            let corners = [(left, base), (left + 0.92 * bar, value)];
            Rectangle::new(corners, series_colour(index).filled())
        });
        plot.draw_series(bars).map_err(message)?;
    }
    for (index, group, low, high) in error_bars(panel) {
        let middle = group as f64 + 0.1 + bar * (index as f64 + 0.46);
        let line = [(middle, low.max(base)), (middle, high)];
        plot.draw_series(std::iter::once(PathElement::new(line, INK.stroke_width(1))))
            .map_err(message)?;
    }
    for (index, row) in panel.paper.iter().enumerate() {
        let ticks = drawable(row, chart.log_y).map(|(group, value)| {
            let left = group as f64 + 0.1 + bar * index as f64;
            PathElement::new([(left, value), (left + 0.92 * bar, value)], INK.stroke_width(3))
        });
        plot.draw_series(ticks).map_err(message)?;
    }
    Ok(())
}

/// (series, group, lower end, upper end) of each error bar.
fn error_bars(panel: &BarPanel) -> impl Iterator<Item = (usize, usize, f64, f64)> + '_ {
    let rows = panel.values.iter().zip(&panel.spread).enumerate();
    rows.flat_map(|(index, (values, spreads))| {
        let cells = values.iter().zip(spreads).enumerate();
        cells.filter_map(move |(group, (value, spread))| {
            let (value, spread) = ((*value)?, (*spread)?);
            let fit = value.is_finite() && spread.is_finite();
            fit.then_some((index, group, value - spread, value + spread))
        })
    })
}

fn drawable(row: &[Option<f64>], log: bool) -> impl Iterator<Item = (usize, f64)> + '_ {
    let fit = move |v: &f64| v.is_finite() && (!log || *v > 0.0);
    row.iter().enumerate().filter_map(move |(i, v)| Some((i, (*v).filter(fit)?)))
}
