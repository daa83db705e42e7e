//! The rows of weights in fewer bits: a trained net, prepared, against the same net in f64.

use hapdef_nets::infer::{InferParams, Precision, PreparedNet};
use hapdef_nets::{Activation, Layer, Mlp, Net};
use hapdef_report::robustness::Expected;

use super::plant::{N_OUT, Plant, largest_difference, net};
use super::table::{MustHold, Rows, Trial};
use crate::error::ReproError;
use crate::search::{Fitted, Learner};

/// Test samples that a row looks at.
const N_ROWS: usize = 20;

/// The precisions that lose something.
const PRECISIONS: [Precision; 2] = [Precision::Int8Weights, Precision::Int8];

const IN_BOUND: MustHold = ("outputs within the stated bound", 1.0);

/// A trained net in a precision.
#[derive(Clone, Copy)]
struct On {
    seed: u64,
    precision: Precision,
}

/// Every row.
pub(super) fn trials(seed: u64) -> impl Iterator<Item = Trial> {
    PRECISIONS.into_iter().flat_map(move |precision| {
        let mut rows = Rows::new(precision.name(), On { seed, precision });
        trained(&mut rows);
        changed_weights(&mut rows);
        far_inputs(&mut rows);
        refused(&mut rows);
        rows.into_trials()
    })
}

fn trained(rows: &mut Rows<On>) {
    let holds = ("error at most 1.1 × that in 32 bits", 1.1);
    rows.accurate("a trained net", holds, |on| {
        let plant = Plant::new(on.seed);
        let net = trained_net(&plant, &net(3e-3))?;
        let in_32 = apart(&plant.test_y, &outputs(&net, Precision::F32, &plant.test_x)?);
        let found = outputs(&net, on.precision, &plant.test_x)?;
        Ok(apart(&plant.test_y, &found) / in_32)
    });
    let extreme = "a channel constant in training moves later";
    rows.accurate(extreme, ("predictions do not move", 0.0), |on| {
        let still = Plant::new(on.seed).with_inputs(|x| [x, &[100.0]].concat());
        let mut moved = still.test_x.clone();
        moved.iter_mut().skip(4).step_by(5).for_each(|x| *x = 1e30);
        let net = trained_net(&still, &net(3e-3))?;
        let still = outputs(&net, on.precision, &still.test_x)?;
        Ok(largest_difference(&still, &outputs(&net, on.precision, &moved)?))
    });
    for activation in [Activation::Relu, Activation::Tanh] {
        rows.accurate(format!("a trained net of {activation:?}"), IN_BOUND, move |on| {
            on.in_bound(activation, |_| {}, |_| {})
        });
    }
}

fn changed_weights(rows: &mut Rows<On>) {
    type Change = fn(&mut [Layer]);
    let changes: [(&str, Expected, Change); 9] = [
        ("one weight × 1e6, first layer", Expected::Result, |l| l[0].weights[9] *= 1e6),
        ("one weight × 1e6, hidden layer", Expected::Result, |l| l[1].weights[99] *= 1e6),
        ("one weight × 1e6, last layer", Expected::Result, |l| l[2].weights[9] *= 1e6),
        ("one weight × 1e30, hidden layer", Expected::Either, |l| l[1].weights[99] *= 1e30),
        ("one weight 3e38", Expected::Either, |l| l[1].weights[99] = f32::MAX),
        ("every weight × 1e-40", Expected::Result, |l| times(l, 1e-40)),
        ("last layer × 1e-44", Expected::Result, |l| times(&mut l[2..], 1e-44)),
        ("every weight 0", Expected::Result, |l| times(l, 0.0)),
        ("a neuron of weights 0", Expected::Result, |l| l[1].weights[..32].fill(0.0)),
    ];
    for (extreme, expected, change) in changes {
        rows.add(extreme, IN_BOUND, expected, move |on| {
            on.in_bound(Activation::Relu, change, |_| {})
        });
    }
}

fn far_inputs(rows: &mut Rows<On>) {
    for activation in [Activation::Relu, Activation::Tanh] {
        for value in [1e-40_f32, 1e3, 1e6, 1e12, 1e30, f32::MAX] {
            let extreme = format!("a channel at {value:.0e}, {activation:?}");
            rows.either(extreme, IN_BOUND, move |on| {
                let set = |x: &mut [f32]| x.iter_mut().step_by(4).for_each(|x| *x = value);
                on.in_bound(activation, |_| {}, set)
            });
        }
    }
}

fn refused(rows: &mut Rows<On>) {
    for value in [f32::NAN, f32::INFINITY] {
        let (holds, words) = ("refused with row and column", "row 0, column 2");
        rows.refused(format!("a channel is {value}"), holds, words, move |on| {
            on.in_bound(Activation::Relu, |_| {}, |x| x[2] = value)
        });
        rows.refused(format!("a weight is {value}"), "refused", "weights of a layer", move |on| {
            on.in_bound(Activation::Relu, |l| l[1].weights[99] = value, |_| {})
        });
    }
}

fn times(layers: &mut [Layer], factor: f32) {
    let weights = layers.iter_mut().flat_map(|layer| &mut layer.weights);
    weights.for_each(|w| *w *= factor);
}

