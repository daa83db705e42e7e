//! hapdef for Python: a scene becomes response, presses, calibration, nets and contacts, all as NumPy
//! arrays.
//!
//! [`PyScene`] is a scene with its limb; [`PyResponse`] what its gauges read for a newton anywhere;
//! [`PyRig`] the simulated hardware; [`PyEstimator`] finds contacts in arrays of frames,
//! [`PyLive`] in a stream. [`PyShell`] goes from a glTF surface to a response.
//!
//! Everything is computed by the crates below; here are only arrays, errors and Ctrl-C. The
//! compliance, by far the largest array, is handed over, not copied; arguments and smaller arrays are
//! copied. The wheel is built by maturin; `docs/python.md` says how.

mod array;
mod calibration;
mod error;
mod estimates;
mod estimator;
mod layout;
mod live;
mod live_frame;
mod profile;
mod recalibration;
mod response;
mod rig;
mod scene;
mod shell;
mod touch_sensor;
mod work;
mod wrench;

use pyo3::prelude::*;

pub use calibration::PyCalibration;
pub use error::{HapdefError, SceneError};
pub use estimates::{PyContact, PyEstimates};
pub use estimator::PyEstimator;
pub use layout::PyLayout;
pub use live::PyLive;
pub use live_frame::{PyLiveFrame, PyQuality};
pub use response::{PyBounds, PyResponse};
pub use rig::PyRig;
pub use scene::PyScene;
pub use shell::PyShell;
pub use touch_sensor::PyTouchSensor;
pub use wrench::{PyJointTorques, PyWrench};

/// The module `hapdef._hapdef`, which `hapdef` hands on.
#[pymodule]
fn _hapdef(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("HapdefError", py.get_type::<HapdefError>())?;
    module.add("SceneError", py.get_type::<SceneError>())?;
    module.add_class::<PyBounds>()?;
    module.add_class::<PyCalibration>()?;
    module.add_class::<PyContact>()?;
    module.add_class::<PyEstimates>()?;
    module.add_class::<PyEstimator>()?;
    module.add_class::<PyJointTorques>()?;
    module.add_class::<PyLayout>()?;
    module.add_class::<PyLive>()?;
    module.add_class::<PyLiveFrame>()?;
    module.add_class::<PyQuality>()?;
    module.add_class::<PyResponse>()?;
    module.add_class::<PyRig>()?;
    module.add_class::<PyScene>()?;
    module.add_class::<PyShell>()?;
    module.add_class::<PyTouchSensor>()?;
    module.add_class::<PyWrench>()
}
