//! Errors of the pipeline.

use std::path::PathBuf;

use hapdef_daq::DaqError;
use hapdef_data::DataError;
use hapdef_inverse::InverseError;
use hapdef_kmax::KMaxError;
use hapdef_live::LiveError;
use hapdef_mesh::MeshError;
use hapdef_nets::NetsError;
use hapdef_rig::RigError;
use hapdef_sim::SimError;

use crate::scoring::ScoringError;

/// What is wrong with a scene file.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file can't be read.
    #[error("{file}: can't be read: {source}; check the path")]
    Unreadable {
        /// The file.
        file: String,
        /// Why.
        source: std::io::Error,
    },
    /// The file is of another kind.
    #[error("{file}: this is not a scene: expected JSON text, found {found}; {advice}")]
    NotAScene {
        /// The file.
        file: String,
        /// What it is instead.
        found: &'static str,
        /// What to do.
        advice: &'static str,
    },
    /// The file is no JSON, or is cut off.
    #[error("{file}: this is no whole JSON: {source}; correct it there, or write the file again")]
    NoJson {
        /// The file.
        file: String,
        /// What the JSON reader says, with line and column.
        source: serde_json::Error,
    },
    /// The file is JSON, but not of a scene's form.
    #[error("{file}: at {path}: {source}; docs/scene.md lists every field")]
    Form {
        /// The file.
        file: String,
        /// JSON path of the fault.
        path: String,
        /// What the JSON reader says.
        source: serde_json::Error,
    },
    /// A value is out of range.
    #[error("{file}: at {path}: expected {expected}, found {found}; correct this field")]
    Value {
        /// The file.
        file: String,
        /// JSON path of the value.
        path: String,
        /// What it must be.
        expected: &'static str,
        /// What it is.
        found: String,
    },
}

