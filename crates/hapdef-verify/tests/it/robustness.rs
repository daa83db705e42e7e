//! No row of the robustness table is silently wrong, whichever elements are stiff.

use hapdef_bench::robustness::Row;
use hapdef_verify::{ROBUSTNESS_TABLE, robustness_trials};

#[test]
fn no_row_is_silently_wrong() {
    let rows = ROBUSTNESS_TABLE.rows(robustness_trials(3), |row| println!("{}", row.line()));
    let failed: Vec<String> = rows.iter().filter(|row| row.failed).map(Row::line).collect();
    assert!(rows.len() > 150, "{} rows", rows.len());
    assert!(failed.is_empty(), "{failed:#?}");
}
