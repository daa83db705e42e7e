//! The one error type of the crate.

use std::error::Error;
use std::path::PathBuf;

use hapdef_daq::DaqError;
use hapdef_inverse::InverseError;

/// What a sink or an estimator of another crate may fail with.
pub type AnyError = Box<dyn Error + Send + Sync>;

/// What can go wrong between a source of frames and its contacts.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum LiveError {
    #[error(transparent)]
    Inverse(#[from] InverseError),
    #[error(transparent)]
    Daq(#[from] DaqError),
    #[cfg(feature = "nets")]
    #[error(transparent)]
    Net(#[from] hapdef_nets::NetsError),
    #[cfg(feature = "nets")]
    #[error(transparent)]
    KMax(#[from] hapdef_kmax::KMaxError),
    #[cfg(feature = "nets")]
    #[error(
        "the paper's chain: {what} are {found}, expected {expected}: take nets and places of one \
         limb"
    )]
    Chain { what: &'static str, expected: usize, found: usize },
    #[error(
        "the scene {scene} wants the paper's nets, which this build does not run: build hapdef-live \
         with its feature nets, or take Bundle::tracking"
    )]
    NetsLeftOut { scene: String },
    #[error("a frame of {found} readings, but there are {expected} gauges; one reading each")]
    FrameLength { expected: usize, found: usize },
    #[error(
        "expected {expected} gauges, the device has {found} bridges: connect the device of this limb, \
         or give its channels the gauges' names"
    )]
    Channels { expected: usize, found: usize },
    #[error("estimator {name}: {source}")]
    Estimator { name: &'static str, source: AnyError },
    #[error(
        "sink {sink} wants contacts, but there is no estimator: give the builder one, or a bundle"
    )]
    NoEstimator { sink: String },
    #[error("{what} is {found}: expected {expected}")]
    Parameter { what: &'static str, found: f64, expected: &'static str },
    #[error("the thread {name} could not be started: {source}; end other programs")]
    Thread { name: String, source: std::io::Error },
    #[error("the computing thread panicked: report this with the frames that were played")]
    Panicked,
    #[error("{path}: {source}; check the path, or make a bundle: hapdef bundle SCENE -o FILE")]
    BundleFile { path: PathBuf, source: std::io::Error },
    #[error(
        "{file}: not a whole bundle of hapdef: {what}; copy it again, or make it anew: \
         hapdef bundle SCENE -o FILE"
    )]
    NotABundle { file: String, what: String },
    #[error(
        "{file}: a bundle of version {found}, made by hapdef {made_by}; this program reads \
         version {expected}: make it anew with this program, or read it with that one"
    )]
    BundleVersion { file: String, found: u32, expected: u32, made_by: String },
    #[error(
        "{file}: {part} is damaged, its hash is not the one written; copy the file again, or make \
         it anew: hapdef bundle SCENE -o FILE"
    )]
    BundleDamaged { file: String, part: String },
    #[error(
        "the map's {part} would not come back from the bundle bit for bit: give the normals that \
         its skin was made with"
    )]
    NotReproduced { part: &'static str },
    #[error("{address}: {source}; expected tcp:HOST:PORT or unix:PATH that nobody else uses")]
    Listen { address: String, source: std::io::Error },
}

/// Refuses a parameter that is not finite or below 0.
pub(crate) fn check_not_negative(what: &'static str, found: f64) -> Result<(), LiveError> {
    if found.is_finite() && found >= 0.0 {
        return Ok(());
    }
    Err(LiveError::Parameter { what, found, expected: "finite and not below 0" })
}

/// Refuses a parameter that is not finite or not above 0.
pub(crate) fn check_positive(what: &'static str, found: f64) -> Result<(), LiveError> {
    if found.is_finite() && found > 0.0 {
        return Ok(());
    }
    Err(LiveError::Parameter { what, found, expected: "finite and above 0" })
}
