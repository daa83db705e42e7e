//! Errors as Python exceptions, with hapdef's words.

use hapdef::error_text;
use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyKeyboardInterrupt};
use pyo3::prelude::*;

create_exception!(
    hapdef,
    HapdefError,
    PyException,
    "hapdef refused or failed; the message says what to do."
);
create_exception!(
    hapdef,
    SceneError,
    HapdefError,
    "A scene file was refused; the message names the JSON path."
);

/// What the crates below return.
pub(crate) type Fault = hapdef::HapdefError;

/// The exception for an error; what was stopped by Ctrl-C is a `KeyboardInterrupt`.
pub(crate) fn to_python(error: Fault) -> PyErr {
    let text = error_text(&error);
    match error {
        Fault::Scene(_) => SceneError::new_err(text),
        Fault::Stopped { .. } => PyKeyboardInterrupt::new_err(text),
        _ => HapdefError::new_err(text),
    }
}

/// The same for an error of one of the crates below.
pub(crate) fn raised(error: impl Into<Fault>) -> PyErr {
    to_python(error.into())
}
