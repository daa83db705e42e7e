//! The same training on candle's tensors: any device that candle has, its automatic derivatives.

use candle_core::{Device, Tensor, Var};
use candle_nn::{Linear, Module};

use crate::activation::Activation;
use crate::backend::TrainBackend;
use crate::error::NetsError;
use crate::mlp::{Layer, Mlp};
use crate::optimiser::Moments;
use crate::params::{Loss, TrainParams};
use crate::train::adam::{AdamStep, BETA_1, BETA_2};

/// A network whose weights are variables of candle.
pub(super) struct CandleNetwork {
    device: Device,
    layers: Vec<CandleLayer>,
    activation: Activation,
    kind: Loss,
    /// Loss of the last forward pass, with the way back to the variables.
    loss: Option<Tensor>,
}

struct CandleLayer {
    /// W, `[outputs, inputs]`.
    weights: Learnt,
    /// b, `[outputs]`.
    bias: Learnt,
}

/// A variable and Adam's moments of it.
struct Learnt {
    value: Var,
    m: Tensor,
    v: Tensor,
}

impl CandleNetwork {
    /// The weights of `mlp` and the state of Adam on the device of the backend.
    pub(super) fn new(
        mlp: &Mlp,
        moments: &[Moments],
        params: &TrainParams,
    ) -> Result<Self, NetsError> {
        let device = device(params.backend)?;
        let shapes = mlp.spec().layer_shapes();
        let layers = mlp.layers().iter().zip(moments).zip(shapes);
        let layers = layers.map(|((layer, moments), (n_in, n_out))| {
            let (m, v) = (&moments.weights_m, &moments.weights_v);
            let weights = Learnt::new(&layer.weights, m, v, &[n_out, n_in], &device)?;
            let (m, v) = (&moments.bias_m, &moments.bias_v);
            let bias = Learnt::new(&layer.bias, m, v, &[n_out], &device)?;
            Ok(CandleLayer { weights, bias })
        });
        let layers = layers.collect::<Result<_, NetsError>>()?;
        let activation = mlp.spec().activation;
        Ok(Self { device, layers, activation, kind: params.loss, loss: None })
    }

    /// Loss of a batch, `x` `[batch, inputs]` and `y` `[batch, outputs]`.
    pub(super) fn forward(&mut self, x: &[f32], y: &[f32]) -> Result<f64, NetsError> {
        let (_, n_in) = self.layers[0].weights.value.dims2()?;
        let batch = x.len() / n_in;
        let mut a = Tensor::from_slice(x, (batch, n_in), &self.device)?;
        for (i, layer) in self.layers.iter().enumerate() {
            let weights = layer.weights.value.as_tensor().clone();
            let bias = layer.bias.value.as_tensor().clone();
            a = Linear::new(weights, Some(bias)).forward(&a)?;
            if i + 1 < self.layers.len() {
                a = match self.activation {
                    Activation::Relu => a.relu()?,
                    Activation::Tanh => a.tanh()?,
                };
            }
        }
        let y = Tensor::from_slice(y, a.shape(), &self.device)?;
        let squares = (a - y)?.sqr()?;
        let loss = match self.kind {
            Loss::RootMeanSquare => squares.mean_all()?.sqrt()?,
            Loss::MeanOfSamples => squares.mean(1)?.sqrt()?.mean_all()?,
        };
        let value = f64::from(loss.to_scalar::<f32>()?);
        self.loss = Some(loss);
        Ok(value)
    }

    /// One step of Adam after [`CandleNetwork::forward`]; returns Σ w² of the weights as they were,
    /// 0 where there is no penalty.
    pub(super) fn backward(&mut self, adam: &AdamStep) -> Result<f64, NetsError> {
        let Some(loss) = self.loss.take() else {
            return Ok(0.0);
        };
        let gradients = loss.backward()?;
        let mut sum = 0.0;
        for layer in &mut self.layers {
            if adam.decay > 0.0 {
                let squares = layer.weights.value.sqr()?.sum_all()?;
                sum += f64::from(squares.to_scalar::<f32>()?);
            }
            for (learnt, decay) in [(&mut layer.weights, adam.decay), (&mut layer.bias, 0.0)] {
                if let Some(gradient) = gradients.get(learnt.value.as_tensor()) {
                    learnt.change(gradient, &AdamStep { decay, ..*adam })?;
                }
            }
        }
        Ok(sum)
    }

    /// The weights as they are now, in the architecture of `mlp`.
    pub(super) fn to_mlp(&self, mlp: &Mlp) -> Result<Mlp, NetsError> {
        let layers = self.layers.iter().map(|layer| {
            Ok(Layer {
                weights: values(layer.weights.value.as_tensor())?,
                bias: values(layer.bias.value.as_tensor())?,
            })
        });
        Mlp::from_layers(mlp.spec(), layers.collect::<Result<_, NetsError>>()?)
    }

    /// The state of Adam, one per layer.
    pub(super) fn moments(&self) -> Result<Vec<Moments>, NetsError> {
        let of_layer = |layer: &CandleLayer| {
            Ok(Moments {
                weights_m: values(&layer.weights.m)?,
                weights_v: values(&layer.weights.v)?,
                bias_m: values(&layer.bias.m)?,
                bias_v: values(&layer.bias.v)?,
            })
        };
        self.layers.iter().map(of_layer).collect()
    }
}

impl Learnt {
    fn new(
        value: &[f32],
        m: &[f32],
        v: &[f32],
        shape: &[usize],
        device: &Device,
    ) -> Result<Self, NetsError> {
        let tensor = |values: &[f32]| Tensor::from_slice(values, shape, device);
        Ok(Self { value: Var::from_tensor(&tensor(value)?)?, m: tensor(m)?, v: tensor(v)? })
    }

    /// Adam as in [`AdamStep`], on tensors.
    fn change(&mut self, gradient: &Tensor, adam: &AdamStep) -> Result<(), NetsError> {
        let (beta_1, beta_2) = (f64::from(BETA_1), f64::from(BETA_2));
        let w = self.value.as_tensor().detach();
        let mut g = gradient.detach();
        if adam.decay > 0.0 {
            g = (g + w.affine(f64::from(adam.decay), 0.0)?)?;
        }
        self.m = ((&self.m * beta_1)? + (&g * (1.0 - beta_1))?)?;
        self.v = ((&self.v * beta_2)? + (g.sqr()? * (1.0 - beta_2))?)?;
        let divisor = (self.v.sqrt()? + f64::from(adam.epsilon))?;
        let step = (self.m.div(&divisor)? * f64::from(adam.step_size))?;
        Ok(self.value.set(&(w - step)?)?)
    }
}

fn device(backend: TrainBackend) -> Result<Device, NetsError> {
    match backend {
        TrainBackend::Slices | TrainBackend::Candle => Ok(Device::Cpu),
        TrainBackend::Cuda { ordinal } => Device::new_cuda(ordinal)
            .map_err(|error| NetsError::NoGpu { ordinal, source: Box::new(error) }),
    }
}

fn values(tensor: &Tensor) -> Result<Vec<f32>, NetsError> {
    Ok(tensor.flatten_all()?.to_vec1()?)
}
