//! The one error type of the crate.

use std::path::PathBuf;

use thiserror::Error;

use crate::backend::TrainBackend;
use crate::infer::SimdLevel;

/// Why a net could not be made, run, trained, written or read.
#[derive(Debug, Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum NetsError {
    #[error("every width must be at least 1, got {widths:?} (inputs, hidden layers, outputs)")]
    Widths { widths: Vec<usize> },
    #[error("{what}: {expected} values expected, got {got}")]
    Length { what: &'static str, expected: usize, got: usize },
    #[error("{what}: value {index} is {value}")]
    NotFinite { what: &'static str, index: usize, value: f32 },
    #[error("input of a net: row {row}, column {column} is {value}; find out which step made it")]
    InputNotFinite { row: usize, column: usize, value: f32 },
    #[error(
        "scale: the deviation of column {column} is {std}, it must be finite and positive, or 0 \
         for a column that never varied"
    )]
    Deviation { column: usize, std: f32 },
    #[error(
        "this build of hapdef-nets cannot train on {backend:?}; build it with the feature `candle`, or `cuda` for a GPU, or train on slices"
    )]
    NoBackend { backend: TrainBackend },
    #[cfg(feature = "candle")]
    #[error(
        "GPU {ordinal} does not start: {source}; `nvidia-smi -L` lists those there are, and training on slices needs none"
    )]
    NoGpu { ordinal: usize, source: Box<candle_core::Error> },
    #[cfg(feature = "candle")]
    #[error("candle: {0}")]
    Candle(#[from] candle_core::Error),
    #[error("training: {name} is {value}, it must be {range}")]
    Param { name: &'static str, value: f64, range: &'static str },
    #[error(
        "the samples have {got_inputs} inputs and {got_outputs} outputs, \
         the net {expected_inputs} and {expected_outputs}"
    )]
    SampleWidths {
        expected_inputs: usize,
        expected_outputs: usize,
        got_inputs: usize,
        got_outputs: usize,
    },
    #[error("the {role} set has no samples")]
    NoSamples { role: &'static str },
    #[error("the samples of step {step} could not be read: {source}")]
    Samples { step: u64, source: Box<dyn std::error::Error + Send + Sync> },
    #[error("sample {sample}: {what} {column} is {value}; find out which step made it")]
    SampleNotFinite { sample: usize, what: &'static str, column: usize, value: f32 },
    #[error(
        "the loss became {loss} at step {step} with learning rate {learning_rate:?}: \
         use a smaller learning rate"
    )]
    Diverged { step: u64, learning_rate: f64, loss: f64 },
    #[error(
        "the training learned nothing: after {steps} steps from learning rate {learning_rate:?} the \
         √MSE of the standardised outputs is {after:.3} on training samples, and {of_means:.3} \
         where each output stays at its mean; if the loss grew, use a smaller learning rate, else \
         more steps or less L2, and see that the inputs vary"
    )]
    NothingLearned { steps: u64, learning_rate: f64, after: f64, of_means: f64 },
    #[error(
        "{} was trained with {name} = {saved}, resuming asks for {asked}: \
         give the same, or start a new training from the net",
        path.display()
    )]
    ResumeParams { path: PathBuf, name: &'static str, saved: String, asked: String },
    #[error(
        "{} holds a net but no state of the optimiser: it cannot be resumed, \
         only be used or trained anew from",
        path.display()
    )]
    NotResumable { path: PathBuf },
    #[error("cannot {action} {}: {source}", path.display())]
    Io { action: &'static str, path: PathBuf, source: std::io::Error },
    #[error("{} is not a valid checkpoint: {source}", path.display())]
    Json { path: PathBuf, source: serde_json::Error },
    #[error(
        "{} has format version {found}, this program reads {known}: train the net anew",
        path.display()
    )]
    FormatVersion { path: PathBuf, found: u32, known: u32 },
    #[error("{} names the file \"{name}\", which is not a plain file name", path.display())]
    FileName { path: PathBuf, name: String },
    #[error("{} holds no net: it lacks the entry {entry}; make it anew", path.display())]
    NotANet { path: PathBuf, entry: &'static str },
    #[error("{} is not a readable safetensors file: {source}", path.display())]
    Safetensors { path: PathBuf, source: safetensors::SafeTensorError },
    #[error(
        "{}: tensor \"{tensor}\" should be f32 {expected:?}, found {found}",
        path.display()
    )]
    Tensor { path: PathBuf, tensor: String, expected: Vec<usize>, found: String },
    #[error("{}: tensor \"{tensor}\" holds {value} at {index}", path.display())]
    Weight { path: PathBuf, tensor: String, index: usize, value: f32 },
    #[error("the processor has no {asked:?} instructions; its best are {best:?}")]
    Simd { asked: SimdLevel, best: SimdLevel },
    #[error("output {output} is wanted, the net has {n_outputs}: outputs count from 0")]
    NoSuchOutput { output: usize, n_outputs: usize },
    #[error("no output is wanted: name at least one, or leave the list out for all of them")]
    NoOutputs,
    #[error("layer {layer} is to be replaced, the net has {n_layers}: layers count from 0")]
    NoSuchLayer { layer: usize, n_layers: usize },
    #[error("rank {rank}: it must be 1 to {most}, the layer's widths and the number of samples")]
    Rank { rank: usize, most: usize },
    #[error("the net scales its outputs: one that is unfolded must give coordinates as they are")]
    ScaledCoordinates,
    #[error("a layer of {n_in} inputs: with activations in bytes {most} are the most")]
    TooManyInputs { n_in: usize, most: usize },
    #[error(
        "value {index} after layer {layer} became {value}: the input is far outside what the net \
         was trained on (layer 0 is the input after its scale)"
    )]
    Overflow { layer: usize, index: usize, value: f32 },
}

/// Fails unless `got` is `expected`.
pub(crate) fn check_length(
    what: &'static str,
    expected: usize,
    got: usize,
) -> Result<(), NetsError> {
    if got == expected {
        return Ok(());
    }
    Err(NetsError::Length { what, expected, got })
}

/// Fails on the first value of rows of `width` that is NaN or infinite.
pub(crate) fn check_inputs(width: usize, x: &[f32]) -> Result<(), NetsError> {
    match x.iter().position(|v| !v.is_finite()) {
        Some(at) => {
            Err(NetsError::InputNotFinite { row: at / width, column: at % width, value: x[at] })
        }
        None => Ok(()),
    }
}

/// Fails on the first value that is NaN or infinite.
pub(crate) fn check_finite(what: &'static str, values: &[f32]) -> Result<(), NetsError> {
    match values.iter().position(|v| !v.is_finite()) {
        Some(index) => Err(NetsError::NotFinite { what, index, value: values[index] }),
        None => Ok(()),
    }
}
