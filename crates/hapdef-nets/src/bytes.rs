//! A net as the bytes of one file: all that its use takes, and nothing of its training.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::checkpoint::{mlp_of, weight_shapes, weight_tensors};
use crate::error::NetsError;
use crate::files::{NamedTensor, metadata_entry, tensor_bytes, tensors_of};
use crate::net::{Net, Scale};
use crate::spec::MlpSpec;

/// Version of the form that is written and read here.
pub const NET_FORMAT_VERSION: u32 = 1;

/// Name of the one metadata entry.
const ENTRY: &str = "hapdef.net";

/// The metadata entry.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct NetEntry {
    format_version: u32,
    spec: MlpSpec,
}

impl Net {
    /// The net as one safetensors file; the same net is always the same bytes.
    ///
    /// Fails if the file can't be made.
    pub fn to_bytes(&self) -> Result<Vec<u8>, NetsError> {
        let path = Path::new("net");
        let entry =
            NetEntry { format_version: NET_FORMAT_VERSION, spec: self.mlp().spec().clone() };
        let json = serde_json::to_string(&entry).map_err(json_of(path))?;
        let (input, output) = (self.input_scale(), self.output_scale());
        let scales = [input.mean(), input.std(), output.mean(), output.std()];
        let named = scale_shapes(self.mlp().spec()).into_iter().zip(scales);
        let scales = named.map(|((name, shape), values)| NamedTensor { name, shape, values });
        let mut tensors = weight_tensors(self.mlp());
        tensors.extend(scales);
        tensor_bytes(path, &tensors, Some((ENTRY, json)))
    }

    /// The net of the bytes of `file`, bit for bit.
    ///
    /// Fails on bytes that are not those of a whole net, and on another version.
    pub fn from_bytes(bytes: &[u8], file: &str) -> Result<Self, NetsError> {
        let path = Path::new(file);
        let spec = spec_of(path, bytes)?;
        let mut scales = tensors_of(path, bytes, &scale_shapes(&spec))?;
        let mut next = || {
            let std = scales.pop().unwrap_or_default();
            Scale::new(scales.pop().unwrap_or_default(), std)
        };
        let (output, input) = (next()?, next()?);
        let weights = tensors_of(path, bytes, &weight_shapes(&spec))?;
        Self::new(mlp_of(&spec, weights)?, input, output)
    }
}

/// Of inputs, then outputs: means, then deviations.
fn scale_shapes(spec: &MlpSpec) -> Vec<(String, Vec<usize>)> {
    let sides = [("input", spec.inputs), ("output", spec.outputs)];
    let of_side = |(side, width): (&str, usize)| {
        ["mean", "std"].map(|what| (format!("{side}.{what}"), vec![width]))
    };
    sides.into_iter().flat_map(of_side).collect()
}

fn spec_of(path: &Path, bytes: &[u8]) -> Result<MlpSpec, NetsError> {
    let json = metadata_entry(path, bytes, ENTRY)?
        .ok_or_else(|| NetsError::NotANet { path: path.to_path_buf(), entry: ENTRY })?;
    let entry: NetEntry = serde_json::from_str(&json).map_err(json_of(path))?;
    if entry.format_version != NET_FORMAT_VERSION {
        return Err(NetsError::FormatVersion {
            path: path.to_path_buf(),
            found: entry.format_version,
            known: NET_FORMAT_VERSION,
        });
    }
    entry.spec.check()?;
    Ok(entry.spec)
}

fn json_of(path: &Path) -> impl FnOnce(serde_json::Error) -> NetsError {
    let path = path.to_path_buf();
    move |source| NetsError::Json { path, source }
}
