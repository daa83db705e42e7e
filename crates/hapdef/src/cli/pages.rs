//! Parts of pages that commands write.

use hapdef_report::{NamedText, TextCell, TextTable};

/// A line at the head of a page.
pub(super) fn fact(name: &str, text: String) -> NamedText {
    NamedText {
        name: name.into(),
        text,
    }
}

/// A table of plain cells.
pub(super) fn table<const N: usize>(
    header: [&str; N],
    rows: impl IntoIterator<Item = [String; N]>,
) -> TextTable {
    let cells = |row: [String; N]| row.map(TextCell::plain).to_vec();
    TextTable {
        header: header.map(str::to_owned).to_vec(),
        rows: rows.into_iter().map(cells).collect(),
    }
}
