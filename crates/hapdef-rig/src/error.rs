//! What can go wrong while the simulated hardware is built.

use hapdef_mesh::MeshError;
#[cfg(feature = "solve")]
use hapdef_sim::SimError;

/// Failures of the simulated hardware.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum RigError {
    #[error("the rig's mesh: {0}")]
    Mesh(#[from] MeshError),
    #[cfg(feature = "solve")]
    #[error("the rig's elastic model: {0}")]
    Sim(#[from] SimError),
    #[error(
        "rig parameter {name}: expected {expected}, found {found}; correct the scene's rig section"
    )]
    Parameter { name: &'static str, expected: &'static str, found: f64 },
    #[error(
        "gauge {gauge} can't be shifted by {shift_mm:.2} mm in any of {tried} directions without \
         leaving its wall; place it farther from the rim or lower rig.misplacement.shift_m"
    )]
    NoRoomForGauge { gauge: usize, shift_mm: f64, tried: usize },
    #[error(
        "a press at {at_m:?} m is {off_mm:.2} mm off the rig's skin, expected at most {most_mm:.2}: \
         is the rig's mesh of the same limb, in the same place?"
    )]
    OffSkin { at_m: [f64; 3], off_mm: f64, most_mm: f64 },
    #[error(
        "found {found} of {wanted} press pairs {min_mm:.0}–{max_mm:.0} mm apart; enlarge the \
         contact region or lower the number of pairs"
    )]
    TooFewPairs { found: usize, wanted: usize, min_mm: f64, max_mm: f64 },
    #[cfg(feature = "live")]
    #[error("the limb's surface: {what}; make it from the limb's skin")]
    Surface { what: &'static str },
    #[cfg(feature = "live")]
    #[error("at {path}: {source}; docs/rig.md lists every field")]
    ScriptForm { path: String, source: serde_json::Error },
    #[cfg(feature = "live")]
    #[error("at {path}: expected {expected}, found {found}; correct this field")]
    Script { path: String, expected: &'static str, found: String },
    #[cfg(feature = "live")]
    #[error("fault {found:?}: expected {expected}")]
    Fault { found: String, expected: &'static str },
    #[cfg(feature = "live")]
    #[error("{port}: {source}; choose another one")]
    Port { port: String, source: std::io::Error },
    #[cfg(feature = "live")]
    #[error(transparent)]
    Daq(#[from] hapdef_daq::DaqError),
}
