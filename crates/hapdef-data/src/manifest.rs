//! The JSON file beside a dataset that says what it is and how it came about.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::error::DataError;
use crate::reader::DatasetReader;
use crate::split::Split;
use crate::tensor::TensorSpec;

/// Version of the manifest's fields that this crate writes and reads.
pub const MANIFEST_FORMAT_VERSION: u32 = 1;

/// What a dataset is and how it came about. Unknown fields are refused on reading.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// [`MANIFEST_FORMAT_VERSION`] at the time of writing.
    pub format_version: u32,
    /// What the samples are, for example `"double-contact"`.
    pub kind: String,
    /// Seed of all random choices.
    pub seed: u64,
    /// Hash of the scene that the samples were made from.
    pub scene_hash: String,
    /// Versions of the crates that made the samples, by name.
    pub crate_versions: BTreeMap<String, String>,
    /// The tensors with widths and units, in the file's order.
    pub tensors: Vec<TensorSpec>,
    /// Number of samples.
    pub n: usize,
    /// Which samples train, validate and test.
    pub split: Split,
    /// The command line that made the dataset.
    pub created_by: String,
}

/// Where the manifest of a dataset lies: the same name with the extension `json`.
pub fn manifest_path(dataset: &Path) -> PathBuf {
    dataset.with_extension("json")
}

impl Manifest {
    /// Writes the manifest beside `dataset`, under a temporary name first.
    pub fn write(&self, dataset: &Path) -> Result<(), DataError> {
        let path = manifest_path(dataset);
        let partial = path.with_extension("json.partial");
        let mut json = serde_json::to_vec_pretty(self)
            .map_err(|source| DataError::Manifest { path: path.clone(), source })?;
        json.push(b'\n');
        fs::write(&partial, json).map_err(DataError::io("write", &partial))?;
        fs::rename(&partial, &path).map_err(DataError::io("rename", &path))
    }

    /// Reads the manifest beside `dataset`. Fails on fields that are missing or unknown and on
    /// another format version.
    pub fn read(dataset: &Path) -> Result<Self, DataError> {
        let path = manifest_path(dataset);
        let json = fs::read(&path).map_err(DataError::io("read", &path))?;
        let invalid = |source| DataError::Manifest { path: path.clone(), source };
        let version: VersionOnly = serde_json::from_slice(&json).map_err(invalid)?;
        if version.format_version != MANIFEST_FORMAT_VERSION {
            return Err(DataError::FormatVersion {
                path,
                found: version.format_version,
                known: MANIFEST_FORMAT_VERSION,
            });
        }
        serde_json::from_slice(&json).map_err(invalid)
    }

    /// Fails unless the open dataset has this manifest's samples, split and tensors.
    pub fn check(&self, dataset: &DatasetReader) -> Result<(), DataError> {
        let mismatch = |detail| DataError::ManifestMismatch {
            manifest: manifest_path(dataset.path()),
            dataset: dataset.path().to_path_buf(),
            detail,
        };
        if self.n != dataset.n() || self.split != Split::of(self.n)? {
            return Err(mismatch(format!(
                "{} samples, split {:?}, against {} samples in the file",
                self.n,
                self.split,
                dataset.n()
            )));
        }
        let described = self.tensors.iter().map(|t| t.name.as_str());
        if !described.eq(dataset.tensor_names()) {
            let held: Vec<_> = dataset.tensor_names().collect();
            return Err(mismatch(format!("the file holds the tensors {held:?}")));
        }
        for spec in &self.tensors {
            let held = (dataset.kind(&spec.name)?, dataset.width(&spec.name)?);
            if held != (spec.kind, spec.width) {
                let (kind, width) = held;
                let name = &spec.name;
                return Err(mismatch(format!("\"{name}\" is {kind} of width {width} in the file")));
            }
        }
        Ok(())
    }
}

/// Enough of a manifest to tell its version, whatever else it holds.
#[derive(Deserialize)]
struct VersionOnly {
    format_version: u32,
}
