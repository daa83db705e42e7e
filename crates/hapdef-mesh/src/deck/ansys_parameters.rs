//! The parameters and tables of an ANSYS deck: what `%name%` in a load stands for.

use std::collections::BTreeMap;

use super::DeckFault;
use super::inp_keyword::quoted;

/// A table over time: rows by number, each a time and a value.
#[derive(Debug, Default)]
pub(super) struct Table {
    rows: BTreeMap<usize, (Option<f64>, Option<f64>)>,
    n_rows: usize,
}

/// Numbers by name: what `%name%` in a load stands for.
#[derive(Debug, Default)]
pub(super) struct Parameters {
    tables: BTreeMap<String, Table>,
    scalars: BTreeMap<String, Option<f64>>,
}

impl Parameters {
    /// `*DIM,name,TABLE,rows,1,1,TIME`; arrays and strings hold nothing that is read here.
    pub(super) fn dimension(&mut self, line: usize, fields: &[&str]) -> Result<(), DeckFault> {
        let name = fields.get(1).copied().unwrap_or("").to_lowercase();
        if !fields.get(2).is_some_and(|kind| kind.eq_ignore_ascii_case("table")) {
            return Ok(());
        }
        let n_rows = fields.get(3).and_then(|rows| rows.parse().ok()).unwrap_or(0);
        let plane = |i: usize| matches!(fields.get(i), None | Some(&"" | &"1"));
        let over_time = matches!(fields.get(6), Some(var) if var.eq_ignore_ascii_case("time"));
        if n_rows == 0 || !plane(4) || !plane(5) || !over_time {
            let expected = "a table of one value over TIME";
            return Err(unexpected(line, expected, &fields.join(",")));
        }
        self.tables.insert(name, Table { rows: BTreeMap::new(), n_rows });
        Ok(())
    }

    /// `name = value` or `table(row, column, plane) = value`. A value that is not a plain number
    /// leaves the name without one.
    pub(super) fn assign(&mut self, line: usize, name: &str, value: &str) -> Result<(), DeckFault> {
        let number = value.trim().parse::<f64>().ok().filter(|value| value.is_finite());
        let name = name.trim().to_lowercase();
        let Some((array, indices)) = name.split_once('(') else {
            self.scalars.insert(name, number);
            return Ok(());
        };
        let Some(table) = self.tables.get_mut(array.trim()) else {
            return Ok(());
        };
        let indices: Vec<usize> = indices
            .trim_end_matches(')')
            .split(',')
            .map(|index| index.trim().parse().unwrap_or(usize::MAX))
            .collect();
        let (row, column) = (indices[0], indices.get(1).copied().unwrap_or(1));
        let number = number.ok_or_else(|| unexpected(line, "a number", value))?;
        if row == 0 || row > table.n_rows || column > 1 {
            let expected = format!("an index within the table's {} rows", table.n_rows);
            return Err(unexpected(line, &expected, &name));
        }
        let entry = table.rows.entry(row).or_default();
        match column {
            0 => entry.0 = Some(number),
            _ => entry.1 = Some(number),
        }
        Ok(())
    }

    /// A parameter whose value this reader does not follow.
    pub(super) fn forget(&mut self, name: &str) {
        self.scalars.insert(name.to_lowercase(), None);
    }

    /// A load's value at `time`: a number, `%parameter%` or `%table%`.
    pub(super) fn value(&self, line: usize, field: &str, time: f64) -> Result<f64, DeckFault> {
        if let Ok(value) = field.parse::<f64>() {
            return match value.is_finite() {
                true => Ok(value),
                false => Err(unexpected(line, "a finite number", field)),
            };
        }
        let name = field.trim_matches('%').to_lowercase();
        if let Some(table) = self.tables.get(&name) {
            return table.at(time).ok_or_else(|| {
                let expected = format!("table {name} filled with rising times around time {time}");
                unexpected(line, &expected, "none")
            });
        }
        self.scalars.get(&name).copied().flatten().ok_or(DeckFault::Undefined {
            line,
            kind: "table or number",
            name,
        })
    }
}

impl Table {
    /// Linear interpolation; outside its times the table keeps its first or last value, as in
    /// ANSYS.
    fn at(&self, time: f64) -> Option<f64> {
        let rows: Option<Vec<(f64, f64)>> = (1..=self.n_rows)
            .map(|row| self.rows.get(&row).and_then(|r| Some((r.0?, r.1?))))
            .collect();
        let rows = rows.filter(|rows| rows.windows(2).all(|w| w[0].0 < w[1].0))?;
        let after = rows.partition_point(|row| row.0 <= time);
        match (after.checked_sub(1).map(|i| rows[i]), rows.get(after)) {
            (Some((t0, v0)), Some(&(t1, v1))) => Some(v0 + (v1 - v0) * (time - t0) / (t1 - t0)),
            (Some((_, value)), None) | (None, Some(&(_, value))) => Some(value),
            (None, None) => None,
        }
    }
}

fn unexpected(line: usize, expected: &str, found: &str) -> DeckFault {
    DeckFault::Unexpected { line, expected: expected.into(), found: quoted(found) }
}
