//! Kinds of which one is meant where none is named.

use serde::Deserialize;
use serde::de::{DeserializeOwned, Deserializer, Error};
use serde_json::{Map, Value};

use super::{ContactRegion, EstimatorSpec, RigMesh};

/// An object whose `field` names its kind, of `kind` where it does not.
fn of_kind<'de, D: Deserializer<'de>, T: DeserializeOwned>(
    from: D,
    field: &str,
    kind: &str,
) -> Result<T, D::Error> {
    let mut fields = Map::deserialize(from)?;
    fields.entry(field).or_insert_with(|| kind.into());
    serde_json::from_value(Value::Object(fields)).map_err(D::Error::custom)
}

pub(super) fn estimator<'de, D: Deserializer<'de>>(from: D) -> Result<EstimatorSpec, D::Error> {
    of_kind(from, "kind", "superposition")
}

pub(super) fn region<'de, D: Deserializer<'de>>(from: D) -> Result<ContactRegion, D::Error> {
    of_kind(from, "rule", "free_skin")
}

pub(super) fn rig_mesh<'de, D: Deserializer<'de>>(from: D) -> Result<RigMesh, D::Error> {
    of_kind(from, "kind", "refined")
}
