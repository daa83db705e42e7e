//! Whether the results page of a full run is still about what the code makes.

use hapdef_report::NamedText;
use serde_json::Value;

use crate::error::ReproError;

/// Facts that a run of any amounts shares with a full one.
const SHARED_FACTS: [&str; 3] = ["simulated", "limb", "rig"];

/// Table of the claims, and its columns that no run changes: claim, the paper's figures, metric.
const CLAIMS: &str = "What the paper claims";
const N_CLAIMED: usize = 3;

/// Compares the `page` of a full run with the `report` of a quick one of the same limb: the facts that
/// both share, `amounts` of a full run as they are now, tables with their columns, and the claims. What
/// was measured is not compared.
pub fn check_results(page: &str, report: &Value, amounts: &[NamedText]) -> Result<(), ReproError> {
    let lines: Vec<&str> = page.lines().collect();
    let mut differences = Vec::new();
    let mut expect = |line: &str| {
        if !lines.contains(&line) {
            differences.push(format!("not in it: {line}"));
        }
    };
    expect(&format!("- scene: {}", shown(&report["scene"])));
    for fact in items(&report["facts"]) {
        let (name, text) = (shown(&fact["name"]), shown(&fact["text"]));
        if SHARED_FACTS.contains(&name.as_str()) {
            expect(&format!("- {name}: {text}"));
        }
    }
    for fact in amounts {
        expect(&format!("- {}: {}", fact.name, fact.text));
    }
    for table in items(&report["tables"]) {
        expect(&format!("## {}", shown(&table["title"])));
        expect(header_row(&table["text"]).trim_end());
    }
    let claims = items(&report["tables"]).iter().find(|table| table["title"] == CLAIMS);
    for cells in claims.map_or(&[][..], |table| items(&table["text"]["rows"])) {
        let claimed: Vec<String> = items(cells).iter().map(|c| shown(&c["text"])).collect();
        let begins = row(&claimed[..claimed.len().min(N_CLAIMED)]);
        let begins = begins.trim_end();
        if !lines.iter().any(|line| line.starts_with(begins)) {
            differences.push(format!("not claimed in it: {begins}"));
        }
    }
    if differences.is_empty() { Ok(()) } else { Err(ReproError::StaleResults { differences }) }
}

/// The line of a table's column names.
fn header_row(table: &Value) -> String {
    let header: Vec<String> = items(&table["header"]).iter().map(shown).collect();
    row(&header)
}

fn row(cells: &[String]) -> String {
    let cells: Vec<String> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
    format!("| {} |\n", cells.join(" | "))
}

fn items(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

fn shown(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

#[cfg(test)]
mod tests {
    use hapdef_bench::text_table;
    use hapdef_report::{Report, ReportTable};

    use super::super::results_markdown;
    use super::*;

    fn report() -> Report {
        let table = |title: &str, header: [&str; 4], row: [&str; 4]| ReportTable {
            title: title.into(),
            note: String::new(),
            text: text_table(header, [row.map(str::to_owned)]),
            data: Value::Null,
        };
        let claims = ["claim", "paper", "metric", "verdict"];
        let fact = |name: &str, text: &str| NamedText { name: name.into(), text: text.into() };
        Report {
            scene: "shin".into(),
            profile: "full".into(),
            facts: vec![fact("limb", "20 nodes"), fact("training", "9 steps")],
            tables: vec![
                table(CLAIMS, claims, ["a < b", "1 / 2", "|e|", "holds"]),
                table("Table 1", ["method", "I", "II", "III"], ["LR", "1", "2", "3"]),
            ],
            ..Report::default()
        }
    }

    #[test]
    fn a_page_is_stale_where_limb_training_tables_or_claims_changed() {
        let page = results_markdown(&report());
        let report = || serde_json::to_value(report()).unwrap();
        let amounts =
            |steps: &str| [NamedText { name: "training".into(), text: format!("{steps} steps") }];
        assert!(check_results(&page, &report(), &amounts("9")).is_ok());
        let n_of = |change: fn(&mut Value), steps: &str| {
            let mut now = report();
            change(&mut now);
            match check_results(&page, &now, &amounts(steps)) {
                Err(ReproError::StaleResults { differences }) => differences.len(),
                _ => 0,
            }
        };
        assert_eq!(n_of(|_| (), "8"), 1);
        assert_eq!(n_of(|r| r["facts"][0]["text"] = "21 nodes".into(), "9"), 1);
        assert_eq!(n_of(|r| r["scene"] = "other".into(), "9"), 1);
        assert_eq!(n_of(|r| r["tables"][1]["title"] = "Table 3".into(), "9"), 1);
        assert_eq!(n_of(|r| r["tables"][1]["text"]["header"][1] = "V".into(), "9"), 1);
        let other_claim =
            |r: &mut Value| r["tables"][0]["text"]["rows"][0][0]["text"] = "b < a".into();
        assert_eq!(n_of(other_claim, "9"), 1);
        // a quick run's verdict and figures are others
        assert_eq!(n_of(|r| r["tables"][0]["text"]["rows"][0][3]["text"] = "fails".into(), "9"), 0);
        assert_eq!(n_of(|r| r["tables"][1]["text"]["rows"][0][1]["text"] = "7".into(), "9"), 0);
    }
}
