//! No row of the stability table is silently wrong, whichever elements are stiff.

use hapdef_report::StabilityCase;
use hapdef_verify::{stability_line, stability_rows};

#[test]
fn no_row_is_silently_wrong() {
    let rows = stability_rows(3, |row| println!("{}", stability_line(row)));
    let rows = rows.expect("every row's set-up is sound");
    let failed = rows.iter().filter(|row| row.is_failed());
    let failed: Vec<String> = failed.map(stability_line).collect();
    assert!(rows.len() > 150, "{} rows", rows.len());
    assert!(failed.is_empty(), "{failed:#?}");
}
