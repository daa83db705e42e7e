//! The JSON of a glTF file, parsed and checked as far as all later steps rely on it.
//!
//! Only the `gltf` crate's JSON types are used: its accessor readers panic on hostile strides and
//! types, and its importer follows any path. Its types also cut integers to 32 bits without a
//! word, so that index 2³² would be read as 0; such numbers are refused here first.

use gltf::json::{Root, Value};

use super::GltfFault;

/// Extensions that a file may require although this reader ignores them: they change how a
/// surface looks, not where it is.
const APPEARANCE_EXTENSIONS: [&str; 4] =
    ["KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_"];

/// Free-form or floating-point properties, where a large number is no index and no size.
const FREE_PROPERTIES: [&str; 8] =
    ["extras", "extensions", "min", "max", "matrix", "translation", "rotation", "scale"];

/// Parses `json` and checks version, required extensions and the range of integers.
pub(super) fn parse(json: &[u8]) -> Result<Root, GltfFault> {
    let as_fault = |cause| GltfFault::Json { cause };
    let value: Value = gltf::json::deserialize::from_slice(json).map_err(as_fault)?;
    check_integers(&value, &mut String::new())?;
    let root: Root = gltf::json::deserialize::from_slice(json).map_err(as_fault)?;
    check_version(&root)?;
    check_required_extensions(&root)?;
    Ok(root)
}

/// Refuses integers above 32 bits; the depth is bounded by the parser's own limit of 128.
fn check_integers(value: &Value, place: &mut String) -> Result<(), GltfFault> {
    match value {
        Value::Number(number) => match number.as_u64() {
            Some(found) if u32::try_from(found).is_err() => {
                Err(GltfFault::JsonNumber { place: place.clone(), found })
            }
            _ => Ok(()),
        },
        Value::Array(items) => items
            .iter()
            .enumerate()
            .try_for_each(|(i, item)| check_below(item, place, &format!("[{i}]"))),
        Value::Object(properties) => properties
            .iter()
            .filter(|(key, _)| !FREE_PROPERTIES.contains(&key.as_str()))
            .try_for_each(|(key, item)| {
                let dot = if place.is_empty() { "" } else { "." };
                check_below(item, place, &format!("{dot}{key}"))
            }),
        _ => Ok(()),
    }
}

fn check_below(value: &Value, place: &mut String, step: &str) -> Result<(), GltfFault> {
    let length = place.len();
    place.push_str(step);
    check_integers(value, place)?;
    place.truncate(length);
    Ok(())
}

/// Version 2.x without a minimum version above 2.0: specification, section 3.2.
fn check_version(root: &Root) -> Result<(), GltfFault> {
    let minor_is_free = root.asset.version.strip_prefix("2.").is_some_and(is_number);
    match root.asset.min_version.as_deref() {
        None | Some("2.0") if minor_is_free => Ok(()),
        None | Some("2.0") => Err(GltfFault::AssetVersion { found: root.asset.version.clone() }),
        Some(minimum) => Err(GltfFault::AssetVersion { found: format!("minVersion {minimum}") }),
    }
}

fn is_number(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit())
}

fn check_required_extensions(root: &Root) -> Result<(), GltfFault> {
    let harmless = |name: &str| APPEARANCE_EXTENSIONS.iter().any(|prefix| name.starts_with(prefix));
    match root.extensions_required.iter().find(|name| !harmless(name)) {
        None => Ok(()),
        Some(name) => Err(GltfFault::RequiredExtension { name: name.clone() }),
    }
}
