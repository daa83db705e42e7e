//! The table in ARCHITECTURE.md, section Weight.

use anyhow::{Context, Result};

use super::Row;

const HEAD: [&str; 2] =
    ["| build | packages | crates | release build, s | rlibs, MB |", "|---|---|---|---|---|"];

/// In place of seconds and bytes.
const NOT_BUILT: &str = "–";

/// Begins the line that says what seconds and bytes were measured on.
const MADE: &str = "Built by `cargo xtask weight --build`";

/// The table; a layer that was not built has no seconds and no bytes.
pub(super) fn text(rows: &[Row]) -> String {
    let lines = rows.iter().map(|row| {
        let (seconds, megabytes) = match &row.built {
            Some(b) => (format!("{:.0}", b.seconds), format!("{:.1}", b.megabytes())),
            None => (NOT_BUILT.to_owned(), NOT_BUILT.to_owned()),
        };
        let layers = row.layers;
        format!(
            "| {} | {} | {} | {seconds} | {megabytes} |",
            layers.name,
            layers.shown(),
            row.n_crates
        )
    });
    let head = HEAD.into_iter().map(str::to_owned);
    head.chain(lines).collect::<Vec<_>>().join("\n")
}

/// Where the page has other crates than `rows`, or rows too many.
pub(super) fn faults(architecture: &str, rows: &[Row]) -> Result<Vec<String>> {
    let there = written(architecture)?;
    let mut faults = Vec::new();
    for row in rows {
        let (name, shown, n) = (row.layers.name, row.layers.shown(), row.n_crates.to_string());
        match there.iter().find(|cells| cells[0] == name) {
            None => faults.push(format!("no row {name}: {shown}, {n} crates")),
            Some(cells) if cells[1] != shown || cells[2] != n => {
                faults.push(format!("{name}: {shown} is {n} crates, not {}", cells[2]));
            }
            Some(cells) if !cells[3..].iter().all(|cell| is_figure(cell)) => {
                faults.push(format!("{name}: seconds or bytes are no numbers"));
            }
            Some(_) => {}
        }
    }
    let is_known = |name: &str| rows.iter().any(|row| row.layers.name == name);
    let others = there.iter().filter(|cells| !is_known(cells[0]));
    faults.extend(others.map(|cells| format!("there is no layer {}", cells[0])));
    Ok(faults)
}

/// Bytes that the page has for a layer, MB; nothing where it was not built yet.
pub(super) fn megabytes(architecture: &str, name: &str) -> Result<Option<f64>> {
    let there = written(architecture)?;
    let cells = there.iter().find(|cells| cells[0] == name);
    let cells = cells.with_context(|| format!("ARCHITECTURE.md, Weight, has no row {name}"))?;
    Ok(cells[4].parse().ok())
}

/// A number, or the mark of a layer that was not built yet.
fn is_figure(cell: &str) -> bool {
    cell == NOT_BUILT || cell.parse::<f64>().is_ok()
}

/// The page with this table in place of the one that it has, and `made` below it.
pub(super) fn replaced(architecture: &str, rows: &[Row], made: &str) -> Result<String> {
    let (before, section, after) = parts(architecture)?;
    let is_old = |line: &&str| line.starts_with('|') || line.starts_with(MADE);
    let words: Vec<&str> = section.lines().filter(|line| !is_old(line)).collect();
    let words = words.join("\n");
    let words = words.trim();
    Ok(format!("{before}{words}\n\n{}\n\n{made}\n{after}", text(rows)))
}

/// Cells of the table's rows, its head left out.
fn written(architecture: &str) -> Result<Vec<Vec<&str>>> {
    let (_, section, _) = parts(architecture)?;
    let rows = section.lines().filter(|line| line.starts_with('|'));
    let rows = rows.filter(|line| !HEAD.contains(line));
    rows.map(|line| {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        (cells.len() == 5)
            .then_some(cells)
            .with_context(|| format!("ARCHITECTURE.md, Weight: expected 5 cells in {line:?}"))
    })
    .collect()
}

/// What is before, in and after the section.
fn parts(architecture: &str) -> Result<(&str, &str, &str)> {
    const TITLE: &str = "\n## Weight\n\n";
    let start = architecture.find(TITLE).map(|at| at + TITLE.len());
    let start = start.context("ARCHITECTURE.md has no section Weight")?;
    let rest = &architecture[start..];
    let end = start + rest.find("\n## ").unwrap_or(rest.len());
    Ok((&architecture[..start], &architecture[start..end], &architecture[end..]))
}

#[cfg(test)]
mod tests {
    use super::super::build::Built;
    use super::super::layers::LAYERS;
    use super::*;

    fn rows(n_crates: usize) -> Vec<Row> {
        let row = |layers| Row {
            layers,
            n_crates,
            built: Some(Built { seconds: 12.3, bytes: 4_560_000 }),
        };
        LAYERS[..2].iter().map(row).collect()
    }

    #[test]
    fn a_table_that_was_written_is_read_again() {
        let page = "# A\n\n## Weight\n\nWords.\n\n| old |\n\n## B\n| kmax |\n";
        let page = replaced(page, &rows(7), "Built by `cargo xtask weight --build` here.").unwrap();
        assert!(page.contains("| kmax | hapdef-kmax/points | 7 | 12 | 4.6 |"), "{page}");
        assert!(page.ends_with("here.\n\n## B\n| kmax |\n"), "{page}");
        assert_eq!(faults(&page, &rows(7)).unwrap(), Vec::<String>::new());
        assert_eq!(megabytes(&page, "kmax").unwrap(), Some(4.6));
        let again = replaced(&page, &rows(7), "Built by `cargo xtask weight --build` here.");
        assert_eq!(again.unwrap(), page);
    }

    #[test]
    fn what_differs_is_named() {
        let page = format!("\n## Weight\n\n{}\n\n## B\n", text(&rows(7)));
        assert_eq!(faults(&page, &rows(8)).unwrap().len(), 2);
        assert_eq!(faults(&page, &rows(7)[..1]).unwrap(), ["there is no layer data"]);
        let unbuilt = page.replace("12 | 4.6", "– | –");
        assert!(faults(&unbuilt, &rows(7)).unwrap().is_empty());
        assert_eq!(megabytes(&unbuilt, "kmax").unwrap(), None);
        let odd = page.replace("12 | 4.6", "12 | much");
        assert_eq!(faults(&odd, &rows(7)).unwrap().len(), 2);
        assert!(faults("# A\n", &rows(7)).is_err());
    }
}
