//! The one error type of the crate.

use std::path::PathBuf;

use thiserror::Error;

use crate::tensor::ElementKind;

/// Why a dataset, a manifest or a standardiser could not be written, read or applied.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DataError {
    /// The operating system refused.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// What was tried.
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The file does not begin with a safetensors header.
    #[error(
        "{} is not a readable safetensors file: {detail}; write the dataset anew",
        path.display()
    )]
    Header {
        /// The file.
        path: PathBuf,
        /// What is wrong with the header.
        detail: String,
    },
    /// The file is shorter or longer than its header says.
    #[error(
        "{} holds {got} bytes where its header promises {expected}: it is cut off or damaged; \
         write the dataset anew",
        path.display()
    )]
    FileLength {
        /// The file.
        path: PathBuf,
        /// Bytes that the header promises.
        expected: u64,
        /// Bytes that the file has.
        got: u64,
    },
    /// A tensor that is not a dataset's: not `[n, width]`, or another n than the first tensor's.
    #[error(
        "tensor \"{tensor}\" in {} has shape {shape:?}; expected [{n}, width ≥ 1] of f32 or i32",
        path.display()
    )]
    Shape {
        /// The file.
        path: PathBuf,
        /// Name of the tensor.
        tensor: String,
        /// Its shape.
        shape: Vec<usize>,
        /// Number of samples of the dataset.
        n: usize,
    },
    /// The dataset has no tensor of that name.
    #[error("{} has no tensor \"{tensor}\"; it has {available:?}", path.display())]
    NoSuchTensor {
        /// The file.
        path: PathBuf,
        /// Name asked for.
        tensor: String,
        /// Names there are.
        available: Vec<String>,
    },
    /// The dataset has two tensors of the same name.
    #[error("{}: tensor \"{tensor}\" is named twice", path.display())]
    TensorNamedTwice {
        /// The file.
        path: PathBuf,
        /// The name.
        tensor: String,
    },
    /// The tensor holds another kind of number than was asked for.
    #[error("tensor \"{tensor}\" in {} holds {held}, not {asked}", path.display())]
    ElementKind {
        /// The file.
        path: PathBuf,
        /// Name of the tensor.
        tensor: String,
        /// What the tensor holds.
        held: ElementKind,
        /// What was written or asked for.
        asked: ElementKind,
    },
    /// A slice that is not a whole number of rows, or not as many as were asked for.
    #[error(
        "tensor \"{tensor}\" in {}: a slice of {got} values where {expected} were expected \
         (rows of {width})",
        path.display()
    )]
    SliceLength {
        /// The file.
        path: PathBuf,
        /// Name of the tensor.
        tensor: String,
        /// Values in a row.
        width: usize,
        /// Values expected.
        expected: usize,
        /// Values given.
        got: usize,
    },
    /// Rows past the end.
    #[error("tensor \"{tensor}\" in {} has {n} rows; row {row} was asked for", path.display())]
    RowOutOfRange {
        /// The file.
        path: PathBuf,
        /// Name of the tensor.
        tensor: String,
        /// The row.
        row: usize,
        /// Rows there are.
        n: usize,
    },
    /// A value that is NaN or infinite.
    #[error(
        "tensor \"{tensor}\" in {}: row {row}, column {column} is {value}; find out which step \
         made it, and write the dataset anew",
        path.display()
    )]
    NotFinite {
        /// The file.
        path: PathBuf,
        /// Name of the tensor.
        tensor: String,
        /// Row of the value.
        row: usize,
        /// Column of the value.
        column: usize,
        /// The value.
        value: f32,
    },
    /// A dataset was finished before all its rows were written.
    #[error(
        "tensor \"{tensor}\" of {} got {written} of {n} rows; the unfinished file was removed",
        path.display()
    )]
    MissingRows {
        /// The file that would have been.
        path: PathBuf,
        /// Name of the tensor.
        tensor: String,
        /// Rows written.
        written: usize,
        /// Rows promised.
        n: usize,
    },
    /// A manifest that is not valid JSON of the known fields.
    #[error("{} is not a valid manifest: {source}", path.display())]
    Manifest {
        /// The file.
        path: PathBuf,
        /// Line, column and reason.
        source: serde_json::Error,
    },
    /// A manifest of another format version.
    #[error(
        "{} has format version {found}, this program reads {known}; write the dataset anew",
        path.display()
    )]
    FormatVersion {
        /// The file.
        path: PathBuf,
        /// Version found.
        found: u32,
        /// Version known.
        known: u32,
    },
    /// Manifest and dataset disagree.
    #[error("{} does not describe {}: {detail}", manifest.display(), dataset.display())]
    ManifestMismatch {
        /// The manifest.
        manifest: PathBuf,
        /// The dataset.
        dataset: PathBuf,
        /// What differs.
        detail: String,
    },
    /// Too few samples to split.
    #[error("{n} samples cannot be split 60/20/20; at least 5 are needed")]
    TooFewSamples {
        /// Samples given.
        n: usize,
    },
    /// Rows of another width than the standardiser's, or means and deviations of unlike length.
    #[error("a slice of {got} values is not a whole number of rows of {width}")]
    StandardiserWidth {
        /// Columns of the standardiser.
        width: usize,
        /// Values given.
        got: usize,
    },
    /// A standardiser cannot learn from a value that is NaN or infinite, or from no rows.
    #[error("standardiser: row {row}, column {column} is {value}")]
    StandardiserInput {
        /// Row of the value, counted from the first row given.
        row: u64,
        /// Column of the value.
        column: usize,
        /// The value.
        value: f32,
    },
    /// A standardiser was asked for before any row was given, or with no columns.
    #[error("a standardiser of {width} columns needs at least one row, got {n_rows}")]
    StandardiserEmpty {
        /// Columns.
        width: usize,
        /// Rows given.
        n_rows: u64,
    },
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
