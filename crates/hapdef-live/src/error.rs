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
pub enum LiveError {
    /// Contacts by superposition could not be set up or found.
    #[error(transparent)]
    Inverse(#[from] InverseError),
    /// The acquisition could not be started.
    #[error(transparent)]
    Daq(#[from] DaqError),
    /// A net of the paper's chain could not be read or used.
    #[cfg(feature = "nets")]
    #[error(transparent)]
    Net(#[from] hapdef_nets::NetsError),
    /// Peaks of a map could not be looked for.
    #[cfg(feature = "nets")]
    #[error(transparent)]
    KMax(#[from] hapdef_kmax::KMaxError),
    /// Parts of the paper's chain that don't belong together.
    #[cfg(feature = "nets")]
    #[error(
        "the paper's chain: {what} are {found}, expected {expected}: take nets and places of one \
         limb"
    )]
    Chain {
        /// What has another number.
        what: &'static str,
        /// What the rest of the chain has.
        expected: usize,
        /// What it has.
        found: usize,
    },
    /// A bundle with nets for a build that runs none.
    #[error(
        "the scene {scene} wants the paper's nets, which this build does not run: build hapdef-live \
         with its feature nets, or take Bundle::tracking"
    )]
    NetsLeftOut {
        /// Name of the scene.
        scene: String,
    },
    /// A frame has another number of readings than the estimator has gauges.
    #[error("a frame of {found} readings, but there are {expected} gauges; one reading each")]
    FrameLength {
        /// Gauges.
        expected: usize,
        /// Readings.
        found: usize,
    },
    /// A device has another number of gauges than the limb.
    #[error(
        "expected {expected} gauges, the device has {found} bridges: connect the device of this limb, \
         or give its channels the gauges' names"
    )]
    Channels {
        /// Gauges.
        expected: usize,
        /// Bridges.
        found: usize,
    },
    /// An estimator of another crate failed.
    #[error("estimator {name}: {source}")]
    Estimator {
        /// Its name.
        name: &'static str,
        /// What it says.
        source: AnyError,
    },
    /// A sink wants contacts, and nothing was given that finds them.
    #[error(
        "sink {sink} wants contacts, but there is no estimator: give the builder one, or a bundle"
    )]
    NoEstimator {
        /// The sink.
        sink: String,
    },
    /// A value of [`crate::LiveParams`] out of range.
    #[error("{what} is {found}: expected {expected}")]
    Parameter {
        /// Which value.
        what: &'static str,
        /// What it is.
        found: f64,
        /// What it must be.
        expected: &'static str,
    },
    /// No thread could be started.
    #[error("the thread {name} could not be started: {source}; end other programs")]
    Thread {
        /// Which thread.
        name: String,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// The computing thread ended by a panic.
    #[error("the computing thread panicked: report this with the frames that were played")]
    Panicked,
    /// A bundle can't be read.
    #[error("{path}: {source}; check the path, or make a bundle: hapdef bundle SCENE -o FILE")]
    BundleFile {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file that is no bundle, or no whole one.
    #[error(
        "{file}: not a whole bundle of hapdef: {what}; copy it again, or make it anew: \
         hapdef bundle SCENE -o FILE"
    )]
    NotABundle {
        /// The file.
        file: String,
        /// What is wrong with it.
        what: String,
    },
    /// A bundle of another version.
    #[error(
        "{file}: a bundle of version {found}, made by hapdef {made_by}; this program reads \
         version {expected}: make it anew with this program, or read it with that one"
    )]
    BundleVersion {
        /// The file.
        file: String,
        /// Its version.
        found: u32,
        /// The version that is read here.
        expected: u32,
        /// Version of the program that made it.
        made_by: String,
    },
    /// A part of a bundle that is not as it was written.
    #[error(
        "{file}: {part} is damaged, its hash is not the one written; copy the file again, or make \
         it anew: hapdef bundle SCENE -o FILE"
    )]
    BundleDamaged {
        /// The file.
        file: String,
        /// The part.
        part: String,
    },
    /// A map that can't be made again from what the bundle keeps.
    #[error(
        "the map's {part} would not come back from the bundle bit for bit: give the normals that \
         its skin was made with"
    )]
    NotReproduced {
        /// What differs.
        part: &'static str,
    },
    /// An address that nothing can listen at.
    #[error("{address}: {source}; expected tcp:HOST:PORT or unix:PATH that nobody else uses")]
    Listen {
        /// The address.
        address: String,
        /// What the operating system says.
        source: std::io::Error,
    },
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
