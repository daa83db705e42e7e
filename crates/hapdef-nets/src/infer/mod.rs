//! Inference without candle, one sample at a time: what a robot runs.
//!
//! A [`PreparedNet`] is a [`crate::Net`] laid out for the processor at hand: weights in the
//! [`Precision`] that was asked for, only the outputs that are wanted, layers replaced by two thin
//! ones ([`LowRank`]) where that was asked for. A pass allocates nothing and reads each weight at
//! most once: its time is close to the time in which the memory hands those bytes over, so fewer
//! bytes are the only way to be faster, and [`InferInfo`] says how many there were.
//!
//! Weights lie transposed, in panels of outputs: one input's weights for up to 4,096 outputs lie side
//! by side, and an input that is 0 (half of them after a ReLU) is passed over, which is exact.
//! Every output is one sum over the inputs in ascending order, whatever the panel: a net that
//! evaluates few outputs gives them the bits that the whole net gives them.
//!
//! ```
//! # use hapdef_nets::{Activation, Mlp, MlpSpec, Net, NetsError, Scale, Scratch};
//! # let (hidden, activation) = (vec![96, 96, 96], Activation::Relu);
//! # let spec = MlpSpec { inputs: 24, hidden, outputs: 200, activation };
//! # let scale = |n| Scale::new(vec![0.0; n], vec![1.0; n]);
//! # let net = Net::new(Mlp::random(&spec, 1)?, scale(24)?, scale(200)?)?;
//! # let virtual_gauges: Vec<f32> = (0..24 * 300).map(|i| (0.37 * i as f32).sin()).collect();
//! # let frame = &virtual_gauges[..24];
//! use hapdef_nets::infer::{InferParams, LowRank, Precision, PreparedNet};
//!
//! let (low_rank, info) = LowRank::of_samples(&net, 3, &virtual_gauges, 64)?;
//! let params = InferParams { low_rank: vec![low_rank], ..InferParams::of(Precision::Int8) };
//! let prepared = PreparedNet::new(&net, &params)?;
//! let (mut scratch, mut map_um) = (prepared.scratch(), vec![0.0; prepared.n_outputs()]);
//! prepared.forward(&frame, &mut scratch, &mut map_um)?; // allocates nothing
//! # let mut exact_um = vec![0.0; 200];
//! # net.forward(frame, &mut Scratch::default(), &mut exact_um)?;
//! # let largest = exact_um.iter().fold(0.0_f32, |m, x| m.max(x.abs()));
//! # for (found, exact) in map_um.iter().zip(&exact_um) {
//! #     assert!((found - exact).abs() < 0.1 * largest, "{found} {exact}");
//! # }
//! # assert!(info.left_out < 0.1);
//! # Ok::<(), NetsError>(())
//! ```

mod kernels;
mod layer;
mod low_rank;
mod panels;
mod params;
mod prepared;
mod quantise;
mod scratch;
mod simd_level;

pub use low_rank::{LowRank, LowRankInfo};
pub use params::{InferParams, Precision};
pub use prepared::{InferInfo, InferScratch, PreparedNet};
pub use simd_level::SimdLevel;
