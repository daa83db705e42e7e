//! Tables of short texts, for Markdown and HTML.

use hapdef_contact::{printable, printable_lines};

/// Longest number with its unit, characters.
const MOST_FIGURE: usize = 14;

/// A cell.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct TextCell {
    /// What it says, unescaped.
    pub text: String,
    /// Whether it stands out.
    pub strong: bool,
}

impl TextCell {
    /// A cell that does not stand out.
    #[must_use]
    pub fn plain(text: impl Into<String>) -> Self {
        Self { text: text.into(), strong: false }
    }
}

/// A header and rows of as many cells.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct TextTable {
    /// Column names.
    pub header: Vec<String>,
    /// Rows, `[n_rows][n_columns]`.
    pub rows: Vec<Vec<TextCell>>,
}

/// Rows of plain texts under a header.
#[must_use]
pub fn text_table(
    header: impl IntoIterator<Item = impl Into<String>>,
    rows: impl IntoIterator<Item = impl IntoIterator<Item = String>>,
) -> TextTable {
    TextTable {
        header: header.into_iter().map(Into::into).collect(),
        rows: rows
            .into_iter()
            .map(|cells| cells.into_iter().map(TextCell::plain).collect())
            .collect(),
    }
}

impl TextTable {
    /// As a Markdown table; strong cells are bold.
    #[must_use]
    pub fn to_markdown(&self) -> String {
        let escape = |text: &str| printable(&text.replace('\n', " ")).replace('|', "\\|");
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let mut text = line(self.header.iter().map(|h| escape(h)).collect());
        text.push_str(&format!("|{}\n", "---|".repeat(self.header.len())));
        for row in &self.rows {
            let cell = |c: &TextCell| {
                let mark = if c.strong { "**" } else { "" };
                format!("{mark}{}{mark}", escape(&c.text))
            };
            text.push_str(&line(row.iter().map(cell).collect()));
        }
        text
    }

    /// As an HTML table, everything escaped; strong cells are `<strong>`.
    #[must_use]
    pub fn to_html(&self) -> String {
        let mut text = String::from("<table><thead><tr>");
        for name in &self.header {
            text.push_str(&format!("<th>{}</th>", escape_html(name)));
        }
        text.push_str("</tr></thead><tbody>\n");
        for row in &self.rows {
            text.push_str("<tr>");
            for cell in row {
                let inner = escape_html(&cell.text);
                let td = if is_figure(&cell.text) { "<td class=\"figure\">" } else { "<td>" };
                text.push_str(&match cell.strong {
                    true => format!("{td}<strong>{inner}</strong></td>"),
                    false => format!("{td}{inner}</td>"),
                });
            }
            text.push_str("</tr>\n");
        }
        text.push_str("</tbody></table>\n");
        text
    }
}

/// Whether a cell is a number with its unit, which is not broken into lines.
fn is_figure(text: &str) -> bool {
    let is_short = text.chars().count() <= MOST_FIGURE;
    is_short
        && text.trim_start_matches(['-', '−', '<', ' ']).starts_with(|c: char| c.is_ascii_digit())
}

/// A number for a table: two or three significant digits, "–" where not measured.
#[must_use]
pub fn cell_text(value: Option<f64>) -> String {
    match value {
        None => "–".to_owned(),
        Some(v) if !v.is_finite() => "NaN".to_owned(),
        Some(v) if v.abs() >= 99.95 => format!("{v:.0}"),
        Some(v) if v.abs() >= 0.995 => format!("{v:.1}"),
        Some(v) if v == 0.0 || v.abs() >= 0.0095 => format!("{v:.2}"),
        Some(v) => format!("{v:.1e}"),
    }
}

/// Text for HTML, in elements and in quoted attributes; ends of lines stay.
#[must_use]
pub fn escape_html(text: &str) -> String {
    printable_lines(text)
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_leading_digits() {
        let found = [286.9, 73.36, 1.05, 0.6, 0.004, 0.0].map(|v| cell_text(Some(v)));
        assert_eq!(found, ["287", "73.4", "1.1", "0.60", "4.0e-3", "0.00"]);
    }

    #[test]
    fn nothing_from_outside_is_an_element_or_turns_the_writing() {
        let found = escape_html("<b onload=\"x\">\u{202e}&\u{1b}[2J\ntwo");
        let expected = "&lt;b onload=&quot;x&quot;&gt;\\u{202e}&amp;\\u{1b}[2J\ntwo";
        assert_eq!(found, expected);
    }

    #[test]
    fn both_forms_escape() {
        let table = TextTable {
            header: vec!["a<b".to_owned(), "c|d".to_owned()],
            rows: vec![vec![
                TextCell::plain("x&y"),
                TextCell { text: "1|2".to_owned(), strong: true },
            ]],
        };
        let markdown = table.to_markdown();
        assert_eq!(markdown, "| a<b | c\\|d |\n|---|---|\n| x&y | **1\\|2** |\n");
        let html = table.to_html();
        assert!(html.contains("<th>a&lt;b</th>") && html.contains("<td>x&amp;y</td>"), "{html}");
        assert!(html.contains("<td class=\"figure\"><strong>1|2</strong></td>"), "{html}");
    }
}
