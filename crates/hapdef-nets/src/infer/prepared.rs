//! A net that is laid out for fast single passes.

use crate::activation::Activation;
use crate::error::{NetsError, check_finite, check_inputs, check_length};
use crate::mlp::Layer;
use crate::net::{Net, Scale};

use super::kernels::Isa;
use super::layer::{InputBytes, MOST_BYTE_INPUTS, PreparedLayer, Product};
use super::params::{InferParams, Precision};
use super::scratch::LayerScratch;
use super::simd_level::SimdLevel;

/// A [`Net`] for inference: raw units in, raw units of the wanted outputs out.
#[derive(Debug, Clone)]
pub struct PreparedNet {
    layers: Vec<PreparedLayer>,
    input: Scale,
    output: Scale,
    isa: Isa,
    level: SimdLevel,
}

/// Buffers of a pass; keep one per thread. One from [`PreparedNet::scratch`] never grows.
#[derive(Debug, Clone, Default)]
pub struct InferScratch {
    layer: LayerScratch,
}

/// What a pass did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct InferInfo {
    /// Bytes of weights that were read; those of inputs that are 0 were not.
    pub weight_bytes: usize,
}

impl PreparedNet {
    /// Lays a net out.
    ///
    /// Fails on a wanted output, or a layer of low rank, that the net does not have; on a layer of
    /// low rank whose widths are not those of the layer it replaces; on weights that are not finite;
    /// on instructions that the processor lacks; and with [`Precision::Int8`] on a layer of more
    /// than 44,000 inputs, whose sums might not fit 32 bits.
    pub fn new(net: &Net, params: &InferParams) -> Result<Self, NetsError> {
        let level = params.simd.unwrap_or_else(SimdLevel::best);
        let isa = Isa::new(level)?;
        let output = match &params.wanted {
            Some(wanted) => wanted_scale(net.output_scale(), wanted)?,
            None => net.output_scale().clone(),
        };
        let steps = steps(net, params)?;
        let last = steps.len() - 1;
        let layers = steps.iter().enumerate().map(|(i, (layer, activation))| {
            check_finite("weights of a layer", &layer.weights)?;
            check_finite("biases of a layer", &layer.bias)?;
            let product = product(params.precision, level, i, layer);
            let wanted = params.wanted.as_deref().filter(|_| i == last);
            PreparedLayer::new(layer, product, *activation, wanted)
        });
        Ok(Self {
            layers: layers.collect::<Result<_, NetsError>>()?,
            input: net.input_scale().clone(),
            output,
            isa,
            level,
        })
    }

    /// Numbers in.
    pub fn n_inputs(&self) -> usize {
        self.input.width()
    }

    /// Numbers out: the wanted ones.
    pub fn n_outputs(&self) -> usize {
        self.output.width()
    }

    /// Bytes of all weights, biases and scales, filling at the ends of rows included.
    pub fn bytes(&self) -> usize {
        self.layers.iter().map(PreparedLayer::bytes).sum()
    }

    /// The instructions in use.
    pub fn simd(&self) -> SimdLevel {
        self.level
    }

    /// Buffers that are large enough: passes with them allocate nothing.
    pub fn scratch(&self) -> InferScratch {
        let mut scratch = InferScratch::default();
        for layer in &self.layers {
            layer.reserve(&mut scratch.layer);
        }
        scratch
    }

