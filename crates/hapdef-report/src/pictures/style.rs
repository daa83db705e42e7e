//! Colours, fonts and helpers that all charts share.

use plotters::prelude::*;

use super::axes::Axis;
use crate::ReportError;

/// A chart's drawing area.
pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

/// Text and axes.
pub(super) const INK: RGBColor = RGBColor(34, 34, 34);
/// Grid lines.
const FAINT: RGBColor = RGBColor(225, 225, 225);

/// Distinguishable for the colour-blind: Okabe & Ito, Color Universal Design, 2008.
const SERIES: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(230, 159, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(213, 94, 0),
    RGBColor(86, 180, 233),
    RGBColor(90, 90, 90),
];

/// The colour of series `index`; they repeat after seven.
pub(super) fn series_colour(index: usize) -> RGBColor {
    SERIES[index % SERIES.len()]
}

/// A font of `size` px in ink.
pub(super) fn font(size: i32) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&INK)
}

/// Draws on a white canvas of `size` px and returns the SVG.
pub(super) fn svg(
    figure: &'static str,
    size: (u32, u32),
    draw: impl FnOnce(&Area<'_>) -> Result<(), String>,
) -> Result<String, ReportError> {
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
        let drawn = root
            .fill(&WHITE)
            .map_err(message)
            .and_then(|()| draw(&root))
            .and_then(|()| root.present().map_err(message));
        drawn.map_err(|message| ReportError::Draw { figure, message })?;
    }
    Ok(shorter(&text))
}

/// Without attributes that say what SVG assumes anyway: pictures of thousands of dots shrink by a
/// third.
fn shorter(svg: &str) -> String {
    svg.replace(" opacity=\"1\"", "").replace(" stroke=\"none\" stroke-width=\"1\"", "")
}

/// Draws axes, labels and grid; `x_tick` labels the places along x.
pub(super) fn draw_axes(
    plot: &mut ChartContext<'_, SVGBackend<'_>, Cartesian2d<Axis, Axis>>,
    x_label: &str,
    y_label: &str,
    x_tick: &dyn Fn(&f64) -> String,
) -> Result<(), String> {
    plot.configure_mesh()
        .x_desc(x_label)
        .y_desc(y_label)
        .label_style(font(12))
        .axis_desc_style(font(13))
        .axis_style(INK)
        .bold_line_style(FAINT)
        .light_line_style(TRANSPARENT)
        .x_label_formatter(&x_tick)
        .y_label_formatter(&|y| tick(*y))
        .draw()
        .map_err(message)
}

/// An error of the drawing library in words.
pub(super) fn message(error: impl std::fmt::Display) -> String {
    error.to_string()
}

/// Lowest and highest finite value (above 0 on a log axis), with room around; `None` if none.
pub(super) fn range(values: impl Iterator<Item = f64>, log: bool) -> Option<(f64, f64)> {
    let fit = values.filter(|v| v.is_finite() && (!log || *v > 0.0));
    let (low, high) =
        fit.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if low > high {
        return None;
    }
    if log {
        return Some((low / 1.5, high * 1.5));
    }
    let room = if high > low { 0.04 * (high - low) } else { 0.5 * high.abs().max(1e-12) };
    Some((low - room, high + room))
}

/// A short number for an axis: three significant digits, without trailing zeros.
pub(super) fn tick(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        "0".to_owned()
    } else if !(1e-3..1e6).contains(&size) {
        format!("{value:.0e}")
    } else if size >= 100.0 {
        format!("{value:.0}")
    } else {
        let decimals = (2.0 - size.log10().floor()) as usize;
        let text = format!("{value:.decimals$}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_short() {
        let found = [0.0, 0.001, 0.5, 79.863, 150.0, 2e6, 1e-6, -0.25].map(tick);
        assert_eq!(found, ["0", "0.001", "0.5", "79.9", "150", "2e6", "1e-6", "-0.25"]);
    }

    #[test]
    fn ranges_skip_what_cannot_be_drawn() {
        assert_eq!(range([f64::NAN, -1.0].into_iter(), true), None);
        assert_eq!(range([f64::NAN, 2.0, 8.0, -1.0].into_iter(), true), Some((2.0 / 1.5, 12.0)));
        let (low, high) = range([3.0].into_iter(), false).unwrap();
        assert!(low < 3.0 && 3.0 < high);
    }
}
