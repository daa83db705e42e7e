//! Nets and passes that the tests share.

use hapdef_nets::infer::{InferParams, Precision, PreparedNet, SimdLevel};
use hapdef_nets::{Activation, Layer, Mlp, MlpSpec, Net, Scale, Scratch};

pub(crate) fn random_net(widths: &[usize], activation: Activation, seed: u64) -> Net {
    let spec = MlpSpec {
        inputs: widths[0],
        hidden: widths[1..widths.len() - 1].to_vec(),
        outputs: widths[widths.len() - 1],
        activation,
    };
    let mut layers = Mlp::random(&spec, seed).unwrap().layers().to_vec();
    for layer in &mut layers {
        for (i, bias) in layer.bias.iter_mut().enumerate() {
            *bias = 0.1 * (i as f32 + seed as f32 * 1e-6).sin();
        }
    }
    net_of(&spec, layers)
}

pub(crate) fn net_of(spec: &MlpSpec, layers: Vec<Layer>) -> Net {
    let mlp = Mlp::from_layers(spec, layers).unwrap();
    let input = Scale::new(vec![0.3; spec.inputs], vec![2.0; spec.inputs]).unwrap();
    let output = Scale::new(vec![-1.0; spec.outputs], vec![0.5; spec.outputs]).unwrap();
    Net::new(mlp, input, output).unwrap()
}

pub(crate) fn inputs(n: usize, seed: u64) -> Vec<f32> {
    let phase = (seed % 1000) as f32;
    (0..n).map(|i| 3.0 * (i as f32 * 1.3 + phase).sin()).collect()
}

pub(crate) fn plain(net: &Net, x: &[f32]) -> Vec<f32> {
    let mut out = vec![0.0; net.mlp().spec().outputs];
    net.forward(x, &mut Scratch::default(), &mut out).unwrap();
    out
}

pub(crate) fn prepared(net: &Net, params: &InferParams, x: &[f32]) -> Vec<f32> {
    let prepared = PreparedNet::new(net, params).unwrap();
    let mut out = vec![0.0; prepared.n_outputs()];
    prepared.forward(x, &mut prepared.scratch(), &mut out).unwrap();
    out
}

pub(crate) fn at(precision: Precision, simd: SimdLevel) -> InferParams {
    InferParams { simd: Some(simd), ..InferParams::of(precision) }
}

pub(crate) fn largest(values: &[f32]) -> f64 {
    values.iter().fold(0.0, |m, v| f64::from(v.abs()).max(m))
}
