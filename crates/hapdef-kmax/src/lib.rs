//! Local maxima of any field on any points, and the rules that pick contacts among them.
//!
//! A [`KMaxGraph`] is built once from the positions of the nodes (feature `points`, on by default) or
//! from known neighbours, and remembers each node's nearest neighbours. [`KMaxGraph::peaks`] then
//! finds, in any field of one number per node, the nodes that are the largest of their neighbourhood.
//! [`select_top`] and [`select_top_with_spread`] choose among scored candidates.
//!
//! Knows nothing of limbs, forces or nets: nodes are indices, fields are slices.
//!
//! Source: H. Sun and G. Martius, "Machine Learning for Haptics: Inferring Multi-Contact
//! Stimulation From Sparse Sensor Configuration", Frontiers in Neurorobotics 13:51, 2019,
//! doi 10.3389/fnbot.2019.00051, sections 3.3 (k-Max) and 4.4 (selection).

mod error;
mod graph;
mod peaks;
#[cfg(feature = "points")]
mod points;
mod select;

pub use error::KMaxError;
pub use graph::KMaxGraph;
pub use peaks::Peak;
#[cfg(feature = "points")]
pub use points::KMaxParams;
pub use select::{Candidate, select_top, select_top_with_spread};
