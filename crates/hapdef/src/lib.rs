//! From a limb to contacts: the scene file, the stages of the pipeline, the estimator, scoring.
//!
//! A [`Run`] holds a scene, a [`Profile`] of how much to make, and the content-addressed
//! [`Cache`]; [`stages`] are functions on it, each from what it needs to a cached folder.
//! [`Hapdefx`] is the paper's chain from gauge readings to contacts.
//!
//! Knows nothing of command lines and web pages, which are in `hapdef-cli`, nor of the paper's tables
//! and baselines: those are in `hapdef-repro`.

mod cache;
mod compliance;
pub mod convergence;
mod drawn_skin;
mod error;
mod error_text;
mod hapdefx;
mod limb;
mod map_error;
mod pipeline;
pub mod plan;
mod profile;
mod progress;
mod run;
mod sampling;
pub mod scene;
mod scoring;
pub mod session;
pub mod shell_limb;
mod source_args;
pub mod stages;
mod stats;
pub mod touch;
mod virtual_rig;

pub use cache::{Cache, Stage, StageRecord, write_json};
pub use compliance::{ComplianceTable, SuperpositionScratch};
pub use drawn_skin::DrawnSkin;
pub use error::{HapdefError, SceneError};
pub use error_text::error_text;
pub use hapdef_live::touch::{ChainNets, FoundContact, Hapdefx, HapdefxScratch};
pub use hapdefx::hapdefx;
pub use limb::Limb;
pub use map_error::{MapError, MapErrorSum};
pub use pipeline::{Pipeline, Until};
pub use profile::{OutputScale, Profile, Samples, Schedule};
pub use progress::{Bar, Display, Progress, TrainingBar};
pub use run::Run;
pub use sampling::{DrawnContact, draw_contacts, draw_numbered};
pub use scoring::{
    ContactPair, Gospa, GospaParams, MAX_ONE_TO_ONE, OneToOne, ScoredContact, ScoringError, gospa,
    score_lenient, score_one_to_one,
};
pub use source_args::{SOURCE_FORMS, SourceArg, SourceArgError, parse_speed};
pub use stats::ContactStats;
pub use virtual_rig::{VirtualRigParams, live_limb, random_presses, virtual_device};