/// What can stop the pipeline.
#[derive(Debug, thiserror::Error)]
pub enum HapdefError {
    /// The scene was refused.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The limb's geometry was refused.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A page or a figure could not be made.
    #[error(transparent)]
    Report(#[from] hapdef_report::ReportError),
    /// The elastic model failed.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// A dataset could not be written or read.
    #[error(transparent)]
    Data(#[from] DataError),
    /// Readings could not be acquired, recorded or played again.
    #[error(transparent)]
    Daq(#[from] DaqError),
    /// A net could not be trained or used.
    #[error(transparent)]
    Net(#[from] NetsError),
    /// The peak search was refused.
    #[error(transparent)]
    KMax(#[from] KMaxError),
    /// Contacts by superposition could not be set up or found.
    #[error(transparent)]
    Inverse(#[from] InverseError),
    /// A frame, a bundle or the runtime was refused.
    #[error(transparent)]
    Live(#[from] LiveError),
    /// Contacts could not be scored.
    #[error(transparent)]
    Scoring(#[from] ScoringError),
    /// The simulated hardware failed.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// A gauge of the scene could not be placed.
    #[error("gauges.sites[{index}] ({name}): {source}")]
    Gauge {
        /// Position in the scene's list.
        index: usize,
        /// The gauge's name.
        name: String,
        /// What is wrong with it.
        source: Box<HapdefError>,
    },
    /// The mount names nothing.
    #[error("mount: {what}; {advice}")]
    NoMount {
        /// What was looked for and not found.
        what: String,
        /// What to do.
        advice: String,
    },
    /// A deck can't be read.
    #[error("{field}: {path}: {source}; the path is relative to the scene file: correct it")]
    NoDeck {
        /// Which of the scene's decks.
        field: &'static str,
        /// The deck.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The calibration that the scene names can't be used.
    #[error(
        "estimator.calibration: {path}: {what}; the path is relative to the scene file: correct it, \
         make the file with `hapdef calibrate`, or leave the field out"
    )]
    Calibration {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// The surface that is drawn for the skin can't be read.
    #[error("geometry.skin_gltf: {0}; the path is relative to the scene file")]
    SkinGltf(#[source] Box<MeshError>),
    /// The surface that is drawn for the skin is not where the limb is.
    #[error(
        "geometry.skin_gltf: {path}: expected vertices within {reach_mm:.1} mm of the skin's nodes, the \
         nearest is {nearest_mm:.1} mm away; it has to be in metres and in the deck's frame"
    )]
    SkinGltfElsewhere {
        /// The file.
        path: PathBuf,
        /// Smallest distance of a vertex from a surface node, mm.
        nearest_mm: f64,
        /// How near one has to be, mm.
        reach_mm: f64,
    },
    /// The rig's own mesh can't be used.
    #[error(
        "rig.mesh.solid_deck: {path}: {source}; mount, contact region and gauges must be found on it \
         as on geometry.solid_deck"
    )]
    RigDeck {
        /// The deck.
        path: PathBuf,
        /// What is wrong with it.
        source: Box<HapdefError>,
    },
    /// The rig's own mesh is the limb's.
    #[error(
        "rig.mesh.solid_deck: {path} is geometry.solid_deck itself, cut as often: the simulated \
         hardware would be the model; name another mesh of the limb, or cut it more often \
         (rig.mesh.refinements)"
    )]
    RigDeckIsLimb {
        /// The deck.
        path: PathBuf,
    },
    /// Neither scene nor deck names a whole material.
    #[error(
        "material: the deck {deck} lacks modulus, Poisson's ratio or density; add a material \
         section to the scene"
    )]
    NoMaterial {
        /// The deck.
        deck: String,
    },
    /// Contacts at the wanted spacing don't fit on the skin.
    #[error(
        "contact.min_spacing_m: found no {n_contacts} of {n_nodes} skin nodes {spacing_mm:.1} mm \
         apart in {tries} tries; lower the spacing or contact.max_contacts"
    )]
    TooCrowded {
        /// Contacts wanted at a time.
        n_contacts: usize,
        /// Nodes to choose from.
        n_nodes: usize,
        /// Spacing wanted, mm.
        spacing_mm: f64,
        /// Tries made.
        tries: usize,
    },
    /// A surface's unit was not said.
    #[error("{path}: the file doesn't say its unit; it is {guess}: say it with --unit")]
    UnitNotStated {
        /// The file.
        path: PathBuf,
        /// Its length, and the units that fit.
        guess: hapdef_mesh::UnitGuess,
    },
    /// The wall doesn't fit inside its skin.
    #[error("{0}; or, if the skin may stand for the middle of the wall, say so (--side middle)")]
    WallFolds(#[source] MeshError),
    /// Gauges don't fit on the inner side of a shell.
    #[error(
        "{n_gauges} gauges are wanted, but only {n_found} fit: of {n_candidates} nodes clear of \
         the mount and of rims, {n_passed_over} were passed over because the footprint doesn't lie \
         on the wall; ask for fewer gauges, a shorter edge or a shorter mount"
    )]
    TooFewGaugeSites {
        /// Gauges wanted.
        n_gauges: usize,
        /// Gauges placed.
        n_found: usize,
        /// Nodes to choose from.
        n_candidates: usize,
        /// Nodes where a gauge was refused.
        n_passed_over: usize,
    },
    /// A shell and a solid have no place in common.
    #[error(
        "none of {n_places} places on the solid's skin lies on the shell, off its mount: are both \
         in metres and in the same place?"
    )]
    NothingToPress {
        /// Places looked at.
        n_places: usize,
    },
    /// A file of the pipeline could not be written or read.
    #[error("{path}: {source}; check the disk's space and rights, or run again with another --out")]
    File {
        /// The file or folder.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file that an earlier stage wrote does not hold what it should.
    #[error("{path}: {what}; delete it and run again")]
    Stale {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// The worker threads could not be started.
    #[error("starting the worker threads: {0}; try fewer with --threads")]
    Threads(rayon::ThreadPoolBuildError),
    /// The person stopped the run.
    #[error("stopped at {stage}; run the same command again and it goes on from there")]
    Stopped {
        /// The stage in which it stopped.
        stage: String,
    },
}

impl HapdefError {
    /// Says which file or folder an I/O error concerns.
    pub fn file(path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.into();
        move |source| Self::File { path, source }
    }
}
