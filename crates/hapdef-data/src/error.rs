//! The one error type of the crate.

use std::path::PathBuf;

use thiserror::Error;

use crate::tensor::ElementKind;

/// Why a dataset, a manifest or a standardiser could not be written, read or applied.
#[derive(Debug, Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum DataError {
    #[error("cannot {action} {}: {source}", path.display())]
    Io { action: &'static str, path: PathBuf, source: std::io::Error },
    #[error(
        "{} is not a readable safetensors file: {detail}; write the dataset anew",
        path.display()
    )]
    Header { path: PathBuf, detail: String },
    #[error(
        "{} holds {got} bytes where its header promises {expected}: it is cut off or damaged; \
         write the dataset anew",
        path.display()
    )]
    FileLength { path: PathBuf, expected: u64, got: u64 },
    #[error(
        "tensor \"{tensor}\" in {} has shape {shape:?}; expected [{n}, width ≥ 1] of f32 or i32",
        path.display()
    )]
    Shape { path: PathBuf, tensor: String, shape: Vec<usize>, n: usize },
    #[error("{} has no tensor \"{tensor}\"; it has {available:?}", path.display())]
    NoSuchTensor { path: PathBuf, tensor: String, available: Vec<String> },
    #[error("{}: tensor \"{tensor}\" is named twice", path.display())]
    TensorNamedTwice { path: PathBuf, tensor: String },
    #[error("tensor \"{tensor}\" in {} holds {held}, not {asked}", path.display())]
    ElementKind { path: PathBuf, tensor: String, held: ElementKind, asked: ElementKind },
    #[error(
        "tensor \"{tensor}\" in {}: a slice of {got} values where {expected} were expected \
         (rows of {width})",
        path.display()
    )]
    SliceLength { path: PathBuf, tensor: String, width: usize, expected: usize, got: usize },
    #[error("tensor \"{tensor}\" in {} has {n} rows; row {row} was asked for", path.display())]
    RowOutOfRange { path: PathBuf, tensor: String, row: usize, n: usize },
    #[error(
        "tensor \"{tensor}\" in {}: row {row}, column {column} is {value}; find out which step \
         made it, and write the dataset anew",
        path.display()
    )]
    NotFinite { path: PathBuf, tensor: String, row: usize, column: usize, value: f32 },
    #[error(
        "tensor \"{tensor}\" of {} got {written} of {n} rows; the unfinished file was removed",
        path.display()
    )]
    MissingRows { path: PathBuf, tensor: String, written: usize, n: usize },
    #[error("{} is not a valid manifest: {source}", path.display())]
    Manifest { path: PathBuf, source: serde_json::Error },
    #[error(
        "{} has format version {found}, this program reads {known}; write the dataset anew",
        path.display()
    )]
    FormatVersion { path: PathBuf, found: u32, known: u32 },
    #[error("{} does not describe {}: {detail}", manifest.display(), dataset.display())]
    ManifestMismatch { manifest: PathBuf, dataset: PathBuf, detail: String },
    #[error("{n} samples cannot be split 60/20/20; at least 5 are needed")]
    TooFewSamples { n: usize },
    #[error("a slice of {got} values is not a whole number of rows of {width}")]
    StandardiserWidth { width: usize, got: usize },
    #[error("standardiser: row {row}, column {column} is {value}")]
    StandardiserInput { row: u64, column: usize, value: f32 },
    #[error("a standardiser of {width} columns needs at least one row, got {n_rows}")]
    StandardiserEmpty { width: usize, n_rows: u64 },
}

impl DataError {
    pub(crate) fn io(
        action: &'static str,
        path: &std::path::Path,
    ) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self::Io { action, path, source }
    }
}
