//! Axes with labels where people look for them.

use std::ops::Range;

use plotters::coord::combinators::{IntoLogRange, LogCoord};
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::Ranged;

/// Labels that a logarithmic axis has at least, if there are so many round numbers.
const LEAST_MARKS: usize = 4;
/// Decades that are labelled at most.
const MOST_DECADES: i32 = 8;
/// Leading digits of labels, coarse to fine.
const LEADING: [&[f64]; 3] =
    [&[1.0], &[1.0, 2.0, 5.0], &[1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]];

/// A linear or logarithmic axis and where its labels are.
pub(super) struct Axis {
    scale: Scale,
    /// Where the drawing library has them if `None`.
    marks: Option<Vec<f64>>,
}

enum Scale {
    Linear(RangedCoordf64),
    Log(LogCoord<f64>),
}

impl Axis {
    /// A linear one, or a logarithmic one that is labelled at round numbers.
    pub(super) fn new(range: Range<f64>, is_log: bool) -> Self {
        if is_log {
            let marks = Some(log_marks(range.start, range.end));
            let scale = Scale::Log(range.log_scale().into());
            return Self { scale, marks };
        }
        Self { scale: Scale::Linear(range.into()), marks: None }
    }

    /// A linear one, labelled at given places.
    pub(super) fn marked(range: Range<f64>, marks: impl Iterator<Item = f64>) -> Self {
        Self { scale: Scale::Linear(range.into()), marks: Some(marks.collect()) }
    }
}

impl Ranged for Axis {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        match &self.scale {
            Scale::Linear(axis) => axis.map(value, limit),
            Scale::Log(axis) => axis.map(value, limit),
        }
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        match (&self.marks, &self.scale) {
            (Some(marks), _) => marks.clone(),
            (None, Scale::Linear(axis)) => axis.key_points(hint),
            (None, Scale::Log(axis)) => axis.key_points(hint),
        }
    }

    fn range(&self) -> Range<f64> {
        match &self.scale {
            Scale::Linear(axis) => axis.range(),
            Scale::Log(axis) => axis.range(),
        }
    }
}

/// Round numbers from `low` to `high`: powers of ten where these are enough, 1, 2 and 5 times them, or all
/// digits.
fn log_marks(low: f64, high: f64) -> Vec<f64> {
    let decades = low.log10().floor() as i32..=high.log10().floor() as i32;
    let step = ((decades.end() - decades.start()) / MOST_DECADES + 1) as usize;
    let of = |leading: &[f64]| -> Vec<f64> {
        let all = decades.clone().step_by(step);
        let all = all.flat_map(|d| leading.iter().map(move |l| l * 10_f64.powi(d)));
        all.filter(|mark| (low..=high).contains(mark)).collect()
    };
    let marks = LEADING.map(of);
    let enough = marks.iter().find(|marks| marks.len() >= LEAST_MARKS);
    enough.unwrap_or(&marks[LEADING.len() - 1]).clone()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithmic_axes_tell_round_numbers() {
        assert_eq!(log_marks(0.5, 2000.0), [1.0, 10.0, 100.0, 1000.0]);
        assert_eq!(log_marks(3.0, 60.0), [5.0, 10.0, 20.0, 50.0]);
        assert_eq!(log_marks(2.2, 5.5), [2.5, 3.0, 4.0, 5.0]);
        assert_eq!(log_marks(1.2, 2.7), [1.5, 2.0, 2.5]);
        let wide = log_marks(1e-12, 1e12);
        assert!((5..=10).contains(&wide.len()), "{wide:?}");
    }

    #[test]
    fn no_label_comes_twice() {
        for (low, high) in [(0.1, 100.0), (7.0, 13.0), (0.9, 1.1e5)] {
            let marks = log_marks(low, high);
            assert!(marks.windows(2).all(|pair| pair[0] < pair[1]), "{marks:?}");
            assert!(marks.len() >= 3 && marks.len() <= 11, "{marks:?}");
        }
    }
}
