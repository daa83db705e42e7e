//! What can go wrong in this crate.

use std::path::PathBuf;

/// Why a baseline, a figure or a report could not be made. Each variant carries the numbers found.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReproError {
    /// An argument of a baseline or a search.
    #[error(transparent)]
    Argument(#[from] hapdef_report::ArgumentError),
    /// A mesh that can't be used.
    #[error(transparent)]
    Mesh(#[from] hapdef_mesh::MeshError),
    /// Arguments of k-Max.
    #[error(transparent)]
    KMax(#[from] hapdef_kmax::KMaxError),
    /// A stream or a recording.
    #[error(transparent)]
    Daq(#[from] hapdef_daq::DaqError),
    /// A folder for files that come and go.
    #[error("a temporary folder: {0}")]
    Folder(std::io::Error),
    /// A slice's length is not a whole number of rows.
    #[error("{what}: {found} values are not whole rows of {width}")]
    NotWholeRows {
        /// The argument.
        what: &'static str,
        /// Values in one row.
        width: usize,
        /// Values found.
        found: usize,
    },
    /// A value of a table of samples is NaN or infinite.
    #[error("{what}: row {row}, column {column} is {value}; every value must be finite")]
    RowNotFinite {
        /// The argument.
        what: &'static str,
        /// Row of the sample.
        row: usize,
        /// Column of the value.
        column: usize,
        /// The value found.
        value: f64,
    },
    /// There are fewer samples than the method needs.
    #[error("{what}: {found} samples, at least {needed} are needed")]
    TooFewSamples {
        /// The method.
        what: &'static str,
        /// The least number that works.
        needed: usize,
        /// Samples given.
        found: usize,
    },
    /// All inputs of a linear regression are constant: there is nothing to regress on.
    #[error(
        "linear regression: no direction of the {n_inputs} inputs varies over {n_samples} samples"
    )]
    NoVariance {
        /// Inputs per sample.
        n_inputs: usize,
        /// Samples seen.
        n_samples: usize,
    },
    /// The eigenvalue iteration failed on a finite symmetric matrix.
    #[error("linear regression: eigenvalues of the {n} x {n} correlation matrix did not converge")]
    Eigen {
        /// Order of the matrix.
        n: usize,
    },
    /// A caller's row source failed.
    #[error("reading output row {row}: {source}")]
    Rows {
        /// The row asked for.
        row: usize,
        /// What the source said.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A line of a table does not read as numbers of the known columns.
    #[error("{path}, line {line}: {what}", path = path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1.
        line: usize,
        /// What was expected and found.
        what: String,
    },
    /// A net could not be made, trained or used.
    #[error(transparent)]
    Nets(hapdef_nets::NetsError),
    /// Samples could not be standardised, written or read.
    #[error(transparent)]
    Data(#[from] hapdef_data::DataError),
    /// A limb's table could not be written or read.
    #[error(transparent)]
    Limb(Box<hapdef::HapdefError>),
    /// Contacts could not be estimated, followed, calibrated or conditioned.
    #[error(transparent)]
    Inverse(#[from] hapdef_inverse::InverseError),
    /// A frame does not decide what touches, and its answer says so.
    #[error("the answer is called not identifiable: {why:?}")]
    NotIdentifiable {
        /// Why.
        why: hapdef_inverse::WhyNot,
    },
    /// The conditioner still waits for frames to tare with, and says so.
    #[error("still taring after {frames} frames: a gauge gives no number")]
    Taring {
        /// Frames so far.
        frames: usize,
    },
    /// A search can't go on with the trials it has.
    #[error("{message}")]
    Search {
        /// What was found and what to do.
        message: String,
    },
    /// The person stopped it.
    #[error("stopped; the same command goes on from here")]
    Stopped,
    /// A report differs from its golden values, or is no report.
    #[error("golden values: {what}; if the change is meant, write them again (golden/README.md)")]
    Golden {
        /// Every value that is off.
        what: String,
    },
    /// A results page says something else than the code makes now.
    #[error(
        "the results page is stale; `cargo xtask repro --full --write` makes it again:\n  {}",
        differences.join("\n  ")
    )]
    StaleResults {
        /// What it does not say.
        differences: Vec<String>,
    },
    /// A figure or a report could not be made.
    #[error(transparent)]
    Report(#[from] hapdef_report::ReportError),
}

impl From<hapdef::HapdefError> for ReproError {
    fn from(error: hapdef::HapdefError) -> Self {
        Self::Limb(Box::new(error))
    }
}

/// Number of rows of `width` in a slice of `found` values.
pub(crate) fn whole_rows(
    what: &'static str,
    width: usize,
    found: usize,
) -> Result<usize, ReproError> {
    if width == 0 || !found.is_multiple_of(width) {
        return Err(ReproError::NotWholeRows { what, width, found });
    }
    Ok(found / width)
}

/// Refuses rows of `width` with a NaN or an infinity in them.
pub(crate) fn check_finite(
    what: &'static str,
    width: usize,
    values: &[f32],
) -> Result<(), ReproError> {
    check_finite_from(what, width, 0, values)
}

/// The same for rows that follow `first` others.
pub(crate) fn check_finite_from(
    what: &'static str,
    width: usize,
    first: usize,
    values: &[f32],
) -> Result<(), ReproError> {
    match values.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(index) => Err(ReproError::RowNotFinite {
            what,
            row: first + index / width.max(1),
            column: index % width.max(1),
            value: f64::from(values[index]),
        }),
    }
}
