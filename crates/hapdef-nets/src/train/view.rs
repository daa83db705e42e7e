//! A matrix on a slice.

/// A matrix whose values are another's.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    values: &'a [f32],
    pub(super) rows: usize,
    pub(super) columns: usize,
    /// Whether the values are stored column by column.
    pub(super) transposed: bool,
}

impl<'a> View<'a> {
    /// `[rows, columns]`, row-major.
    pub(super) fn new(values: &'a [f32], rows: usize, columns: usize) -> Self {
        assert_eq!(values.len(), rows * columns, "values of a matrix");
        Self { values, rows, columns, transposed: false }
    }

    /// Rows and columns exchanged.
    pub(super) fn t(self) -> Self {
        Self { rows: self.columns, columns: self.rows, transposed: !self.transposed, ..self }
    }

    /// The values: row-major, or column-major if transposed; always rows × columns of them.
    pub(super) fn values(self) -> &'a [f32] {
        self.values
    }
}
