//! Contacts from one frame of readings.

mod contact_estimator;
mod deepening;
mod doubt;
mod effective_rank;
mod estimate;
mod exchange;
mod explanation;
mod forces;
mod grow;
mod map_error;
mod model;
mod normal_equations;
mod output;
mod pairs;
mod params;
mod radius;
mod refine;
mod report;
mod scan;
mod scratch;
mod search;
mod seen;
mod shared;
mod shear;
mod wide;
mod wide_params;

pub use contact_estimator::ContactEstimator;
pub(crate) use hapdef_contact::MAX_CONTACTS;
pub use output::{
    CHI2_95, ContactEstimate, EstimateInfo, IfTwo, LocatedContact, RunnerUp, ShearContact,
};
pub use params::{BELIEVED_OF_RANGE, EstimatorParams};
pub use scratch::EstimatorScratch;
pub use seen::SeenForces;
pub(crate) use seen::needed_chi2;
pub use wide_params::WideParams;

pub(crate) use explanation::Explanation;
pub(crate) use forces::non_negative;
pub(crate) use model::Model;
pub(crate) use normal_equations::{Linear, MAX_UNKNOWNS};
pub(crate) use pairs::pair_energies;
pub(crate) use refine::solved;
pub(crate) use report::spare_numbers;
pub(crate) use scan::Gain;
