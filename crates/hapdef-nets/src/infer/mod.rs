//! Inference without candle, one sample at a time: what a robot runs.
//!
//! A [`PreparedNet`] is a [`crate::Net`] laid out for the processor at hand: weights in the
//! [`Precision`] that was asked for, only the outputs that are wanted, layers replaced by two thin
//! ones ([`LowRank`]) where that was asked for. A pass allocates nothing and reads each weight at
//! most once: its time is close to the time in which the memory hands those bytes over, so fewer
//! bytes are the only way to be faster, and [`InferInfo`] says how many there were.
//!
//! Weights lie transposed, in panels of outputs: one input's weights for up to 128 outputs lie side
//! by side, and an input that is 0 (half of them after a ReLU) is passed over, which is exact.
//! Every output is one sum over the inputs in ascending order, whatever the panel: a net that
//! evaluates few outputs gives them the bits that the whole net gives them.

mod kernels;
mod layer;
mod low_rank;
mod panels;
mod params;
mod prepared;
mod quantise;

pub use kernels::SimdLevel;
pub use low_rank::{LowRank, LowRankInfo};
pub use params::{InferParams, Precision};
pub use prepared::{InferInfo, InferScratch, PreparedNet};
