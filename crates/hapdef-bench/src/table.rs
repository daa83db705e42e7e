//! Tables from columns, and tables on a terminal.

use std::path::Path;

use hapdef_report::{ReportError, ReportTable, TextTable, text_table};
use serde::Serialize;

/// A column: its header, and what stands in it of a row.
pub struct Column<R> {
    /// Its name.
    pub header: &'static str,
    /// The cell of a row.
    pub cell: fn(&R) -> String,
}

impl<R> Column<R> {
    /// A column of any text.
    pub const fn new(header: &'static str, cell: fn(&R) -> String) -> Self {
        Self { header, cell }
    }
}

/// One row of cells for each of `rows`.
#[must_use]
pub fn table<'a, R: 'a>(columns: &[Column<R>], rows: impl IntoIterator<Item = &'a R>) -> TextTable {
    let cells = |row| columns.iter().map(move |c| (c.cell)(row));
    text_table(columns.iter().map(|c| c.header), rows.into_iter().map(cells))
}

/// A table of a page: its heading, what is to be known of it, for people and for machines.
///
/// # Errors
/// Data that JSON can't hold.
pub fn page_table(
    title: impl Into<String>,
    note: impl Into<String>,
    text: TextTable,
    data: &(impl Serialize + ?Sized),
) -> Result<ReportTable, ReportError> {
    let (title, note) = (title.into(), note.into());
    let data = serde_json::to_value(data).map_err(ReportError::json(Path::new(&title)))?;
    Ok(ReportTable { title, note, text, data })
}

/// The value, or a dash where there is none.
#[must_use]
pub fn or_dash(value: Option<String>) -> String {
    value.unwrap_or_else(|| "–".to_owned())
}

/// A table for a terminal: columns of equal width, a line for the header and each row.
#[must_use]
pub fn terminal_table(table: &TextTable) -> String {
    let mut lines: Vec<Vec<String>> = vec![table.header.clone()];
    lines.extend(table.rows.iter().map(|row| row.iter().map(|cell| cell.text.clone()).collect()));
    for cell in lines.iter_mut().flatten() {
        *cell = cell.replace('\n', " ");
    }
    let n_columns = lines.iter().map(Vec::len).max().unwrap_or(0);
    let width = |i: usize| lines.iter().filter_map(|l| l.get(i)).map(|c| c.chars().count()).max();
    let widths: Vec<usize> = (0..n_columns).map(|i| width(i).unwrap_or(0)).collect();
    let line = |cells: &Vec<String>| {
        let padded = cells.iter().zip(&widths).map(|(cell, width)| format!(" {cell:<width$} "));
        padded.collect::<String>().trim_end().to_owned()
    };
    lines.iter().map(line).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up() {
        let columns: [Column<(&str, f64)>; 2] = [
            Column::new("what", |row| row.0.to_owned()),
            Column::new("µm", |row| format!("{:.1}", row.1)),
        ];
        let table = table(&columns, &[("one", 1.0), ("twenty", 20.0)]);
        assert_eq!(terminal_table(&table), " what    µm\n one     1.0\n twenty  20.0");
    }
}
