//! Line charts with dots, and the lines of a study of cost against error.

use hapdef_report::{LineChart, Series};

/// A line chart with dots under its title, with the names of its axes and which of them are logarithmic.
#[must_use]
pub fn dotted_lines(
    title: impl Into<String>,
    [x_label, y_label]: [&str; 2],
    [log_x, log_y]: [bool; 2],
    series: impl IntoIterator<Item = Series>,
) -> LineChart {
    LineChart {
        title: title.into(),
        x_label: x_label.into(),
        y_label: y_label.into(),
        log_x,
        log_y,
        dots: true,
        series: series.into_iter().collect(),
    }
}

/// Errors against times on logarithmic axes; lines without points are left out.
#[must_use]
pub fn against_time(title: &str, y_label: &str, series: Vec<Series>) -> LineChart {
    let labels = ["median time of a frame, µs", y_label];
    let lines = series.into_iter().filter(|series| !series.points.is_empty());
    dotted_lines(title, labels, [true, true], lines)
}

/// A line through places by rising cost.
#[must_use]
pub fn by_cost(name: impl Into<String>, places: impl IntoIterator<Item = (f64, f64)>) -> Series {
    let mut points: Vec<(f64, f64)> = places.into_iter().collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    Series { name: name.into(), points }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_rise_in_cost_and_empty_ones_are_left_out() {
        let lines = vec![by_cost("a", [(2.0, 1.0), (1.0, 5.0)]), by_cost("b", [])];
        let chart = against_time("t", "error, mm", lines);
        assert_eq!(chart.series.len(), 1);
        assert_eq!(chart.series[0].points, [(1.0, 5.0), (2.0, 1.0)]);
    }
}
