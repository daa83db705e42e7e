//! No row of the robustness table is silently wrong, whichever elements are stiff.

use hapdef_report::robustness::Row;
use hapdef_verify::robustness_rows;

#[test]
fn no_row_is_silently_wrong() {
    let rows = robustness_rows(3, |row| println!("{}", row.line()));
    let rows = rows.expect("every row's set-up is sound");
    let failed: Vec<String> = rows.iter().filter(|row| row.failed).map(Row::line).collect();
    assert!(rows.len() > 150, "{} rows", rows.len());
    assert!(failed.is_empty(), "{failed:#?}");
}
