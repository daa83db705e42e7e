//! Contacts from gauge readings by superposition, with their covariance and what is not known.
//!
//! Linear elasticity makes readings add up: y = Σ Aᵢ g(pᵢ) + n with forces Aᵢ ≥ 0 at points pᵢ of
//! the skin. A [`Skin`] is the surface that contacts sit and move on, a [`ResponseMap`] g(p) smooth
//! over it, [`NoiseParams`] what readings and map are worth. [`ContactEstimator`] searches: one contact
//! by a scan of [`ScanSites`], pairs by an exhaustive scan of the sites' Gram matrix, more by adding
//! to the best pairs, all refined over the skin; the count follows from the evidence, and the
//! [`ContactEstimate`] says how sure it is and what else would explain the frame. [`ContactTracker`]
//! follows contacts from frame to frame in bounded time. [`single_bounds`],
//! [`joint_bounds`] and [`carried_contacts`] are the limits of a layout; [`place_greedy`] and
//! [`exchange`] choose one. [`Calibrated::fit`] corrects a map by presses of known place and force and
//! estimates its error, and [`Recalibration`] follows the gauges' gains from one known touch in use to the
//! next; a [`Conditioner`] takes tare, drift, temperature and creep off raw readings and masks bad gauges.
//!
//! Everything comes and goes as arrays: this crate knows nothing of files, ports or nets.

mod basis;
mod calibration;
mod chi_square;
mod conditioning;
mod dense;
mod effort;
mod error;
mod estimator;
mod interpolant;
mod limits;
mod nearest;
mod node_gradient;
mod noise;
mod other_loads;
mod patch;
mod placement;
mod recalibration;
mod response;
mod sites;
mod skin;
mod skin_point;
mod subdivided_faces;
mod tracker;
mod walk;

pub use calibration::{
    BeyondPrior, Calibrated, CalibrationInfo, CalibrationParams, CurvePoint, HeldOutError,
    LEAST_PRESSES, ModeMap, ModeScope, NextPress, Press, RejectReason, RejectedPress,
};
pub use chi_square::upper_tail as chi_square_tail;
pub use conditioning::{
    Conditioned, Conditioner, ConditionerParams, DriftState, MoveKind, TareEnd, TareMove,
};
pub use effort::Effort;
pub use error::InverseError;
pub use estimator::{
    BELIEVED_OF_RANGE, CHI2_95, ContactEstimate, ContactEstimator, EstimateInfo, EstimatorParams,
    EstimatorScratch, IfTwo, LocatedContact, RunnerUp, SeenForces, ShearContact, WideParams,
};
pub use hapdef_contact::{GaugeHealth, MAX_CONTACTS, Phase, TouchPhase, Verdict, WhyNot};
pub use limits::{
    Carried, ContactBound, LimitParams, carried_contacts, joint_bounds, single_bounds,
};
pub use noise::{ModelError, NoiseParams};
pub use other_loads::OtherLoads;
pub use patch::{TipMeans, tip_ring_m};
pub use placement::{
    Candidates, CoverParams, PlacementParams, PlacementScore, cover, exchange, place_entropy,
    place_greedy, place_mutual_information, place_nearest_neighbours, place_pca_qr, place_random,
    placement_score, smallest_seen_n,
};
pub use recalibration::{
    GainChange, KnownTouch, Recalibration, RecalibrationParams, TouchInfo, TouchZero,
};
pub use response::{ResponseMap, ResponseParams};
pub use sites::ScanSites;
pub use skin::{Skin, SkinFaces, SkinParams};
pub use skin_point::SkinPoint;
pub use tracker::{
    BackgroundSearch, Belief, ContactId, ContactTracker, SearchOutcome, SearchRequest, Searcher,
    TrackInfo, TrackedContact, TrackedFrame, TrackerParams,
};
pub use walk::{AtWall, Walk, WalkEnd};
