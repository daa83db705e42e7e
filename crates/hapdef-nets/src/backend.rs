//! What may do the arithmetic of a training.

use serde::{Deserialize, Serialize};

/// What does the arithmetic of a training.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TrainBackend {
    /// Passes written out on slices: the fastest on a processor, the same bits on any number of
    /// threads.
    #[default]
    Slices,
    /// Candle's tensors and automatic derivatives on the processor, in 32 bits. Needs the feature
    /// `candle`.
    Candle,
    /// The same on a GPU of NVIDIA. Needs the feature `cuda`.
    Cuda {
        /// Which GPU, from 0.
        ordinal: usize,
    },
}

impl TrainBackend {
    /// Whether this build has it; whether a GPU starts is seen when a training does.
    pub fn is_built(self) -> bool {
        match self {
            Self::Slices => true,
            Self::Candle => cfg!(feature = "candle"),
            Self::Cuda { .. } => cfg!(feature = "cuda"),
        }
    }
}
