//! The limb's surface unrolled to a plane, coloured by a value.

use hapdef_mesh::colour::viridis;
use plotters::prelude::*;
use serde::Serialize;

use super::axes::Axis;
use super::marker::Mark;
use super::style::{self, font, message, tick};
use crate::argument::{ArgumentError, check_len};
use crate::error::ReportError;

/// Nodes without a value.
const NO_VALUE: RGBColor = RGBColor(205, 205, 205);
const GOLD: RGBColor = RGBColor(240, 180, 0);

/// A mark on the unrolled surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct UnrolledMarker {
    /// (angle, rad; height, m), as from [`unroll`].
    pub at: [f64; 2],
    /// What it marks.
    pub mark: Mark,
}

/// From a true to a found position.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct UnrolledArrow {
    /// (angle, rad; height, m) of the true position.
    pub from: [f64; 2],
    /// (angle, rad; height, m) of the found position.
    pub to: [f64; 2],
    /// Which of [`Unrolled::arrow_names`] it belongs to.
    pub series: usize,
}

/// What to draw.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Unrolled<'a> {
    /// Above the chart.
    pub title: &'a str,
    /// Quantity and unit of the values, below the colour bar; no bar if empty.
    pub value_label: &'a str,
    /// (angle, rad; height, m) of each surface node, `[n]`, as from [`unroll`].
    pub points: &'a [[f64; 2]],
    /// One value per node, `[n]`, in the unit printed; NaN is drawn grey.
    pub values: &'a [f64],
    /// Ends of the colour scale; `None` for 0 (or the least value if below) to the largest.
    pub range: Option<[f64; 2]>,
    /// Contacts and other marks; a gauge is a triangle here.
    pub markers: &'a [UnrolledMarker],
    /// Errors.
    pub arrows: &'a [UnrolledArrow],
    /// Who made the errors, for the legend; may be empty.
    pub arrow_names: &'a [&'a str],
}

/// Angle about and height along a coordinate axis (0 = x, 1 = y, 2 = z) of each position, m.
///
/// The axis runs through the mean of `reference`, normally the surface nodes; angles lie in
/// (−π, π], measured from the next coordinate axis in cyclic order towards the one after it.
///
/// # Errors
/// An axis above 2, or no reference position.
pub fn unroll(
    positions: &[[f64; 3]],
    reference: &[[f64; 3]],
    axis: usize,
) -> Result<Vec<[f64; 2]>, ReportError> {
    if axis > 2 {
        let expected = "0, 1 or 2";
        return Err(ArgumentError::Parameter { what: "axis", value: axis as f64, expected }.into());
    }
    if reference.is_empty() {
        let what = "reference positions of the unrolled surface";
        return Err(ReportError::TooFew { what, needed: 1, found: 0 });
    }
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let n = reference.len() as f64;
    let mean = |k: usize| reference.iter().map(|p| p[k]).sum::<f64>() / n;
    let (cu, cv) = (mean(u), mean(v));
    Ok(positions.iter().map(|p| [(p[v] - cv).atan2(p[u] - cu), p[axis]]).collect())
}

/// Draws the unrolled surface, 720 × 420 px: angle in degrees against height in mm.
///
/// An error arrow that crosses the seam at ±180° is drawn along the shorter way, off the edge.
///
/// # Errors
/// Lengths that differ, no node, a position that is not finite, or a colour range that is empty.
pub fn unrolled_svg(figure: &Unrolled<'_>) -> Result<String, ReportError> {
    let scale = check(figure)?;
    style::svg("unrolled surface", (720, 420), |root| draw(root, figure, scale))
}

