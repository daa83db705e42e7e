//! Whether the results page of a full run is still about what the code makes.

use hapdef_report::NamedText;
use serde_json::Value;

use super::results::{header_row, items, row, shown};
use crate::ReproError;

/// Facts that a run of any amounts shares with a full one.
const SHARED_FACTS: [&str; 3] = ["simulated", "limb", "rig"];

/// Table of the claims, and its columns that no run changes: claim, the paper's figures, metric.
const CLAIMS: &str = "What the paper claims";
const N_CLAIMED: usize = 3;

/// Compares the `page` of a full run with the `report` of a quick one of the same limb: the facts that
/// both share, `amounts` of a full run as they are now, tables with their columns, and the claims. What
/// was measured is not compared.
///
/// # Errors
/// [`ReproError::StaleResults`] with everything that the page says otherwise or does not say.
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

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::super::results_markdown;
    use super::*;

    fn report() -> Value {
        let cell = |text: &str| json!({ "text": text, "strong": false });
        let table = |title: &str, header: [&str; 4], rows: [&str; 4]| {
            let rows = [rows.map(cell)];
            json!({ "title": title, "text": { "header": header, "rows": rows }, "note": "" })
        };
        json!({
            "scene": "shin", "profile": "full",
            "facts": [
                { "name": "limb", "text": "20 nodes" },
                { "name": "training", "text": "9 steps" },
            ],
            "tables": [
                table(CLAIMS, ["claim", "paper", "metric", "verdict"], ["a < b", "1 / 2", "|e|", "holds"]),
                table("Table 1", ["method", "I", "II", "III"], ["LR", "1", "2", "3"]),
            ],
            "metrics": [], "stages": [], "skipped": [],
        })
    }

    #[test]
    fn a_page_is_stale_where_limb_training_tables_or_claims_changed() {
        let page = results_markdown(&report());
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
