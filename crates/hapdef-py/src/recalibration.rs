//! Known touches that keep a scene's calibration up to date.

use std::time::SystemTime;

use hapdef::OpenScene;
use hapdef::touch::{DeclaredForce, DeclaredTouch, JournalTouch, Recalibrator, TouchAssumptions};
use hapdef_inverse::TouchZero;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::profile;
use crate::work::work;

/// Touches of known place and force.
pub(crate) struct TouchTable {
    pub positions_m: Vec<[f64; 3]>,
    /// Forces on the skin.
    pub forces_n: Vec<[f64; 3]>,
    /// Tared readings `[n, n_gauges]`, µε.
    pub readings_ue: Vec<f64>,
    pub times_s: Option<Vec<f64>>,
    pub position_sd_m: f64,
    pub force_sd_n: f64,
}

/// Takes touches and writes calibration and journal; what became of each.
pub(crate) fn recalibrate<'py>(
    py: Python<'py>,
    scene: &OpenScene,
    table: TouchTable,
    assumed: TouchAssumptions,
) -> PyResult<Bound<'py, PyAny>> {
    let n_gauges = scene.limb().gauges.len();
    let [n, n_forces] = [table.positions_m.len(), table.forces_n.len()];
    let n_rows = table.readings_ue.len() / n_gauges;
    if n_forces != n || n_rows != n {
        return Err(PyValueError::new_err(format!(
            "expected a force and readings for each of {n} positions, found {n_forces} forces and {n_rows} rows of \
             readings"
        )));
    }
    let taken = work(py, scene, move |scene| {
        let mut recalibrator = Recalibrator::of_scene(scene.run(), scene.limb())?;
        let mut taken: Vec<JournalTouch> = Vec::new();
        for touch in table.touches(n_gauges) {
            taken.push(recalibrator.touch(&touch, &assumed, now_s())?);
        }
        recalibrator.write()?;
        Ok(taken)
    })?;
    let values = taken.iter().map(serde_json::to_value).collect::<Result<Vec<_>, _>>();
    let values = values.map_err(|error| PyValueError::new_err(error.to_string()))?;
    profile::to_python(py, &values.into())
}

/// Undoes the last `n` touches that were taken, or all; returns how many.
pub(crate) fn undo_touches(py: Python<'_>, scene: &OpenScene, n: Option<usize>) -> PyResult<usize> {
    work(py, scene, move |scene| {
        let mut recalibrator = Recalibrator::of_scene(scene.run(), scene.limb())?;
        let n_undone = recalibrator.undo(n, now_s())?;
        recalibrator.write()?;
        Ok(n_undone)
    })
}

impl TouchTable {
    fn touches(self, n_gauges: usize) -> impl Iterator<Item = DeclaredTouch> {
        (0..self.positions_m.len()).map(move |i| DeclaredTouch {
            from: format!("Python, touch {i}"),
            t_s: self.times_s.as_ref().map(|times_s| times_s[i]),
            position_m: self.positions_m[i],
            force: DeclaredForce::Vector(self.forces_n[i]),
            position_sd_m: self.position_sd_m,
            force_sd_n: self.force_sd_n,
            readings_ue: self.readings_ue[i * n_gauges..(i + 1) * n_gauges].to_vec(),
            zero: TouchZero::Tared,
        })
    }
}

fn now_s() -> u64 {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    since.map_or(0, |since| since.as_secs())
}
