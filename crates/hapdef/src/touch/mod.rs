//! From one frame of readings to contacts, as a scene wants it: its estimator, its response map, its
//! bundle; and what a layout of gauges can tell.

mod bundle;
mod calibration;
mod chosen;
mod diagnosis;
mod fine;
mod glued;
mod kept_response;
mod layout;
mod layout_choice;
mod learned_loads;
mod limits;
mod model;
mod modes;
mod other_loads;
mod probing;
mod recalibration;
mod response;
mod score;
mod shell;
mod steady;
mod stiffness;
mod superposition;

pub use bundle::{BundleRequest, calibration_in_use, make_bundle};
pub(crate) use calibration::N_STIFFNESS;
pub use calibration::{CALIBRATION_SITES, Calibration, GainsSince, PressQuality};
pub use chosen::{
    ChainStages, by_superposition, chain_stages, live_estimator, touch_estimator, tracker_params,
};
pub use diagnosis::{Cause, Causes, NotClean, why_not_clean};
pub use hapdef_live::estimator::{
    EstimatorKind, PaperChain, SearchPlace, Superposition, TouchEstimator, TouchFrame, TouchWanted,
    Tracking,
};
pub use hapdef_live::{Alternative, Contact, Quality, Touch, Uncertainty};
pub(crate) use layout::to_micrometres;
pub use layout::{
    CountedLayout, LayoutParams, LayoutStudy, PlacedGauge, ScoredLayout, gauge_entries,
};
pub use layout_choice::{LayoutCandidates, SeeingLayout, study_layouts};
pub use learned_loads::{LearnedLoads, given_loads};
pub use limits::{LimitsReport, LimitsRequest, limits};
pub(crate) use model::{LimbModel, model_estimate};
pub use modes::{UncertainParams, UncertainResponse};
pub use other_loads::other_loads;
pub use probing::{ProbeParams, ProbedPress, ProbedRig};
pub use recalibration::{
    DeclaredForce, DeclaredTouch, JournalEntry, JournalTouch, JournalUndo, Recalibrator,
    TouchAssumptions,
};
pub use response::{response_map, response_with_loads, touchable_skin};
pub use score::TouchScore;
pub use superposition::{estimator_params, estimator_settings, superposition};
