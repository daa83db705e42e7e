//! Known touches of a table.

use std::path::Path;

use anyhow::{Result, bail, ensure};
use hapdef::touch::{DeclaredForce, DeclaredTouch};
use hapdef_cli::shown;
use hapdef_inverse::TouchZero;

use super::RecalibrateArgs;
use crate::cli::table::{Row, column_names, read_table};

/// Where a touch presses; a table without names has these, then the force against the skin.
const PLACE: [&str; 3] = ["x_m", "y_m", "z_m"];
const NORMAL: [&str; 1] = ["force_n"];
const VECTOR: [&str; 3] = ["fx_n", "fy_n", "fz_n"];
const TIME: &str = "t_s";
const POSITION_SD: &str = "position_sd_mm";
const FORCE_SD: &str = "force_sd_n";

/// The touches of a table, each with its line, frames in which nothing touches being their zeros.
pub(super) fn read_touches(
    args: &RecalibrateArgs,
    table: &Path,
    gauges: &[&str],
) -> Result<Vec<(String, DeclaredTouch)>> {
    let columns = columns(table)?;
    let rows = read_table(table, &args.topic, &columns, gauges)?;
    let mut zero = TouchZero::Tared;
    let mut touches = Vec::new();
    for row in rows {
        let touch = TouchRow { columns: &columns, row: &row };
        let force = touch.force();
        let readings_ue = row.values[columns.len()..].to_vec();
        if is_none(force) {
            zero = TouchZero::Untouched(readings_ue);
            continue;
        }
        let from = format!("{}: {}", shown(table), row.place);
        let [x, y, z] = PLACE.map(|name| touch.value(name).unwrap_or_default());
        let declared = DeclaredTouch {
            from,
            t_s: touch.value(TIME),
            position_m: [x, y, z],
            force,
            position_sd_m: touch.value(POSITION_SD).unwrap_or(args.position_sd_mm) * 1e-3,
            force_sd_n: touch.value(FORCE_SD).unwrap_or(args.force_sd_n),
            readings_ue,
            zero: zero.clone(),
        };
        if zero != TouchZero::Tared {
            zero = TouchZero::Followed;
        }
        touches.push((row.place.clone(), declared));
    }
    ensure!(
        !touches.is_empty(),
        "{}: expected touches, found frames of force 0 alone: no gain shows without a force",
        shown(table)
    );
    Ok(touches)
}

/// Columns beside the gauges' that the table has, in its order.
fn columns(table: &Path) -> Result<Vec<&'static str>> {
    let plain: Vec<&str> = PLACE.into_iter().chain(NORMAL).collect();
    let names = column_names(table)?;
    let known = plain.iter().chain(&VECTOR).chain(&[TIME, POSITION_SD, FORCE_SD]);
    let place = |name: &str| names.iter().position(|found| found.eq_ignore_ascii_case(name));
    let mut found: Vec<(usize, &str)> =
        known.filter_map(|name| Some((place(name)?, *name))).collect();
    found.sort_unstable();
    let found: Vec<&str> = found.into_iter().map(|(_, name)| name).collect();
    let has = |wanted: &[&str]| wanted.iter().all(|name| found.contains(name));
    match (has(&PLACE), has(&NORMAL), has(&VECTOR)) {
        // a table without names, or one whose names read_table refuses
        _ if found.is_empty() => Ok(plain),
        (true, true, false) | (true, false, true) => Ok(found),
        _ => bail!(
            "{}: names of columns: expected x_m, y_m, z_m and either force_n or fx_n, fy_n, fz_n, found {}",
            shown(table),
            found.join(", ")
        ),
    }
}

struct TouchRow<'a> {
    columns: &'a [&'static str],
    row: &'a Row,
}

impl TouchRow<'_> {
    fn value(&self, name: &str) -> Option<f64> {
        let column = self.columns.iter().position(|column| *column == name)?;
        Some(self.row.values[column])
    }

    fn force(&self) -> DeclaredForce {
        match self.value(NORMAL[0]) {
            Some(force_n) => DeclaredForce::Normal(force_n),
            None => DeclaredForce::Vector(VECTOR.map(|name| self.value(name).unwrap_or_default())),
        }
    }
}

fn is_none(force: DeclaredForce) -> bool {
    match force {
        DeclaredForce::Normal(force_n) => force_n == 0.0,
        DeclaredForce::Vector(force_n) => force_n == [0.0; 3],
    }
}
