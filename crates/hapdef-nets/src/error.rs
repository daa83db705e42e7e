//! The one error type of the crate.

use std::path::PathBuf;

use thiserror::Error;

use crate::infer::SimdLevel;
use crate::params::TrainBackend;

/// Why a net could not be made, run, trained, written or read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum NetsError {
    /// A layer without neurons, an input or an output of width 0.
    #[error("every width must be at least 1, got {widths:?} (inputs, hidden layers, outputs)")]
    Widths {
        /// Widths of inputs, hidden layers, outputs.
        widths: Vec<usize>,
    },
    /// A slice of another length than the net needs.
    #[error("{what}: {expected} values expected, got {got}")]
    Length {
        /// What the slice is.
        what: &'static str,
        /// Values expected.
        expected: usize,
        /// Values given.
        got: usize,
    },
    /// A value that is NaN or infinite.
    #[error("{what}: value {index} is {value}")]
    NotFinite {
        /// What the slice is.
        what: &'static str,
        /// Index of the value.
        index: usize,
        /// The value.
        value: f32,
    },
    /// An input of a net that is NaN or infinite.
    #[error("input of a net: row {row}, column {column} is {value}; find out which step made it")]
    InputNotFinite {
        /// Sample of the batch, from 0.
        row: usize,
        /// Column of the input.
        column: usize,
        /// The value.
        value: f32,
    },
    /// A standard deviation that is negative or no number.
    #[error(
        "scale: the deviation of column {column} is {std}, it must be finite and positive, or 0 \
         for a column that never varied"
    )]
    Deviation {
        /// The column.
        column: usize,
        /// Its deviation.
        std: f32,
    },
    /// A backend of training that this build has not.
    #[error(
        "this build of hapdef-nets cannot train on {backend:?}; build it with the feature `candle`, or `cuda` for a GPU, or train on slices"
    )]
    NoBackend {
        /// The backend asked for.
        backend: TrainBackend,
    },
    /// A GPU that does not start.
    #[cfg(feature = "candle")]
    #[error(
        "GPU {ordinal} does not start: {source}; `nvidia-smi -L` lists those there are, and training on slices needs none"
    )]
    NoGpu {
        /// Which GPU was asked for, from 0.
        ordinal: usize,
        /// What CUDA said.
        source: Box<candle_core::Error>,
    },
    /// Candle failed: no memory, for one.
    #[cfg(feature = "candle")]
    #[error("candle: {0}")]
    Candle(#[from] candle_core::Error),
    /// A parameter of the training outside its range.
    #[error("training: {name} is {value}, it must be {range}")]
    Param {
        /// Name of the parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        range: &'static str,
    },
    /// Samples of other widths than the net's.
    #[error(
        "the samples have {got_inputs} inputs and {got_outputs} outputs, \
         the net {expected_inputs} and {expected_outputs}"
    )]
    SampleWidths {
        /// Inputs of the net.
        expected_inputs: usize,
        /// Outputs of the net.
        expected_outputs: usize,
        /// Inputs of the samples.
        got_inputs: usize,
        /// Outputs of the samples.
        got_outputs: usize,
    },
    /// There is nothing to learn from.
    #[error("the {role} set has no samples")]
    NoSamples {
        /// Training or validation.
        role: &'static str,
    },
    /// The source of the samples failed.
    #[error("the samples of step {step} could not be read: {source}")]
    Samples {
        /// The step.
        step: u64,
        /// What the source said.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A sample holds a value that is NaN or infinite.
    #[error("sample {sample}: {what} {column} is {value}; find out which step made it")]
    SampleNotFinite {
        /// Row of the sample.
        sample: usize,
        /// Input or output.
        what: &'static str,
        /// Column of the value.
        column: usize,
        /// The value.
        value: f32,
    },
    /// The loss is no longer a number.
    #[error(
        "the loss became {loss} at step {step} with learning rate {learning_rate:?}: \
         use a smaller learning rate"
    )]
    Diverged {
        /// The step.
        step: u64,
        /// Learning rate at that step.
        learning_rate: f64,
        /// The loss.
        loss: f64,
    },
    /// A net that is no better after its training than the means of its own training samples.
    #[error(
        "the training learned nothing: after {steps} steps from learning rate {learning_rate:?} the \
         √MSE of the standardised outputs is {after:.3} on training samples, and {of_means:.3} \
         where each output stays at its mean; if the loss grew, use a smaller learning rate, else \
         more steps or less L2, and see that the inputs vary"
    )]
    NothingLearned {
        /// Steps of the training.
        steps: u64,
        /// Learning rate at the start.
        learning_rate: f64,
        /// √MSE on training samples after it, standardised outputs that vary.
        after: f64,
        /// The same of the means.
        of_means: f64,
    },
    /// A resumed training must have the parameters it began with, or it is another training.
    #[error(
        "{} was trained with {name} = {saved}, resuming asks for {asked}: \
         give the same, or start a new training from the net",
        path.display()
    )]
    ResumeParams {
        /// The checkpoint.
        path: PathBuf,
        /// Name of the parameter.
        name: &'static str,
        /// Its value in the checkpoint.
        saved: String,
        /// Its value now.
        asked: String,
    },
    /// The checkpoint was made without what resuming needs.
    #[error(
        "{} holds a net but no state of the optimiser: it cannot be resumed, \
         only be used or trained anew from",
        path.display()
    )]
    NotResumable {
        /// The checkpoint.
        path: PathBuf,
    },
    /// The operating system refused.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// What was tried.
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A checkpoint that is not valid JSON of the known fields.
    #[error("{} is not a valid checkpoint: {source}", path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// Line, column and reason.
        source: serde_json::Error,
    },
    /// A checkpoint of another format version.
    #[error(
        "{} has format version {found}, this program reads {known}: train the net anew",
        path.display()
    )]
    FormatVersion {
        /// The file.
        path: PathBuf,
        /// Version found.
        found: u32,
        /// Version known.
        known: u32,
    },
    /// A file name in a checkpoint that would lead out of its folder.
    #[error("{} names the file \"{name}\", which is not a plain file name", path.display())]
    FileName {
        /// The checkpoint.
        path: PathBuf,
        /// The name.
        name: String,
    },
    /// A safetensors file without a net.
    #[error("{} holds no net: it lacks the entry {entry}; make it anew", path.display())]
    NotANet {
        /// The file.
        path: PathBuf,
        /// Name of the metadata entry that a net has.
        entry: &'static str,
    },
    /// A weights file that is cut off or not a safetensors file.
    #[error("{} is not a readable safetensors file: {source}", path.display())]
    Safetensors {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: safetensors::SafeTensorError,
    },
    /// A tensor that is missing, or of another shape or kind than the architecture asks for.
    #[error(
        "{}: tensor \"{tensor}\" should be f32 {expected:?}, found {found}",
        path.display()
    )]
    Tensor {
        /// The file.
        path: PathBuf,
        /// Name of the tensor.
        tensor: String,
        /// Shape expected.
        expected: Vec<usize>,
        /// What was found instead.
        found: String,
    },
    /// A weight that is NaN or infinite.
    #[error("{}: tensor \"{tensor}\" holds {value} at {index}", path.display())]
    Weight {
        /// The file.
        path: PathBuf,
        /// Name of the tensor.
        tensor: String,
        /// Index of the weight.
        index: usize,
        /// The weight.
        value: f32,
    },
    /// The processor lacks the instructions that were asked for.
    #[error("the processor has no {asked:?} instructions; its best are {best:?}")]
    Simd {
        /// The level asked for.
        asked: SimdLevel,
        /// The best there is.
        best: SimdLevel,
    },
    /// A wanted output that the net does not have.
    #[error("output {output} is wanted, the net has {n_outputs}: outputs count from 0")]
    NoSuchOutput {
        /// The output.
        output: usize,
        /// Outputs of the net.
        n_outputs: usize,
    },
    /// A list of wanted outputs with nothing in it.
    #[error("no output is wanted: name at least one, or leave the list out for all of them")]
    NoOutputs,
    /// A layer that the net does not have.
    #[error("layer {layer} is to be replaced, the net has {n_layers}: layers count from 0")]
    NoSuchLayer {
        /// The layer.
        layer: usize,
        /// Layers of the net.
        n_layers: usize,
    },
    /// A rank that is not below the widths of its layer, or more than there are samples.
    #[error("rank {rank}: it must be 1 to {most}, the layer's widths and the number of samples")]
    Rank {
        /// The rank.
        rank: usize,
        /// The largest that works.
        most: usize,
    },
    /// A net of coordinates that scales its outputs.
    #[error("the net scales its outputs: one that is unfolded must give coordinates as they are")]
    ScaledCoordinates,
    /// A layer too wide for sums of bytes in 32 bits.
    #[error("a layer of {n_in} inputs: with activations in bytes {most} are the most")]
    TooManyInputs {
        /// Inputs of the layer.
        n_in: usize,
        /// The most that work.
        most: usize,
    },
    /// A value inside a net left the range of f32.
    #[error(
        "value {index} after layer {layer} became {value}: the input is far outside what the net \
         was trained on (layer 0 is the input after its scale)"
    )]
    Overflow {
        /// Layers passed.
        layer: usize,
        /// Index of the value.
        index: usize,
        /// The value.
        value: f32,
    },
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
