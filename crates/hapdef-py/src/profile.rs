//! How much to make and how long to train: a profile's name, and what is to be different.

use hapdef::Profile;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::Value;

/// The profile `quick` or `full` with `amounts` in place of its own values.
///
/// # Errors
/// `ValueError` for another name, or for amounts that a profile doesn't have.
pub(crate) fn profile_of(name: &str, amounts: Option<&Bound<'_, PyDict>>) -> PyResult<Profile> {
    let profile = match name {
        "quick" => Profile::quick(),
        "full" => Profile::full(),
        _ => {
            return Err(PyValueError::new_err(format!(
                "profile: expected 'quick' or 'full', found {name:?}"
            )));
        }
    };
    let Some(amounts) = amounts else {
        return Ok(profile);
    };
    let refused = |error: serde_json::Error| PyValueError::new_err(format!("amounts: {error}"));
    let mut whole = serde_json::to_value(&profile).map_err(refused)?;
    merge(&mut whole, from_python(amounts)?);
    serde_json::from_value(whole).map_err(refused)
}

/// A JSON value as Python's own dicts, lists and numbers.
pub(crate) fn to_python<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (value.to_string(),))
}

fn from_python(dict: &Bound<'_, PyDict>) -> PyResult<Value> {
    let text = dict.py().import("json")?.call_method1("dumps", (dict,))?;
    let text: String = text.extract()?;
    serde_json::from_str(&text).map_err(|error| PyValueError::new_err(format!("amounts: {error}")))
}

fn merge(into: &mut Value, from: Value) {
    match (into, from) {
        (Value::Object(into), Value::Object(from)) => {
            for (name, value) in from {
                merge(into.entry(name).or_insert(Value::Null), value);
            }
        }
        (into, from) => *into = from,
    }
}
