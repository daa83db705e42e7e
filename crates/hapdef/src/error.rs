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
use crate::source_args::SourceArgError;

/// What is wrong with a scene file.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum SceneError {
    #[error("{file}: can't be read: {source}; check the path")]
    Unreadable { file: String, source: std::io::Error },
    #[error("{file}: this is not a scene: expected JSON text, found {found}; {advice}")]
    NotAScene { file: String, found: &'static str, advice: &'static str },
    #[error("{file}: this is no whole JSON: {source}; correct it there, or write the file again")]
    NoJson { file: String, source: serde_json::Error },
    #[error("{file}: at {path}: {source}; docs/scene.md lists every field")]
    Form { file: String, path: String, source: serde_json::Error },
    #[error("{file}: at {path}: expected {expected}, found {found}; correct this field")]
    Value { file: String, path: String, expected: &'static str, found: String },
}

/// What is wrong with a robot file.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum RobotError {
    #[error("{file}: can't be read: {source}; check the path")]
    Unreadable { file: String, source: std::io::Error },
    #[error("{file}: this is no whole JSON: {source}; correct it there, or write the file again")]
    NoJson { file: String, source: serde_json::Error },
    #[error("{file}: at {path}: {source}; docs/live.md lists every field of a robot file")]
    Form { file: String, path: String, source: serde_json::Error },
    #[error("{file}: at {path}: expected {expected}, found {found}; {advice}")]
    Value { file: String, path: String, expected: String, found: String, advice: &'static str },
}