    /// One sample in raw units: `x` is `[inputs]`, `out` is `[wanted outputs]`.
    ///
    /// Fails on slices of another length, on an input that is NaN or infinite, and where a sum
    /// inside leaves the range of f32, which a ReLU might hide. `out` is then not to be used.
    pub fn forward(
        &self,
        x: &[f32],
        scratch: &mut InferScratch,
        out: &mut [f32],
    ) -> Result<InferInfo, NetsError> {
        check_length("input of a net", self.n_inputs(), x.len())?;
        check_length("output of a net", self.n_outputs(), out.len())?;
        check_inputs(self.n_inputs(), x)?;
        let scratch = &mut scratch.layer;
        scratch.values.clear();
        scratch.values.resize(x.len().div_ceil(16), [0.0; 16]);
        let values = &mut scratch.values.as_flattened_mut()[..x.len()];
        values.copy_from_slice(x);
        self.input.apply(values);
        check_range(0, values)?;
        let mut weight_bytes = 0;
        for (i, layer) in self.layers.iter().enumerate() {
            weight_bytes += layer.pass(self.isa, scratch);
            if !scratch.extent.is_finite() {
                check_range(i + 1, &scratch.values.as_flattened()[..layer.n_out()])?;
            }
        }
        out.copy_from_slice(&scratch.values.as_flattened()[..out.len()]);
        self.output.invert(out);
        Ok(InferInfo { weight_bytes })
    }
}

/// How layer `i` multiplies. The first keeps the f32 of its inputs.
fn product(precision: Precision, level: SimdLevel, i: usize, layer: &Layer) -> Product {
    let has_byte_sums = level == SimdLevel::Avx512Vnni;
    let fits = layer.weights.len() / layer.bias.len() <= MOST_BYTE_INPUTS;
    match precision {
        Precision::F32 => Product::F32,
        Precision::Int8 if i > 0 => Product::Bytes(InputBytes::One),
        Precision::Int8Weights if i > 0 && has_byte_sums && fits => Product::Bytes(InputBytes::Two),
        Precision::Int8Weights | Precision::Int8 => Product::Int8,
    }
}

/// The layers in order, each with what follows it; layers of low rank in two steps.
fn steps(net: &Net, params: &InferParams) -> Result<Vec<(Layer, Option<Activation>)>, NetsError> {
    let mlp = net.mlp();
    let n_layers = mlp.layers().len();
    for low_rank in &params.low_rank {
        if low_rank.layer() >= n_layers {
            return Err(NetsError::NoSuchLayer { layer: low_rank.layer(), n_layers });
        }
    }
    let mut steps = Vec::with_capacity(n_layers + params.low_rank.len());
    for (i, layer) in mlp.layers().iter().enumerate() {
        let activation = (i + 1 < n_layers).then_some(mlp.spec().activation);
        match params.low_rank.iter().find(|l| l.layer() == i) {
            Some(low_rank) => {
                let [reduce, expand] = low_rank.layers();
                let n_in = layer.weights.len() / layer.bias.len();
                let rank = reduce.bias.len();
                check_length("weights of a low rank", rank * n_in, reduce.weights.len())?;
                check_length("outputs of a low rank", layer.bias.len(), expand.bias.len())?;
                steps.push((reduce.clone(), None));
                steps.push((expand.clone(), activation));
            }
            None => steps.push((layer.clone(), activation)),
        }
    }
    Ok(steps)
}

fn wanted_scale(scale: &Scale, wanted: &[usize]) -> Result<Scale, NetsError> {
    let n_outputs = scale.width();
    if wanted.is_empty() {
        return Err(NetsError::NoOutputs);
    }
    if let Some(&output) = wanted.iter().find(|&&output| output >= n_outputs) {
        return Err(NetsError::NoSuchOutput { output, n_outputs });
    }
    let pick = |values: &[f32]| wanted.iter().map(|&output| values[output]).collect();
    Scale::new(pick(scale.mean()), pick(scale.std()))
}

/// Fails where a value left the range of f32. Without their signs, the bits of infinity and NaN are
/// the largest.
fn check_range(layer: usize, values: &[f32]) -> Result<(), NetsError> {
    let mut bits = 0;
    for value in values {
        bits = bits.max(value.to_bits() & 0x7fff_ffff);
    }
    if bits < f32::INFINITY.to_bits() {
        return Ok(());
    }
    let index = values.iter().position(|v| !v.is_finite()).unwrap_or(0);
    Err(NetsError::Overflow { layer, index, value: values[index] })
}
