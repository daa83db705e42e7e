//! What is written to a file between steps: datasets, splits, standardisers, manifests.
//!
//! A dataset is one safetensors file with several row-major tensors `[n, width]` over the same n
//! samples, and a JSON [`Manifest`] beside it. [`DatasetWriter`] streams rows to the file block by
//! block and gives the file its name only when it is complete; [`DatasetReader`] reads any rows by
//! their offset. Neither ever holds a whole tensor in memory.
//!
//! Knows nothing of how samples arise or are used.

mod error;
mod manifest;
mod reader;
mod split;
mod standardiser;
mod tensor;
mod writer;

pub use error::DataError;
pub use manifest::{MANIFEST_FORMAT_VERSION, Manifest, manifest_path};
pub use reader::DatasetReader;
pub use split::Split;
pub use standardiser::{Standardiser, StandardiserFit, StandardiserInfo};
pub use tensor::{Element, ElementKind, TensorSpec};
pub use writer::{DatasetInfo, DatasetWriter};
