//! Fitting a net to samples.
//!
//! [`train`] draws batches from a [`BatchSource`], standardises them with the net's scales, and
//! minimises √MSE + λ Σ w² with Adam; [`resume`] continues from a checkpoint, bit for bit as if
//! there had been no break. The same seed gives the same weights on any number of threads.
//!
//! Only the matrix products go through candle. The rest of the forward and backward pass and Adam
//! are loops over slices, run in place: candle's own gradients and its AdamW spend most of a step
//! on making and clearing temporaries.

mod adam;
mod batch;
mod network;
mod run;
mod source;
mod tensors;

pub use run::{Progress, TrainInfo, resume, train, validation_loss};
pub use source::{BatchSource, MemorySource, SourceError};
