//! The presses of the tactile skin, read from its tables.

use std::path::{Path, PathBuf};

use hapdef_report::ReportError;

use crate::error::ReproError;

/// Channels of the skin: five magnetometers of three axes.
const N_CHANNELS: usize = 15;
/// Columns of the table of channels: the time, then the channels.
const CHANNEL_COLUMNS: usize = 1 + N_CHANNELS;
/// Columns of the table of places: the time, then x, y, z, mm.
const PLACE_COLUMNS: usize = 4;

/// The runs' folders, in the order in which the reference takes them.
const RUNS: [&str; 2] = ["20250316_155729_probe", "20250317_134149_probe"];

/// One run of the probe over the skin.
#[derive(Clone, Debug, PartialEq)]
pub struct TactileRun {
    /// Folder that the run was read from.
    pub name: String,
    /// Channels of a press.
    pub n_channels: usize,
    /// Channels with their baselines taken off, `[n, n_channels]`, the sensor's own unit.
    pub channels: Vec<f32>,
    /// Place of the probe in the plane of the skin, `[n, 2]`, mm.
    pub place_mm: Vec<f32>,
}

impl TactileRun {
    /// Presses of the run.
    pub fn n(&self) -> usize {
        self.place_mm.len() / 2
    }
}

/// Where the skin's runs lie below a folder of shared inputs.
pub fn tactile_folder(shared: &Path) -> PathBuf {
    shared.join("inputs/tactile/eflesh_spatial_resolution")
}

/// Reads both runs below `folder`; the probe's depth is left out, it is the same everywhere up to
/// 2 mm.
pub fn read_tactile_runs(folder: &Path) -> Result<Vec<TactileRun>, ReproError> {
    RUNS.iter().map(|name| read_run(folder, name)).collect()
}

fn read_run(folder: &Path, name: &str) -> Result<TactileRun, ReproError> {
    let folder = folder.join(name);
    let channels = read_table(&folder.join("sensor_post_baselines.csv"), CHANNEL_COLUMNS)?;
    let places_path = folder.join("states.csv");
    let places = read_table(&places_path, PLACE_COLUMNS)?;
    if places.len() != channels.len() {
        return Err(ReproError::Line {
            path: places_path,
            line: places.len(),
            what: format!("the last line, but there are {} presses", channels.len()),
        });
    }
    Ok(TactileRun {
        name: name.to_owned(),
        n_channels: N_CHANNELS,
        channels: channels.iter().flat_map(|row| &row[1..]).copied().collect(),
        place_mm: places.iter().flat_map(|row| &row[1..3]).copied().collect(),
    })
}

fn read_table(path: &Path, n_columns: usize) -> Result<Vec<Vec<f32>>, ReproError> {
    let text = std::fs::read_to_string(path).map_err(ReportError::io("reading", path))?;
    let rows = text.lines().enumerate().map(|(i, line)| {
        read_line(line, n_columns).map_err(|what| ReproError::Line {
            path: path.to_owned(),
            line: i + 1,
            what,
        })
    });
    rows.collect()
}

fn read_line(line: &str, n_columns: usize) -> Result<Vec<f32>, String> {
    let values: Vec<f32> = line
        .split(',')
        .map(|cell| match cell.trim().parse::<f32>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(format!("expected a finite number, found {cell:?}")),
        })
        .collect::<Result<_, _>>()?;
    if values.len() == n_columns {
        return Ok(values);
    }
    Err(format!("expected {n_columns} columns, found {}", values.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(channels: &str, places: &str) -> String {
        let folder = tempfile::tempdir().unwrap();
        let run = folder.path().join(RUNS[0]);
        std::fs::create_dir(&run).unwrap();
        std::fs::write(run.join("sensor_post_baselines.csv"), channels).unwrap();
        std::fs::write(run.join("states.csv"), places).unwrap();
        read_tactile_runs(folder.path()).unwrap_err().to_string()
    }

    #[test]
    fn lines_that_are_no_presses_are_named() {
        let row = "1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16\n";
        let broken = row.replace("16", "NaN");
        assert!(refusal(&broken, "0,1,2,3\n").contains("line 1: expected a finite number"));
        assert!(
            refusal(&format!("{row}1,2\n"), "").contains("line 2: expected 16 columns, found 2")
        );
        assert!(refusal(row, "0,1,2,3\n0,1,2,3\n").contains("but there are 1 presses"));
    }
}
