//! The direct path: the elimination order, and the sparse supernodal Cholesky factor.

pub(crate) mod analysis;
pub(crate) mod cholesky;
pub(crate) mod dissection;
mod front;
pub(crate) mod ordering;
pub(crate) mod panel;
mod triangular;

pub use dissection::Ordering;
