//! Weights as the kernels read them.
//!
//! A *line* is 64 bytes, a cache line; a *unit* is the outputs that one line serves. The lines of
//! one input for some units lie side by side, and the inputs follow each other; then comes the next
//! panel.

/// Units of a panel: a row of one is 4 KiB, for the reason that the kernels give.
const PANEL: usize = 64;

/// 64 bytes that start where a cache line starts.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Line<T, const N: usize>(pub(super) [T; N]);

/// 16 numbers: one input's weights for 16 outputs, or 16 results.
pub(super) type F32Line = Line<f32, 16>;
/// 64 whole numbers.
pub(super) type Int8Line = Line<i8, 64>;
/// 16 sums of whole numbers.
pub(super) type I32Line = Line<i32, 16>;

/// A layer's weights in panels.
#[derive(Debug, Clone)]
pub(super) struct Panels<L> {
    lines: Vec<L>,
    /// Inputs.
    n_rows: usize,
    n_units: usize,
}

impl<L: Copy> Panels<L> {
    /// Lays out `n_rows × n_units` lines, each made by `line(row, unit)`.
    fn new([n_rows, n_units]: [usize; 2], line: impl Fn(usize, usize) -> L) -> Self {
        let mut lines = Vec::with_capacity(n_rows * n_units);
        for first in (0..n_units).step_by(PANEL) {
            let units = first..(first + PANEL).min(n_units);
            for row in 0..n_rows {
                lines.extend(units.clone().map(|unit| line(row, unit)));
            }
        }
        Self { lines, n_rows, n_units }
    }

    /// Each panel: its first unit, its number of units, its lines `[n_rows, n_units_of_panel]`.
    pub(super) fn iter(&self) -> impl Iterator<Item = (usize, usize, &[L])> {
        (0..self.n_units).step_by(PANEL).map(|first| {
            let width = PANEL.min(self.n_units - first);
            let start = first * self.n_rows;
            let lines = &self.lines[start..start + width * self.n_rows];
            (first, width, lines)
        })
    }

    /// Inputs.
    #[cfg(target_arch = "x86_64")]
    pub(super) fn n_rows(&self) -> usize {
        self.n_rows
    }

    /// Bytes of all lines.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.lines[..])
    }

    /// Bytes of the lines of one input, or of one group of inputs.
    pub(super) fn row_bytes(&self) -> usize {
        self.n_units * size_of::<L>()
    }
}

/// f32: 16 outputs a unit. `weight(output, input)`.
pub(super) fn f32_lines(
    [n_out, n_in]: [usize; 2],
    weight: impl Fn(usize, usize) -> f32,
) -> Panels<F32Line> {
    Panels::new([n_in, n_out.div_ceil(16)], |input, unit| {
        Line(std::array::from_fn(|lane| {
            let output = unit * 16 + lane;
            if output < n_out { weight(output, input) } else { 0.0 }
        }))
    })
}

/// int8: 64 outputs a unit. `weight(output, input)`.
pub(super) fn int8_lines(
    [n_out, n_in]: [usize; 2],
    weight: impl Fn(usize, usize) -> i8,
) -> Panels<Int8Line> {
    Panels::new([n_in, n_out.div_ceil(64)], |input, unit| {
        Line(std::array::from_fn(|lane| {
            let output = unit * 64 + lane;
            if output < n_out { weight(output, input) } else { 0 }
        }))
    })
}
