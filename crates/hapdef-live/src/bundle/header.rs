//! The JSON header of a bundle.

use std::collections::BTreeMap;

use safetensors::Dtype;
use serde::{Deserialize, Serialize};

use super::{BUNDLE_VERSION, BundleInfo};

/// Name of the one metadata entry: the header's hash, a space, the header.
pub(super) const ENTRY: &str = "hapdef.bundle";

/// Tensors.
pub(super) const SCENE: &str = "scene.json";
pub(super) const CALIBRATION: &str = "calibration.json";
pub(super) const NODES: &str = "skin.nodes_m";
pub(super) const OUTWARD: &str = "skin.outward";
pub(super) const FACES: &str = "skin.faces";
pub(super) const FORBIDDEN: &str = "skin.forbidden";
pub(super) const MAP: &str = "map.ue_per_n";
pub(super) const SITE_ERROR: &str = "map.site_error";
pub(super) const GIVEN: &str = "loads.given_ue";
pub(super) const LOADS: &str = "loads.response_ue";
pub(super) const LOAD_SDS: &str = "loads.sd";
pub(super) const MODE: &str = "mode.";
pub(super) const NET: &str = "net.";

/// What the tensors are, and their hashes.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Header {
    pub(super) version: u32,
    pub(super) info: BundleInfo,
    /// Signals of the loads that are measured, in words.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) signals: Vec<String>,
    pub(super) modes: Vec<ModeHeader>,
    /// blake3 of each tensor's type, shape and bytes, by name.
    pub(super) hashes: BTreeMap<String, String>,
}

/// What is said of a mode beside its values.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ModeHeader {
    /// Each gauge has an amplitude of its own.
    pub(super) is_each_gauge: bool,
    pub(super) prior_sd: f64,
}

/// The part of a header that every version has.
#[derive(Debug, Deserialize)]
pub(super) struct AnyHeader {
    pub(super) version: u32,
    #[serde(default)]
    pub(super) info: AnyInfo,
}

/// See [`AnyHeader`].
#[derive(Debug, Default, Deserialize)]
pub(super) struct AnyInfo {
    #[serde(default)]
    pub(super) made_by: String,
}

impl Header {
    pub(super) fn new(
        info: BundleInfo,
        signals: Vec<String>,
        modes: Vec<ModeHeader>,
        hashes: BTreeMap<String, String>,
    ) -> Self {
        Self { version: BUNDLE_VERSION, info, signals, modes, hashes }
    }
}

/// blake3 as it stands in a header.
pub(super) fn hash(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

/// The same of a tensor with its type and shape.
pub(super) fn tensor_hash(dtype: Dtype, shape: &[usize], bytes: &[u8]) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(format!("{dtype:?} {shape:?} ").as_bytes());
    hasher.update(bytes);
    hasher.finalize().to_hex().to_string()
}
