//! The table of presses: a line for each, as a probing robot writes it.

use std::fmt::Write as _;
use std::path::Path;

use hapdef_mesh::atomic_write;
use nalgebra::Point3;

use crate::error::HapdefError;

/// A press of known place and force, and what the gauges read.
#[derive(Clone, Debug, PartialEq)]
pub struct PressRow {
    /// Where, m.
    pub position_m: Point3<f64>,
    /// Normal force, N.
    pub force_n: f64,
    /// Tared readings `[n_gauges]`, µε.
    pub readings_ue: Vec<f64>,
}

/// Writes a table: a first line of names, then `x_m,y_m,z_m,force_n` and the readings of each press.
///
/// # Errors
/// [`HapdefError::File`] when it can't be written.
pub fn write_press_table(path: &Path, presses: &[PressRow]) -> Result<(), HapdefError> {
    let n_gauges = presses.first().map_or(0, |press| press.readings_ue.len());
    let mut text = String::from("x_m,y_m,z_m,force_n");
    (0..n_gauges).for_each(|gauge| text.push_str(&format!(",g{gauge}_ue")));
    text.push('\n');
    for press in presses {
        let [x, y, z] = press.position_m.coords.into();
        // Writing to a string does not fail.
        let _ = write!(text, "{x},{y},{z},{}", press.force_n);
        for reading in &press.readings_ue {
            let _ = write!(text, ",{reading}");
        }
        text.push('\n');
    }
    atomic_write(path, |file| std::io::Write::write_all(file, text.as_bytes()))
        .map_err(HapdefError::file(path))
}
