//! What steps a network: passes on slices, or candle.

use std::borrow::Cow;

use crate::backend::TrainBackend;
use crate::error::NetsError;
use crate::mlp::Mlp;
use crate::optimiser::Moments;
use crate::params::{Loss, TrainParams};
use crate::train::adam::AdamStep;
#[cfg(feature = "candle")]
use crate::train::candle_network::CandleNetwork;
use crate::train::network::Network;

/// A network with the state of Adam, on the backend that was asked for.
pub(super) enum Engine {
    /// On slices.
    Slices(Box<Network>, Vec<Moments>, Loss),
    /// On candle's tensors.
    #[cfg(feature = "candle")]
    Candle(CandleNetwork),
}

impl Engine {
    pub(super) fn new(
        mlp: &Mlp,
        moments: Vec<Moments>,
        params: &TrainParams,
    ) -> Result<Self, NetsError> {
        match params.backend {
            TrainBackend::Slices => {
                let network = Box::new(Network::new(mlp));
                Ok(Self::Slices(network, moments, params.loss))
            }
            #[cfg(feature = "candle")]
            backend if backend.is_built() => {
                Ok(Self::Candle(CandleNetwork::new(mlp, &moments, params)?))
            }
            backend => Err(NetsError::NoBackend { backend }),
        }
    }

    /// Loss of a batch, `x` `[batch, inputs]` and `y` `[batch, outputs]`.
    pub(super) fn forward(&mut self, x: &[f32], y: &[f32]) -> Result<f64, NetsError> {
        match self {
            Self::Slices(network, _, loss) => Ok(network.forward(*loss, x, y)),
            #[cfg(feature = "candle")]
            Self::Candle(network) => network.forward(x, y),
        }
    }

    /// One step of Adam after [`Engine::forward`] of `x`; returns Σ w² of the weights as they were,
    /// 0 where there is no penalty.
    pub(super) fn backward(&mut self, x: &[f32], adam: &AdamStep) -> Result<f64, NetsError> {
        match self {
            Self::Slices(network, moments, _) => Ok(network.backward(x, moments, adam)),
            #[cfg(feature = "candle")]
            Self::Candle(network) => network.backward(adam),
        }
    }

    /// The weights as they are now, in the architecture of `mlp`.
    pub(super) fn to_mlp(&self, mlp: &Mlp) -> Result<Mlp, NetsError> {
        match self {
            Self::Slices(network, ..) => network.to_mlp(mlp),
            #[cfg(feature = "candle")]
            Self::Candle(network) => network.to_mlp(mlp),
        }
    }

    /// The state of Adam, one per layer.
    pub(super) fn moments(&self) -> Result<Cow<'_, [Moments]>, NetsError> {
        match self {
            Self::Slices(_, moments, _) => Ok(Cow::Borrowed(moments)),
            #[cfg(feature = "candle")]
            Self::Candle(network) => Ok(Cow::Owned(network.moments()?)),
        }
    }
}
