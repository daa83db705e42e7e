//! Fitting a net to samples.
//!
//! [`train`] draws batches from a [`BatchSource`], standardises them with the net's scales, and
//! minimises a [`crate::Loss`] + λ Σ w² with Adam; [`resume`] continues from a checkpoint, bit for bit as if
//! there had been no break. The same seed gives the same weights on any number of threads.
//!
//! With [`crate::TrainBackend::Slices`], the default, the passes are written out for fully connected layers, on slices that are allocated once: three
//! matrix products a layer, and what follows them (activation, its derivative, Adam) on each block
//! of rows as soon as it is there. The other backends are candle's tensors, on the processor or a GPU:
//! slower on a processor, and the way to a device that is not one.

mod adam;
mod batch;
#[cfg(feature = "candle")]
mod candle_network;
mod clock;
mod engine;
mod gemm32;
mod learned;
mod loss;
mod network;
mod output_modes;
mod products;
mod run;
mod same;
mod source;
mod view;

pub use output_modes::{InModes, OutputModes};
pub use run::{Progress, TrainInfo, resume, train, validation_loss};
pub use source::{BatchSource, MemorySource, SourceError};
