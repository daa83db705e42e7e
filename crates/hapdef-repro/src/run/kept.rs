//! What this program makes once and keeps in a run's cache.

use std::path::Path;

use anyhow::{Context, Result};
use hapdef::{HapdefError, Run, Stage};
use hapdef_inverse::InverseError;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// What `make` gives, or what it gave when it was last run with these `inputs`; the folder that it is
/// handed stays beside it.
pub(crate) fn kept<T: Serialize + DeserializeOwned>(
    run: &Run,
    name: &str,
    inputs: &Value,
    make: impl FnOnce(&Path) -> Result<T>,
) -> Result<(T, Stage)> {
    let stage = run.cache.stage(name, inputs, |folder| {
        let value = make(folder).and_then(|made| Ok(serde_json::to_value(made)?));
        value.map_err(|error| typed(name, error))
    })?;
    let made = T::deserialize(&stage.record.info).with_context(|| format!("the stage {name}"))?;
    Ok((made, stage))
}

/// The error of a stage: that of the library where it is one.
fn typed(name: &str, error: anyhow::Error) -> HapdefError {
    let error = match error.downcast::<HapdefError>() {
        Ok(error) => return error,
        Err(error) => error,
    };
    match error.downcast::<InverseError>() {
        Ok(error) => error.into(),
        Err(error) => HapdefError::Stale { path: name.into(), what: format!("{error:#}") },
    }
}
