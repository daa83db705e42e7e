//! What can go wrong while the simulated hardware is built.

use hapdef_mesh::MeshError;
use hapdef_sim::SimError;

/// Failures of the simulated hardware.
#[derive(Debug, thiserror::Error)]
pub enum RigError {
    /// The perturbed limb's mesh was refused.
    #[error("the rig's mesh: {0}")]
    Mesh(#[from] MeshError),
    /// The perturbed limb could not be solved.
    #[error("the rig's elastic model: {0}")]
    Sim(#[from] SimError),
    /// A parameter lies outside its range.
    #[error(
        "rig parameter {name}: expected {expected}, found {found}; correct the scene's rig section"
    )]
    Parameter {
        /// Name of the parameter.
        name: &'static str,
        /// The range it must lie in.
        expected: &'static str,
        /// The value given.
        found: f64,
    },
    /// No direction was found in which a gauge could be misplaced and stay on its wall.
    #[error(
        "gauge {gauge} can't be shifted by {shift_mm:.2} mm in any of {tried} directions without \
         leaving its wall; place it farther from the rim or lower rig.misplacement.shift_m"
    )]
    NoRoomForGauge {
        /// Index of the gauge.
        gauge: usize,
        /// The shift asked for, mm.
        shift_mm: f64,
        /// Directions tried.
        tried: usize,
    },
    /// A press beside the rig's skin.
    #[error(
        "a press at {at_m:?} m is {off_mm:.2} mm off the rig's skin, expected at most {most_mm:.2}: \
         is the rig's mesh of the same limb, in the same place?"
    )]
    OffSkin {
        /// Where, m.
        at_m: [f64; 3],
        /// Distance from the skin, mm.
        off_mm: f64,
        /// Distance allowed, mm.
        most_mm: f64,
    },
    /// Too few pairs of contact sites lie within the wanted distance of each other.
    #[error(
        "found {found} of {wanted} press pairs {min_mm:.0}–{max_mm:.0} mm apart; enlarge the \
         contact region or lower the number of pairs"
    )]
    TooFewPairs {
        /// Pairs found.
        found: usize,
        /// Pairs wanted.
        wanted: usize,
        /// Smallest distance, mm.
        min_mm: f64,
        /// Largest distance, mm.
        max_mm: f64,
    },
    /// A surface that can't be pressed.
    #[cfg(feature = "live")]
    #[error("the limb's surface: {what}; make it from the limb's skin")]
    Surface {
        /// What is wrong with it.
        what: &'static str,
    },
    /// A script that is no JSON of the right form.
    #[cfg(feature = "live")]
    #[error("at {path}: {source}; docs/rig.md lists every field")]
    ScriptForm {
        /// JSON path of the fault.
        path: String,
        /// What the JSON reader says.
        source: serde_json::Error,
    },
    /// A value of a script is out of range or out of order.
    #[cfg(feature = "live")]
    #[error("at {path}: expected {expected}, found {found}; correct this field")]
    Script {
        /// JSON path of the value.
        path: String,
        /// What it must be.
        expected: &'static str,
        /// What it is.
        found: String,
    },
    /// A fault that can't be made.
    #[cfg(feature = "live")]
    #[error("fault {found:?}: expected {expected}")]
    Fault {
        /// What was asked for.
        found: String,
        /// What can be.
        expected: &'static str,
    },
    /// A port can't be had.
    #[cfg(feature = "live")]
    #[error("{port}: {source}; choose another one")]
    Port {
        /// Which.
        port: String,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// HDP1 has no room for the device.
    #[cfg(feature = "live")]
    #[error(transparent)]
    Daq(#[from] hapdef_daq::DaqError),
}
