//! The four networks of HapDefX: architecture, training, checkpoints, and a lean forward pass.
//!
//! An [`MlpSpec`] says what a fully connected network looks like, an [`Mlp`] holds its weights on
//! plain slices, and a [`Net`] puts the scales of raw inputs and outputs around it: raw units in,
//! raw units out. [`save`] and [`load`] keep a net in files, [`Net::to_bytes`] makes it one file. Behind the feature `train` (on by
//! default) `train::train` fits a net to samples and `train::resume` continues from a checkpoint
//! as if there had been no break; with the feature `candle` (also on by default) it does so on candle's
//! tensors where that is asked for, and with `cuda` on a GPU.
//!
//! For run time, [`infer`] prepares a net: fewer bytes a weight, only the outputs that are wanted,
//! layers of low rank, the best vector instructions of the processor at hand.
//!
//! Knows nothing of meshes, ports, or where samples come from.
//!
//! Without default features: the forward pass and the files, with serde and safetensors alone. The
//! feature `random` (part of `train`) adds random weights and the search for layers of low rank.
//!
//! Source of the architectures: H. Sun and G. Martius, "Machine Learning for Haptics: Inferring
//! Multi-Contact Stimulation From Sparse Sensor Configuration", Frontiers in Neurorobotics 13:51,
//! 2019, doi 10.3389/fnbot.2019.00051, section 3.4.

mod activation;
mod backend;
mod bytes;
mod checkpoint;
mod error;
mod files;
mod forward;
pub mod infer;
mod mlp;
mod net;
mod optimiser;
mod params;
#[cfg(feature = "random")]
mod rows;
mod spec;
#[cfg(feature = "train")]
pub mod train;

pub use activation::Activation;
pub use backend::TrainBackend;
pub use bytes::NET_FORMAT_VERSION;
pub use checkpoint::{
    CHECKPOINT_FORMAT_VERSION, Look, Resumable, TrainRecord, load, load_for_resume, save,
};
pub use error::NetsError;
pub use forward::Scratch;
pub use mlp::{Layer, Mlp};
pub use net::{Net, Scale};
pub use optimiser::Moments;
pub use params::{Loss, TrainParams};
pub use spec::MlpSpec;
