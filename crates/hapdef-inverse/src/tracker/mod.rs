//! Contacts followed from frame to frame.

mod adopt;
mod detection;
mod filter;
mod finish;
mod follow;
mod frame;
mod gathered;
mod growth;
mod hypotheses;
mod hypothesis;
mod locate;
mod metric;
mod pair_birth;
mod params;
mod recent;
mod scan;
mod search;
mod slide;

pub use follow::ContactTracker;
pub use frame::{ContactId, Phase, TrackInfo, TrackedContact, TrackedFrame};
pub use params::TrackerParams;
pub use search::{BackgroundSearch, SearchOutcome, SearchRequest};