impl On {
    /// The largest error over its bound, of a trained net with changed weights on changed inputs.
    fn in_bound(
        self,
        activation: Activation,
        change: impl Fn(&mut [Layer]),
        set: impl Fn(&mut [f32]),
    ) -> Result<f64, ReproError> {
        let mut plant = Plant::new(self.seed);
        let mut learner = net(3e-3);
        if let Learner::Net(settings) = &mut learner {
            settings.activation = activation;
        }
        let net = with_layers(&trained_net(&plant, &learner)?, change)?;
        plant.test_x.truncate(N_ROWS * plant.n_in);
        set(&mut plant.test_x);
        let found = outputs(&net, self.precision, &plant.test_x)?;
        let mut worst = 0.0_f64;
        let rows = plant.test_x.chunks_exact(plant.n_in);
        for (x, found) in rows.zip(found.chunks_exact(N_OUT)) {
            let exact = with_bound(&net, self.precision, x);
            for ((exact, bound), found) in exact.iter().zip(found) {
                let share = (f64::from(*found) - exact).abs() / bound;
                worst = if share.is_nan() { share } else { worst.max(share) };
            }
        }
        Ok(worst)
    }
}

fn trained_net(plant: &Plant, learner: &Learner) -> Result<Net, ReproError> {
    match learner.fit(&plant.samples(), &|| false)? {
        Fitted::Net(net) => Ok(*net),
        _ => Err(ReproError::Stopped),
    }
}

fn with_layers(net: &Net, change: impl Fn(&mut [Layer])) -> Result<Net, ReproError> {
    let mut layers = net.mlp().layers().to_vec();
    change(&mut layers);
    let mlp = Mlp::from_layers(net.mlp().spec(), layers).map_err(ReproError::Nets)?;
    Net::new(mlp, net.input_scale().clone(), net.output_scale().clone()).map_err(ReproError::Nets)
}

/// Outputs of the prepared net, `[n, outputs]`.
fn outputs(net: &Net, precision: Precision, x: &[f32]) -> Result<Vec<f32>, ReproError> {
    let prepared = PreparedNet::new(net, &InferParams::of(precision)).map_err(ReproError::Nets)?;
    let mut scratch = prepared.scratch();
    let mut out = vec![0.0; x.len() / prepared.n_inputs() * prepared.n_outputs()];
    let rows = x.chunks_exact(prepared.n_inputs());
    for (x, out) in rows.zip(out.chunks_exact_mut(prepared.n_outputs())) {
        prepared.forward(x, &mut scratch, out).map_err(ReproError::Nets)?;
    }
    Ok(out)
}

fn apart(a: &[f32], b: &[f32]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2));
    (squares.sum::<f64>() / a.len() as f64).sqrt()
}

/// Outputs in f64 and how far `precision` may be off by its documentation ([`Precision`]), layer by
/// layer, with the rounding of sums in f32.
fn with_bound(net: &Net, precision: Precision, x: &[f32]) -> Vec<(f64, f64)> {
    let scale = net.input_scale();
    let standardised = |i: usize| f64::from((x[i] - scale.mean()[i]) / scale.std()[i]);
    let mut a: Vec<(f64, f64)> = (0..x.len()).map(|i| (standardised(i), 0.0)).collect();
    let (spec, last) = (net.mlp().spec(), net.mlp().layers().len() - 1);
    for (l, layer) in net.mlp().layers().iter().enumerate() {
        let largest = a.iter().fold(0.0_f64, |m, (v, e)| m.max(v.abs() + e));
        let step = match (precision, spec.activation) {
            (Precision::Int8, Activation::Tanh) if l > 0 => largest / 127.0,
            (Precision::Int8, Activation::Relu) if l > 0 => largest / 255.0,
            (Precision::Int8Weights, Activation::Tanh) if l > 0 => largest / 32_767.0,
            (Precision::Int8Weights, Activation::Relu) if l > 0 => largest / 65_535.0,
            _ => 0.0,
        };
        let rows = layer.weights.chunks_exact(a.len()).zip(&layer.bias);
        let sums = rows.map(|(row, bias)| sum_with_bound(precision, row, *bias, &a, step));
        a = match spec.activation {
            _ if l == last => sums.collect(),
            Activation::Relu => sums.map(|(z, e)| (z.max(0.0), e)).collect(),
            Activation::Tanh => sums.map(|(z, e)| (z.tanh(), e.min(2.0) + 3e-7)).collect(),
        };
    }
    let scale = net.output_scale();
    let raw = a.iter().zip(scale.mean().iter().zip(scale.std()));
    raw.map(|((z, e), (mean, std))| {
        let value = z * f64::from(*std) + f64::from(*mean);
        (value, e * f64::from(*std) + 1e-6 * value.abs() + 1e-7)
    })
    .collect()
}

/// A neuron's sum and its bound, for inputs with theirs that are stored in steps of `step`.
fn sum_with_bound(
    precision: Precision,
    row: &[f32],
    bias: f32,
    inputs: &[(f64, f64)],
    step: f64,
) -> (f64, f64) {
    let largest = row.iter().fold(0.0_f64, |m, w| m.max(f64::from(w.abs())));
    let (mut z, mut size, mut error) = (f64::from(bias), f64::from(bias.abs()), 0.0);
    for (w, (x, e)) in row.iter().map(|w| f64::from(*w)).zip(inputs) {
        let dw = match precision {
            Precision::F32 => 0.0,
            Precision::Int8Weights | Precision::Int8 => largest / 254.0 + 1e-44,
        };
        let dx = e + step / 2.0;
        z += w * x;
        size += w.abs() * (x.abs() + dx);
        error += w.abs() * dx + dw * (x.abs() + dx);
    }
    let rounding = 4e-7 * size * (row.len() as f64).sqrt().max(2.0) + 1e-37;
    (z, error + rounding)
}
