//! The rows of weights in fewer bits: a trained net, prepared, against the same net in f64.

use hapdef_bench::robustness::{Expected, MustHold};
use hapdef_nets::infer::{InferParams, Precision, PreparedNet};
use hapdef_nets::{Activation, Layer, Mlp, Net};

use super::bound::with_bound;
use super::plant::{N_OUT, Plant, largest_difference, net, net_of};
use super::table::Trials;
use crate::error::ReproError;
use crate::search::Fitted;

/// Test samples that a row looks at.
const N_ROWS: usize = 20;

/// The precisions that lose something.
const PRECISIONS: [Precision; 2] = [Precision::Int8Weights, Precision::Int8];

const IN_BOUND: MustHold = ("outputs within the stated bound", 1.0);

/// Every row, in the table's order.
pub(super) fn add(rows: &mut Trials<Plant>, seed: u64) {
    rows.on(Plant::new(seed, net(3e-3)));
    for precision in PRECISIONS {
        rows.of(precision.name());
        trained(rows, precision);
        changed_weights(rows, precision);
        far_inputs(rows, precision);
        refused(rows, precision);
    }
}

fn trained(rows: &mut Trials<Plant>, precision: Precision) {
    let holds = ("error at most 1.1 × that in 32 bits", 1.1);
    rows.accurate("a trained net", holds, move |plant| {
        let net = trained_net(plant)?;
        let error = |precision| {
            outputs(&net, precision, &plant.test_x).map(|found| apart(&plant.test_y, &found))
        };
        Ok(error(precision)? / error(Precision::F32)?)
    });
    let extreme = "a channel constant in training moves later";
    rows.accurate(extreme, ("predictions do not move", 0.0), move |plant| {
        let still = plant.with_inputs(|x| [x, &[100.0]].concat());
        let mut moved = still.test_x.clone();
        moved.iter_mut().skip(4).step_by(5).for_each(|x| *x = 1e30);
        let net = trained_net(&still)?;
        let still = outputs(&net, precision, &still.test_x)?;
        Ok(largest_difference(&still, &outputs(&net, precision, &moved)?))
    });
    for activation in [Activation::Relu, Activation::Tanh] {
        rows.accurate(format!("a trained net of {activation:?}"), IN_BOUND, move |plant| {
            in_bound(plant, precision, activation, |_| {}, |_| {})
        });
    }
}

fn changed_weights(rows: &mut Trials<Plant>, precision: Precision) {
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
        rows.add(extreme, IN_BOUND, expected, move |plant| {
            in_bound(plant, precision, Activation::Relu, change, |_| {})
        });
    }
}

fn far_inputs(rows: &mut Trials<Plant>, precision: Precision) {
    for activation in [Activation::Relu, Activation::Tanh] {
        for value in [1e-40_f32, 1e3, 1e6, 1e12, 1e30, f32::MAX] {
            let extreme = format!("a channel at {value:.0e}, {activation:?}");
            rows.either(extreme, IN_BOUND, move |plant| {
                let set = |x: &mut [f32]| x.iter_mut().step_by(4).for_each(|x| *x = value);
                in_bound(plant, precision, activation, |_| {}, set)
            });
        }
    }
}

fn refused(rows: &mut Trials<Plant>, precision: Precision) {
    for value in [f32::NAN, f32::INFINITY] {
        let (holds, words) = ("refused with row and column", "row 0, column 2");
        rows.refused(format!("a channel is {value}"), holds, words, move |plant| {
            in_bound(plant, precision, Activation::Relu, |_| {}, |x| x[2] = value)
        });
        let spoil = move |layers: &mut [Layer]| layers[1].weights[99] = value;
        rows.refused(
            format!("a weight is {value}"),
            "refused",
            "weights of a layer",
            move |plant| in_bound(plant, precision, Activation::Relu, spoil, |_| {}),
        );
    }
}

fn times(layers: &mut [Layer], factor: f32) {
    let weights = layers.iter_mut().flat_map(|layer| &mut layer.weights);
    weights.for_each(|w| *w *= factor);
}

/// The largest error over its bound, of a trained net with changed weights on changed inputs.
fn in_bound(
    plant: &Plant,
    precision: Precision,
    activation: Activation,
    change: impl Fn(&mut [Layer]),
    set: impl Fn(&mut [f32]),
) -> Result<f64, ReproError> {
    let net = trained_net(&plant.by(net_of(activation, 3e-3)))?;
    let net = with_layers(&net, change)?;
    let mut x = plant.test_x[..N_ROWS * plant.n_in].to_vec();
    set(&mut x);
    let found = outputs(&net, precision, &x)?;
    let mut worst = 0.0_f64;
    for (x, found) in x.chunks_exact(plant.n_in).zip(found.chunks_exact(N_OUT)) {
        let exact = with_bound(&net, precision, x);
        for ((exact, bound), found) in exact.iter().zip(found) {
            let share = (f64::from(*found) - exact).abs() / bound;
            worst = if share.is_nan() { share } else { worst.max(share) };
        }
    }
    Ok(worst)
}

fn trained_net(plant: &Plant) -> Result<Net, ReproError> {
    match plant.fitted()? {
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
