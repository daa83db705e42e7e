//! What a prepared net may be off by.

use hapdef_nets::infer::Precision;
use hapdef_nets::{Activation, Net};

/// The outputs in f64 and the stated error bound of `precision` for each, in raw units.
pub(crate) fn with_bound(net: &Net, precision: Precision, x: &[f32]) -> Vec<(f64, f64)> {
    let scale = net.input_scale();
    let mut a: Vec<(f64, f64)> =
        (0..x.len()).map(|i| (f64::from((x[i] - scale.mean()[i]) / scale.std()[i]), 0.0)).collect();
    let last = net.mlp().layers().len() - 1;
    for (l, layer) in net.mlp().layers().iter().enumerate() {
        // What the bytes are made of: the approximate activations.
        let largest = a.iter().fold(0.0f64, |m, (v, e)| m.max(v.abs() + e));
        let is_signed = net.mlp().spec().activation == Activation::Tanh;
        let step = match precision {
            Precision::Int8 if l > 0 => largest / if is_signed { 127.0 } else { 255.0 },
            Precision::Int8Weights if l > 0 => largest / if is_signed { 32767.0 } else { 65535.0 },
            _ => 0.0,
        };
        let rows = layer.weights.chunks(a.len()).zip(&layer.bias);
        a = rows
            .map(|(row, &bias)| {
                let row_max = row.iter().fold(0.0f64, |m, w| m.max(f64::from(w.abs())));
                let (mut z, mut error, mut size) = (f64::from(bias), 0.0, f64::from(bias.abs()));
                for (&w, (x, e)) in row.iter().zip(&a) {
                    let w = f64::from(w);
                    let dw = match precision {
                        Precision::F32 => 0.0,
                        _ => row_max / 254.0 + 1e-44,
                    };
                    let dx = e + step / 2.0;
                    z += w * x;
                    size += w.abs() * (x.abs() + dx);
                    error += w.abs() * dx + dw * (x.abs() + dx);
                }
                // Rounding of f32 sums and products.
                error += 4e-7 * size * (row.len() as f64).sqrt().max(2.0) + 1e-37;
                match net.mlp().spec().activation {
                    _ if l == last => (z, error),
                    Activation::Tanh => (z.tanh(), error.min(2.0) + 3e-7),
                    Activation::Relu => (z.max(0.0), error),
                }
            })
            .collect();
    }
    let scale = net.output_scale();
    a.iter()
        .enumerate()
        .map(|(i, (z, e))| {
            let (mean, std) = (f64::from(scale.mean()[i]), f64::from(scale.std()[i]));
            (z * std + mean, e * std + 1e-6 * (z * std + mean).abs() + 1e-7)
        })
        .collect()
}
