//! Contacts followed from frame to frame.
//!
//! The tracker is in one of four states. In each frame its state takes the readings and says which
//! state is next:
//!
//! | state | when | next state |
//! |---|---|---|
//! | `Holding` | the frame's residual alarms, and alarms are not held off | `Detecting`, age 1 |
//! | | the mean of a block of frames has too large a residual | `Detecting`, just before its first decision |
//! | | else | `Holding`; a block that is explained updates all hypotheses |
//! | `Detecting` | a contact more explains the frames since the alarm better | `Growing` |
//! | | a slide of a held contact does | `Sliding` |
//! | | another hypothesis does | `Holding` |
//! | | nothing does at the last decision | `Holding`, alarms held off |
//! | `Growing` | a slide explains the frames better after all | `Sliding` |
//! | | the force is steady or time is up, or something else has come | `Holding`; the frames gathered update all hypotheses |
//! | `Sliding` | a contact more explains the frames better after all | `Growing` |
//! | | the contact hardly moved in two blocks | `Growing`, as a contact that has come to rest |
//! | | too many alarms in a row | `Holding` |
//! | `Growing`, `Sliding` | the last contact that moves is let go | `Holding` |
//! | any | a full search is adopted | `Growing`, or `Holding` where nothing in it moves |
//! | any, nothing moves | a full search explains nothing better | `Holding` |
//! | any | reset | `Holding` |
//!
//! What a state remembers is in [`state`], what all of them work with is the [`workspace`].

mod adopt;
mod compare;
mod contact_tracker;
mod detection;
mod exchange;
mod filter;
mod frame;
mod gathered;
mod growing;
mod holding;
mod hypotheses;
mod hypothesis;
mod locate;
mod metric;
mod pair_birth;
mod pair_search;
mod params;
mod proposals;
mod recent;
mod release;
mod report;
mod scan;
mod search;
mod sliding;
mod state;
mod workspace;

pub use contact_tracker::ContactTracker;
pub use exchange::Belief;
pub use frame::{ContactId, TrackInfo, TrackedContact, TrackedFrame};
pub use params::TrackerParams;
pub use search::{BackgroundSearch, SearchOutcome, SearchRequest, Searcher};