/// What can stop the pipeline.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum HapdefError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Mesh(#[from] MeshError),
    #[error(transparent)]
    Report(#[from] hapdef_report::ReportError),
    #[error(transparent)]
    Sim(#[from] SimError),
    #[error(transparent)]
    Data(#[from] DataError),
    #[error(transparent)]
    Daq(#[from] DaqError),
    #[error(transparent)]
    Source(#[from] SourceArgError),
    #[cfg(feature = "zenoh")]
    #[error(transparent)]
    Ros(#[from] hapdef_ros::RosError),
    #[error(transparent)]
    Net(#[from] NetsError),
    #[error(transparent)]
    KMax(#[from] KMaxError),
    #[error(transparent)]
    Inverse(#[from] InverseError),
    #[error(transparent)]
    Live(#[from] LiveError),
    #[error(transparent)]
    Scoring(#[from] ScoringError),
    #[error(transparent)]
    Rig(#[from] RigError),
    #[error("gauges.sites[{index}] ({name}): {source}")]
    Gauge { index: usize, name: String, source: Box<HapdefError> },
    #[error("gauges.sites[{index}]: no press reaches it: {why}; move it, or the mount")]
    Unreached { index: usize, why: &'static str },
    #[error("mount: {what}; {advice}")]
    NoMount { what: String, advice: String },
    #[error(
        "loads.flange.at: {what}; name the face that the next joint is fixed to, by a node set, a box, \
         a plane or an end"
    )]
    NoFlange { what: String },
    #[error("{path}: loads that were learned: {what}; make them again with hapdef loads")]
    LearnedLoads { path: PathBuf, what: String },
    #[error(
        "loads.temperature_sd_k: a limb that is solved as a shell takes no thermal load; set \
         geometry.solver to solid, or learn the loads from a recording"
    )]
    ShellTemperature,
    #[error(
        "mount: it holds none of the {n_elements} elements of the body centred at ({:.1}, {:.1}, \
         {:.1}) mm, {:.1} x {:.1} x {:.1} mm in size, one of {n_bodies} that share no node: join the \
         bodies in the mesh, leave this one out, or let the mount reach it",
        centre_m[0] * 1e3, centre_m[1] * 1e3, centre_m[2] * 1e3,
        size_m[0] * 1e3, size_m[1] * 1e3, size_m[2] * 1e3
    )]
    Floating { n_bodies: usize, n_elements: usize, centre_m: [f64; 3], size_m: [f64; 3] },
    #[error(
        "geometry.unit: the deck says by /units that its lengths are in {deck}, the scene says \
         {scene}; correct the one that is wrong"
    )]
    DeckUnit { deck: hapdef_mesh::LengthUnit, scene: hapdef_mesh::LengthUnit },
    #[error("{path}: {what}")]
    NewLimb { path: PathBuf, what: String },
    #[error(
        "{what} can't be told: {why}; state it with {flag} ({}){}",
        choices.join(", "),
        if choices.len() == 2 { ", or take the likeliest of what can't be told with --yes" } else { "" }
    )]
    Unsure { what: &'static str, why: String, flag: &'static str, choices: Vec<String> },
    #[error(
        "the surface is a sheet: it has {n_open_edges} open edges and encloses nothing, so nothing says \
         which side is outside; close it, or give a solid"
    )]
    Sheet { n_open_edges: usize },
    #[error("geometry.skin: {path}: {source}; `hapdef new {path}` makes a clean skin of it")]
    SkinNotClean { path: PathBuf, source: hapdef_mesh::SurfaceFault },
    #[error("geometry.skin: {path}: {source}; `hapdef new {path}` finds a wall that fits")]
    SkinFolds { path: PathBuf, source: MeshError },
    #[error(
        "geometry.solver: {path}: expected a wall that can be solved as a shell, found one of {wall_mm:.2} mm, \
         and {what}; state \"solid\", or leave the field out"
    )]
    SkinSolver { path: PathBuf, wall_mm: f64, what: String },
    #[error("geometry.wall_m: {path}: {what}; write the file again, or state one thickness")]
    SkinWall { path: PathBuf, what: String },
    #[error("{field}: {path}: {source}; the path is relative to the scene file: correct it")]
    NoDeck { field: &'static str, path: PathBuf, source: std::io::Error },
    #[error(
        "estimator.calibration: {path}: {what}; the path is relative to the scene file: correct it, \
         make the file with `hapdef calibrate`, or leave the field out"
    )]
    Calibration { path: PathBuf, what: String },
    #[error(
        "{scene}: estimator.calibration: expected the file that known touches keep up to date, found none; make one \
         with `hapdef calibrate` and name it there"
    )]
    NoCalibration { scene: String },
    #[error("{path}: {what}")]
    Journal { path: PathBuf, what: String },
    #[error("geometry.skin_gltf: {0}; the path is relative to the scene file")]
    SkinGltf(#[source] Box<MeshError>),
    #[error(
        "geometry.skin_gltf: {path}: expected vertices within {reach_mm:.1} mm of the skin's nodes, the \
         nearest is {nearest_mm:.1} mm away; it has to be in metres and in the deck's frame"
    )]
    SkinGltfElsewhere { path: PathBuf, nearest_mm: f64, reach_mm: f64 },
    #[error(
        "rig.mesh.solid_deck: {path}: {source}; mount, contact region and gauges must be found on it \
         as on geometry.solid_deck"
    )]
    RigDeck { path: PathBuf, source: Box<HapdefError> },
    #[error(
        "rig.mesh.solid_deck: {path} is geometry.solid_deck itself, cut as often: the simulated \
         hardware would be the model; name another mesh of the limb, or cut it more often \
         (rig.mesh.refinements)"
    )]
    RigDeckIsLimb { path: PathBuf },
    #[error(
        "material: the deck {deck} lacks modulus, Poisson's ratio or density; add a material \
         section to the scene"
    )]
    NoMaterial { deck: String },
    #[error(
        "contact.min_spacing_m: found no {n_contacts} of {n_nodes} skin nodes {spacing_mm:.1} mm \
         apart in {tries} tries; lower the spacing or contact.max_contacts"
    )]
    TooCrowded { n_contacts: usize, n_nodes: usize, spacing_mm: f64, tries: usize },
    #[error("the limb can't be printed: {what}")]
    Print { what: String },
    #[error("{path}: the file doesn't say its unit; it is {guess}: say it with --unit")]
    UnitNotStated { path: PathBuf, guess: hapdef_mesh::UnitGuess },
    #[error("{0}; or, if the skin may stand for the middle of the wall, say so (--side middle)")]
    WallFolds(#[source] MeshError),
    #[error(
        "{n_gauges} gauges are wanted, but only {n_found} fit: of {n_candidates} nodes clear of \
         the mount and of rims, {n_passed_over} were passed over because the footprint doesn't lie \
         on the wall; ask for fewer gauges, a shorter edge or a shorter mount"
    )]
    TooFewGaugeSites { n_gauges: usize, n_found: usize, n_candidates: usize, n_passed_over: usize },
    #[error(
        "none of {n_places} places on the solid's skin lies on the shell, off its mount: are both \
         in metres and in the same place?"
    )]
    NothingToPress { n_places: usize },
    #[error(
        "{path}: {source}; check the disk's space and rights, or run again with another --results"
    )]
    File { path: PathBuf, source: std::io::Error },
    #[error("{path}: {what}; delete it and run again")]
    Stale { path: PathBuf, what: String },
    #[error("starting the worker threads: {0}; try fewer with --threads")]
    Threads(rayon::ThreadPoolBuildError),
    #[error("stopped at {stage}; run the same command again and it goes on from there")]
    Stopped { stage: String },
}

impl HapdefError {
    /// Says which file or folder an I/O error concerns.
    pub fn file(path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.into();
        move |source| Self::File { path, source }
    }
}