/// The same for several surfaces side by side, 450 × 330 px each.
///
/// # Errors
/// As [`unrolled_svg`], and no surface at all.
pub fn unrolled_row_svg(figures: &[Unrolled<'_>]) -> Result<String, ReportError> {
    let scales: Vec<[f64; 2]> = figures.iter().map(check).collect::<Result<_, _>>()?;
    let size = (450 * figures.len() as u32, 330);
    style::svg("unrolled surfaces", size, |root| {
        let areas = root.split_evenly((1, figures.len()));
        for ((area, figure), scale) in areas.iter().zip(figures).zip(&scales) {
            draw(area, figure, *scale)?;
        }
        Ok(())
    })
}

/// Refuses what can't be drawn; the ends of the colour scale.
fn check(figure: &Unrolled<'_>) -> Result<[f64; 2], ReportError> {
    check_len("values on the unrolled surface", figure.points.len(), figure.values.len())?;
    check_places(figure)?;
    if figure.points.is_empty() {
        let what = "points of the unrolled surface";
        return Err(ReportError::TooFew { what, needed: 1, found: 0 });
    }
    colour_range(figure.range, figure.values)
}

fn draw(root: &style::Area<'_>, figure: &Unrolled<'_>, scale: [f64; 2]) -> Result<(), String> {
    let (width, _) = root.dim_in_pixel();
    if figure.value_label.is_empty() {
        return draw_surface(root, figure, scale);
    }
    let (main, side) = root.split_horizontally(width - 90);
    draw_surface(&main, figure, scale)?;
    draw_bar(&side, figure.value_label, scale)
}

fn check_places(figure: &Unrolled<'_>) -> Result<(), ReportError> {
    let markers: Vec<[f64; 2]> = figure.markers.iter().map(|m| m.at).collect();
    let arrows: Vec<[f64; 2]> = figure.arrows.iter().flat_map(|a| [a.from, a.to]).collect();
    for (what, places) in [
        ("points of the unrolled surface", figure.points),
        ("markers of the unrolled surface", &markers),
        ("arrow ends of the unrolled surface", &arrows),
    ] {
        for (index, place) in places.iter().enumerate() {
            if let Some(&value) = place.iter().find(|v| !v.is_finite()) {
                return Err(ReportError::NotFinite { what, index, value });
            }
        }
    }
    Ok(())
}

/// Ends of a colour scale: those given, or 0 (the least value if below) to the largest.
pub(super) fn colour_range(
    given: Option<[f64; 2]>,
    values: &[f64],
) -> Result<[f64; 2], ReportError> {
    let fit = || values.iter().copied().filter(|v| v.is_finite());
    let found = given.unwrap_or_else(|| {
        let high = fit().fold(f64::NEG_INFINITY, f64::max);
        let low = fit().fold(0.0, f64::min);
        if high > low { [low, high] } else { [low, low + 1.0] }
    });
    if !(found[0] < found[1] && found[0].is_finite() && found[1].is_finite()) {
        return Err(ArgumentError::Parameter {
            what: "upper end of the colour range",
            value: found[1],
            expected: "finite and above the lower end",
        }
        .into());
    }
    Ok(found)
}

fn draw_surface(
    area: &style::Area<'_>,
    figure: &Unrolled<'_>,
    scale: [f64; 2],
) -> Result<(), String> {
    let heights = figure.points.iter().map(|p| p[1] * 1e3);
    let height = style::range(heights, false).unwrap_or((0.0, 1.0));
    let angles = Axis::marked(-185.0..185.0, (-2..=2).map(|k| f64::from(k) * 90.0));
    let mut plot = ChartBuilder::on(area)
        .caption(figure.title, font(16))
        .margin(10)
        .x_label_area_size(42)
        .y_label_area_size(56)
        .build_cartesian_2d(angles, Axis::new(height.0..height.1, false))
        .map_err(message)?;
    style::draw_axes(&mut plot, "angle, degrees", "height, mm", &|v| tick(*v))?;
    let radius = if area.dim_in_pixel().0 > 500 { 4 } else { 3 };
    let dots = figure.points.iter().zip(figure.values).map(|(point, value)| {
        let colour = if value.is_finite() {
            let [r, g, b] = viridis((value - scale[0]) / (scale[1] - scale[0]));
            RGBColor(r, g, b)
        } else {
            NO_VALUE
        };
        Circle::new(printed(*point), radius, colour.filled())
    });
    plot.draw_series(dots).map_err(message)?;
    let arrows = figure.arrows.iter().map(|arrow| {
        let (from, mut to) = (printed(arrow.from), printed(arrow.to));
        to.0 -= 360.0 * ((to.0 - from.0) / 360.0).round();
        PathElement::new([from, to], arrow_colour(figure, arrow).stroke_width(2))
    });
    plot.draw_series(arrows).map_err(message)?;
    let heads = figure
        .arrows
        .iter()
        .map(|a| Circle::new(printed(a.to), 3, arrow_colour(figure, a).filled()));
    plot.draw_series(heads).map_err(message)?;
    let of = |mark| figure.markers.iter().filter(move |m| m.mark == mark);
    let rims = of(Mark::Dot).map(|m| Circle::new(printed(m.at), 4, WHITE.filled()));
    plot.draw_series(rims).map_err(message)?;
    let dots = of(Mark::Dot).map(|m| Circle::new(printed(m.at), 3, BLUE.filled()));
    plot.draw_series(dots).map_err(message)?;
    let gauges = of(Mark::Gauge).map(|m| TriangleMarker::new(printed(m.at), 7, GOLD.filled()));
    plot.draw_series(gauges).map_err(message)?;
    let rings = of(Mark::True).map(|m| Circle::new(printed(m.at), 9, RED.stroke_width(3)));
    plot.draw_series(rings).map_err(message)?;
    let crosses = of(Mark::Found).map(|m| Cross::new(printed(m.at), 6, BLACK.stroke_width(3)));
    plot.draw_series(crosses).map_err(message)?;
    draw_arrow_names(area, figure)
}

/// Red without names, else the series' colour.
fn arrow_colour(figure: &Unrolled<'_>, arrow: &UnrolledArrow) -> RGBColor {
    if figure.arrow_names.is_empty() { RED } else { style::series_colour(arrow.series) }
}

fn draw_arrow_names(area: &style::Area<'_>, figure: &Unrolled<'_>) -> Result<(), String> {
    let mut x = 66;
    for (index, name) in figure.arrow_names.iter().enumerate() {
        let colour = style::series_colour(index);
        area.draw(&Rectangle::new([(x, 14), (x + 16, 20)], colour.filled())).map_err(message)?;
        area.draw(&Text::new((*name).to_owned(), (x + 22, 10), font(13))).map_err(message)?;
        x += 40 + 8 * name.chars().count() as i32;
    }
    Ok(())
}

fn printed(point: [f64; 2]) -> (f64, f64) {
    (point[0].to_degrees(), point[1] * 1e3)
}

fn draw_bar(area: &style::Area<'_>, label: &str, scale: [f64; 2]) -> Result<(), String> {
    let (top, step, n) = (50, 4, 56);
    for k in 0..n {
        let [r, g, b] = viridis(1.0 - f64::from(k) / f64::from(n - 1));
        let y = top + step * k;
        let colour = RGBColor(r, g, b).filled();
        area.draw(&Rectangle::new([(0, y), (16, y + step)], colour)).map_err(message)?;
    }
    for k in 0..=4 {
        let value = scale[1] - (scale[1] - scale[0]) * f64::from(k) / 4.0;
        let y = top + step * n * k / 4 - 6;
        area.draw(&Text::new(tick(value), (22, y), font(12))).map_err(message)?;
    }
    area.draw(&Text::new(label.to_owned(), (0, top + step * n + 12), font(12))).map_err(message)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// About y the angle runs from z to x.
    #[test]
    fn angles_by_hand() {
        let ring = [[1.0, 5.0, 0.0], [-1.0, 5.0, 0.0], [0.0, 7.0, 1.0], [0.0, 7.0, -1.0]];
        let found = unroll(&ring, &ring, 1).unwrap();
        let degrees: Vec<f64> = found.iter().map(|p| p[0].to_degrees().round()).collect();
        assert_eq!(degrees, [90.0, -90.0, 0.0, 180.0]);
        assert_eq!(found[2][1], 7.0);
        assert!(unroll(&ring, &ring, 3).is_err());
        assert!(unroll(&ring, &[], 1).is_err());
    }

    #[test]
    fn colour_scale_starts_at_zero_by_default() {
        assert_eq!(colour_range(None, &[2.0, f64::NAN, 5.0]).unwrap(), [0.0, 5.0]);
        assert_eq!(colour_range(None, &[-2.0, 5.0]).unwrap(), [-2.0, 5.0]);
        assert_eq!(colour_range(None, &[]).unwrap(), [0.0, 1.0]);
        assert!(colour_range(Some([1.0, 1.0]), &[]).is_err());
    }
}
