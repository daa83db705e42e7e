//! What can go wrong in this crate.

use std::path::PathBuf;

/// Why a baseline, a figure or a report could not be made. Each variant carries the numbers found.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum ReproError {
    #[error(transparent)]
    Argument(#[from] hapdef_report::ArgumentError),
    #[error(transparent)]
    Mesh(#[from] hapdef_mesh::MeshError),
    #[error(transparent)]
    KMax(#[from] hapdef_kmax::KMaxError),
    #[error(transparent)]
    Daq(#[from] hapdef_daq::DaqError),
    #[error("a temporary folder: {0}")]
    Folder(std::io::Error),
    #[error("{what}: {found} values are not whole rows of {width}")]
    NotWholeRows { what: &'static str, width: usize, found: usize },
    #[error("{what}: row {row}, column {column} is {value}; every value must be finite")]
    RowNotFinite { what: &'static str, row: usize, column: usize, value: f64 },
    #[error("{what}: {found} samples, at least {needed} are needed")]
    TooFewSamples { what: &'static str, needed: usize, found: usize },
    #[error(
        "linear regression: no direction of the {n_inputs} inputs varies over {n_samples} samples"
    )]
    NoVariance { n_inputs: usize, n_samples: usize },
    #[error("linear regression: eigenvalues of the {n} x {n} correlation matrix did not converge")]
    Eigen { n: usize },
    #[error("{path}, line {line}: {what}", path = path.display())]
    Line { path: PathBuf, line: usize, what: String },
    #[error(transparent)]
    Nets(hapdef_nets::NetsError),
    #[error(transparent)]
    Data(#[from] hapdef_data::DataError),
    #[error(transparent)]
    Limb(Box<hapdef::HapdefError>),
    #[error(transparent)]
    Inverse(#[from] hapdef_inverse::InverseError),
    #[error("the answer is called not identifiable: {why:?}")]
    NotIdentifiable { why: hapdef_inverse::WhyNot },
    #[error("still taring after {frames} frames: a gauge gives no number")]
    Taring { frames: usize },
    #[error("{message}")]
    Search { message: String },
    #[error("stopped; the same command goes on from here")]
    Stopped,
    #[error("golden values: {what}; if the change is meant, write them again (golden/README.md)")]
    Golden { what: String },
    #[error(
        "the results page is stale; `cargo xtask repro --full --write` makes it again:\n  {}",
        differences.join("\n  ")
    )]
    StaleResults { differences: Vec<String> },
    #[error(transparent)]
    Report(#[from] hapdef_report::ReportError),
}

impl From<hapdef::HapdefError> for ReproError {
    fn from(error: hapdef::HapdefError) -> Self {
        Self::Limb(Box::new(error))
    }
}

/// Refuses a parameter unless it `is_fine`.
pub(crate) fn check_parameter(
    what: &'static str,
    value: f64,
    expected: &'static str,
    is_fine: bool,
) -> Result<(), ReproError> {
    if is_fine {
        return Ok(());
    }
    Err(hapdef_report::ArgumentError::Parameter { what, value, expected }.into())
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
