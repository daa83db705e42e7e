//! A net's scales inside its weights, for programs that know weights only.

use anyhow::Result;
use hapdef_nets::{Layer, Mlp, Net, Scale};

/// The same net with scales that change nothing: raw units are what its first layer takes and its
/// last one gives.
pub(super) fn without_scales(net: &Net) -> Result<Net> {
    let mut layers = net.mlp().layers().to_vec();
    if let Some(first) = layers.first_mut() {
        take_in(first, net.input_scale());
    }
    if let Some(last) = layers.last_mut() {
        give_out(last, net.output_scale());
    }
    let spec = net.mlp().spec();
    let [input, output] = [spec.inputs, spec.outputs].map(Scale::identity);
    Ok(Net::new(Mlp::from_layers(spec, layers)?, input, output)?)
}

/// W (x − mean)/std + b = (W/std) x + (b − (W/std) mean).
fn take_in(layer: &mut Layer, scale: &Scale) {
    let rows = layer.weights.chunks_exact_mut(scale.width());
    for (row, bias) in rows.zip(&mut layer.bias) {
        let mut shift = 0.0;
        for ((w, mean), std) in row.iter_mut().zip(scale.mean()).zip(scale.std()) {
            let scaled = match *std > 0.0 {
                true => f64::from(*w) / f64::from(*std),
                false => 0.0,
            };
            shift += scaled * f64::from(*mean);
            *w = scaled as f32;
        }
        *bias = (f64::from(*bias) - shift) as f32;
    }
}

/// (W a + b) std + mean.
fn give_out(layer: &mut Layer, scale: &Scale) {
    let n_in = layer.weights.len() / scale.width();
    let rows = layer.weights.chunks_exact_mut(n_in).zip(&mut layer.bias);
    for ((row, bias), (mean, std)) in rows.zip(scale.mean().iter().zip(scale.std())) {
        row.iter_mut().for_each(|w| *w *= std);
        *bias = *bias * std + mean;
    }
}

#[cfg(test)]
mod tests {
    use hapdef_nets::{MlpSpec, Scratch};

    use super::*;

    #[test]
    fn the_outputs_stay_to_rounding() {
        let spec = MlpSpec::transfer(4, 3);
        let input = Scale::new(vec![1.0, -2.0, 30.0, 5.0], vec![0.5, 3.0, 10.0, 0.0]).unwrap();
        let output = Scale::new(vec![4.0, -9.0, 2.5], vec![2.0, 0.1, 0.0]).unwrap();
        let net = Net::new(Mlp::random(&spec, 3).unwrap(), input, output).unwrap();
        let plain = without_scales(&net).unwrap();
        let run = |net: &Net| {
            let mut out = [0.0; 3];
            let x = [1.3, 0.5, 17.0, 99.0];
            net.forward(&x, &mut Scratch::default(), &mut out).unwrap();
            out
        };
        for (a, b) in run(&net).iter().zip(run(&plain)) {
            assert!((a - b).abs() < 1e-5, "{a} {b}");
        }
    }
}
