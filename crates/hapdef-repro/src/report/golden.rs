//! Golden values: what a quick run's tables held when they were last accepted.

use std::collections::BTreeMap;
use std::path::Path;

use hapdef_report::{ReportError, write_text};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::error::ReproError;

/// Linear regression, k-NN and SVR are solved, not trained: only the order of sums differs from one
/// processor to another.
const SOLVED_PERCENT: f64 = 1.0;
/// A net's training amplifies the last bit of f32, which differs with the width of the processor's
/// vectors. A map error is a mean over millions of nodes and moves little by that.
const MAP_PERCENT: f64 = 10.0;
/// A contact from a map is a choice among peaks, which turns small differences into large ones.
const CONTACT_PERCENT: f64 = 25.0;

/// A value and how far another run may be from it.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct GoldenValue {
    /// The value, in its table's unit.
    pub value: f64,
    /// Allowed difference, per cent of the value.
    pub within_percent: f64,
}

/// Golden values of one scene, profile and seed.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Golden {
    /// Name of the scene.
    pub scene: String,
    /// `quick` or `full`.
    pub profile: String,
    /// Seed of the training side.
    pub seed: u64,
    /// By table and place.
    pub values: BTreeMap<String, GoldenValue>,
}

impl Golden {
    /// Takes Tables 1 and 2 from a report's JSON.
    pub fn of(report: &Value) -> Result<Self, ReproError> {
        let mut values = BTreeMap::new();
        for table in report["tables"].as_array().into_iter().flatten() {
            match table["title"].as_str().unwrap_or_default() {
                title if title.starts_with("Table 1") => table1(&table["data"], &mut values)?,
                title if title.starts_with("Table 2") => table2(&table["data"], &mut values)?,
                _ => {}
            }
        }
        if values.is_empty() {
            return Err(refused("the report has neither Table 1 nor Table 2".to_owned()));
        }
        Ok(Self {
            scene: report["scene"].as_str().unwrap_or_default().to_owned(),
            profile: report["profile"].as_str().unwrap_or_default().to_owned(),
            seed: report["seed"].as_u64().unwrap_or_default(),
            values,
        })
    }

    /// Reads golden values.
    pub fn read(path: &Path) -> Result<Self, ReproError> {
        let bytes = std::fs::read(path).map_err(ReportError::io("reading", path))?;
        Ok(serde_json::from_slice(&bytes).map_err(ReportError::json(path))?)
    }

    /// Writes them.
    pub fn write(&self, path: &Path) -> Result<(), ReproError> {
        let json = serde_json::to_string_pretty(self).map_err(ReportError::json(path))?;
        Ok(write_text(path, &format!("{json}\n"))?)
    }

    /// Compares a report with them; how many values were compared.
    pub fn compare(&self, report: &Value) -> Result<usize, ReproError> {
        let found = Self::of(report)?;
        let of = |g: &Self| format!("{}, {}, seed {}", g.scene, g.profile, g.seed);
        if of(self) != of(&found) {
            return Err(refused(format!("expected {}, found {}", of(self), of(&found))));
        }
        let mut faults = Vec::new();
        for (place, golden) in &self.values {
            match found.values.get(place) {
                None => faults.push(format!("{place}: missing")),
                Some(found) if golden.allows(found.value) => {}
                Some(found) => faults.push(format!(
                    "{place}: expected {:.3} within {} %, found {:.3}",
                    golden.value, golden.within_percent, found.value
                )),
            }
        }
        let new = found.values.keys().filter(|place| !self.values.contains_key(*place));
        faults.extend(new.map(|place| format!("{place}: not among the golden values")));
        if faults.is_empty() { Ok(self.values.len()) } else { Err(refused(faults.join("; "))) }
    }
}

impl GoldenValue {
    fn allows(&self, found: f64) -> bool {
        (found - self.value).abs() <= self.value.abs() * self.within_percent / 100.0
    }
}

/// A fraction of variance is a square: it moves twice as far as an error.
fn table1(records: &Value, values: &mut BTreeMap<String, GoldenValue>) -> Result<(), ReproError> {
    for record in records.as_array().into_iter().flatten() {
        let text = |key: &str| record[key].as_str().unwrap_or("training");
        let within = if text("method") == "FNN" { MAP_PERCENT } else { SOLVED_PERCENT };
        let place = format!(
            "table 1, {}, {}, from {} on {}",
            text("metric"),
            text("method"),
            text("trained_on"),
            text("tested_on")
        );
        let within = if text("metric") == "fvu" { 2.0 * within } else { within };
        insert(values, place, &record["ours"], within)?;
    }
    Ok(())
}

fn table2(table: &Value, values: &mut BTreeMap<String, GoldenValue>) -> Result<(), ReproError> {
    for column in table["ours"].as_array().into_iter().flatten() {
        let name = column["name"].as_str().unwrap_or_default();
        let within = if name == "HapDef 2018" { SOLVED_PERCENT } else { CONTACT_PERCENT };
        for key in ["location_mm", "magnitude_n"] {
            insert(values, format!("table 2, {name}, {key}"), &column[key], within)?;
        }
    }
    Ok(())
}

fn insert(
    values: &mut BTreeMap<String, GoldenValue>,
    place: String,
    value: &Value,
    within_percent: f64,
) -> Result<(), ReproError> {
    let Some(value) = value.as_f64() else {
        return Err(refused(format!("{place}: no number")));
    };
    let value = GoldenValue { value, within_percent };
    values.insert(place, value);
    Ok(())
}

fn refused(what: String) -> ReproError {
    ReproError::Golden { what }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn report(fnn_um: f64, lr_um: f64) -> Value {
        let cell = |method: &str, ours: f64| {
            json!({ "metric": "mean_abs", "method": method, "trained_on": "I", "tested_on": "II",
                "ours": ours })
        };
        json!({
            "scene": "shin", "profile": "quick", "seed": 1,
            "tables": [{ "title": "Table 1: x", "data": [cell("FNN", fnn_um), cell("LR", lr_um)] }],
        })
    }

    #[test]
    fn each_method_has_its_tolerance() {
        let golden = Golden::of(&report(10.0, 10.0)).unwrap();
        assert_eq!(golden.compare(&report(10.9, 10.05)).unwrap(), 2);
        for (fnn_um, lr_um, place) in [(11.1, 10.0, "FNN"), (10.0, 10.2, "LR")] {
            let error = golden.compare(&report(fnn_um, lr_um)).unwrap_err().to_string();
            assert!(error.contains(place) && error.contains("within"), "{error}");
        }
    }

    #[test]
    fn another_run_and_other_cells_are_refused() {
        let golden = Golden::of(&report(1.0, 1.0)).unwrap();
        let mut other = report(1.0, 1.0);
        other["seed"] = 2.into();
        assert!(golden.compare(&other).is_err());
        let mut short = report(1.0, 1.0);
        short["tables"][0]["data"].as_array_mut().unwrap().pop();
        let error = golden.compare(&short).unwrap_err().to_string();
        assert!(error.contains("missing"), "{error}");
        let mut empty = report(1.0, 1.0);
        empty["tables"][0]["data"][0]["ours"] = Value::Null;
        assert!(Golden::of(&empty).is_err());
    }
}
