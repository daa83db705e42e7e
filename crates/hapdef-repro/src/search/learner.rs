//! A method with its settings, fitted to samples in memory: what the search and the outside check
//! vary.

use std::ops::ControlFlow;

use hapdef_data::{Standardiser, StandardiserFit};
use hapdef_nets::train::{BatchSource, Progress, SourceError, train};
use hapdef_nets::{Activation, Mlp, MlpSpec, Net, Scale, Scratch, TrainParams};
use hapdef_report::check_len;
use rayon::prelude::*;

use crate::baselines::{
    Knn, KnnParams, LinearAccumulator, LinearParams, LinearRegression, OwnRow, Svr, SvrParams,
};
use crate::error::{ReproError, check_finite, whole_rows};

/// Rows that are added to a linear regression, or predicted by nearest neighbours, together.
const BLOCK: usize = 512;
/// Rows that one thread sends through a net.
const NET_ROWS: usize = 32;

/// Inputs and outputs of samples, in raw units.
#[derive(Clone, Copy, Debug)]
pub struct Samples<'a> {
    /// Inputs `[n, n_inputs]`, row-major.
    pub x: &'a [f32],
    /// Values in a row of `x`.
    pub n_inputs: usize,
    /// Outputs `[n, n_outputs]`, row-major.
    pub y: &'a [f32],
    /// Values in a row of `y`.
    pub n_outputs: usize,
}

/// A method and its settings.
#[derive(Clone, Debug, PartialEq)]
pub enum Learner {
    /// Linear regression.
    Linear(LinearParams),
    /// k nearest neighbours on standardised inputs, weights 1/distance.
    Knn {
        /// Neighbours.
        k: usize,
    },
    /// Support-vector regression.
    Svr(SvrParams),
    /// A fully connected net.
    Net(NetSettings),
}

/// A net and its training.
#[derive(Clone, Debug, PartialEq)]
pub struct NetSettings {
    /// Neurons of every hidden layer.
    pub hidden: Vec<usize>,
    /// What hidden neurons do.
    pub activation: Activation,
    /// How it is trained.
    pub training: TrainParams,
}

/// A method after its fit.
#[derive(Clone, Debug)]
pub enum Fitted {
    /// Linear regression.
    Linear(LinearRegression),
    /// The training samples, ready to be looked up.
    Knn(Box<FittedKnn>),
    /// Support-vector machines and the samples that they were trained on.
    Svr(Box<Svr>, usize),
    /// A trained net.
    Net(Box<Net>),
}

/// Nearest neighbours with the outputs of the training samples.
#[derive(Clone, Debug)]
pub struct FittedKnn {
    knn: Knn,
    k: usize,
    standardiser: Standardiser,
    y: Vec<f32>,
    n_outputs: usize,
}

impl Learner {
    /// Fits the method; where `stop` says so, a training ends with [`ReproError::Stopped`].
    pub fn fit(
        &self,
        samples: &Samples<'_>,
        stop: &dyn Fn() -> bool,
    ) -> Result<Fitted, ReproError> {
        samples.check()?;
        match self {
            Self::Linear(params) => fit_linear(samples, params).map(Fitted::Linear),
            Self::Knn { k } => FittedKnn::new(samples, *k).map(|knn| Fitted::Knn(Box::new(knn))),
            Self::Svr(params) => {
                let Samples { x, y, .. } = *samples;
                let (svr, info) = Svr::train(x, y, samples.n_inputs, samples.n_outputs, params)?;
                Ok(Fitted::Svr(Box::new(svr), info.n_trained))
            }
            Self::Net(settings) => {
                fit_net(samples, settings, stop).map(|net| Fitted::Net(Box::new(net)))
            }
        }
    }
}

impl Fitted {
    /// Predicts `out` `[n, n_outputs]` for `x` `[n, n_inputs]`, raw units, row-major.
    pub fn predict(&self, x: &[f32], out: &mut [f32]) -> Result<(), ReproError> {
        self.predict_own(x, OwnRow::None, out)
    }

    /// The same for training samples; nearest neighbours leave a sample itself out.
    pub fn predict_own(&self, x: &[f32], own: OwnRow, out: &mut [f32]) -> Result<(), ReproError> {
        match self {
            Self::Linear(regression) => regression.predict(x, out)?,
            Self::Knn(knn) => knn.predict(x, own, out)?,
            Self::Svr(svr, _) => svr.predict(x, out)?,
            Self::Net(net) => predict_net(net, x, out)?,
        }
        check_finite("predictions", self.n_outputs(), out)
    }

    /// The same for `n` rows, in a vector of its own.
    pub fn predictions(&self, x: &[f32], n: usize) -> Result<Vec<f32>, ReproError> {
        let mut out = vec![0.0; n * self.n_outputs()];
        self.predict(x, &mut out)?;
        Ok(out)
    }

    /// Bytes of what it keeps in memory.
    pub fn bytes(&self) -> usize {
        size_of::<f32>()
            * match self {
                Self::Linear(regression) => (regression.n_inputs() + 1) * regression.n_outputs(),
                Self::Knn(knn) => knn.y.len() + knn.knn.n_rows() * knn.standardiser.width(),
                Self::Svr(svr, n_trained) => n_trained * svr.n_outputs(),
                Self::Net(net) => net.mlp().spec().n_parameters(),
            }
    }

    fn n_outputs(&self) -> usize {
        match self {
            Self::Linear(regression) => regression.n_outputs(),
            Self::Knn(knn) => knn.n_outputs,
            Self::Svr(svr, _) => svr.n_outputs(),
            Self::Net(net) => net.mlp().spec().outputs,
        }
    }
}

impl Samples<'_> {
    /// Number of samples.
    pub fn n(&self) -> usize {
        self.x.len() / self.n_inputs.max(1)
    }

    fn check(&self) -> Result<(), ReproError> {
        let n = whole_rows("inputs of samples", self.n_inputs, self.x.len())?;
        Ok(check_len("outputs of samples", n * self.n_outputs, self.y.len())?)
    }
}

/// A net's outputs `[n, outputs]` for rows `x` `[n, inputs]`, in parallel.
pub fn forward(net: &Net, x: &[f32]) -> Result<Vec<f32>, ReproError> {
    let spec = net.mlp().spec();
    let mut out = vec![0.0; x.len() / spec.inputs.max(1) * spec.outputs];
    predict_net(net, x, &mut out)?;
    Ok(out)
}

fn fit_linear(
    samples: &Samples<'_>,
    params: &LinearParams,
) -> Result<LinearRegression, ReproError> {
    let (n_in, n_out) = (samples.n_inputs, samples.n_outputs);
    let mut sums = LinearAccumulator::new(n_in, n_out);
    let blocks = samples.x.chunks(BLOCK * n_in);
    for (x, y) in blocks.zip(samples.y.chunks(BLOCK * n_out)) {
        sums.add_block(x, y)?;
    }
    Ok(sums.solve(params)?.0)
}

impl FittedKnn {
    fn new(samples: &Samples<'_>, k: usize) -> Result<Self, ReproError> {
        let standardiser = standardiser(samples.x, samples.n_inputs)?;
        let mut x = samples.x.to_vec();
        standardiser.apply(&mut x)?;
        check_finite("k-NN training outputs", samples.n_outputs, samples.y)?;
        Ok(Self {
            knn: Knn::new(&x, samples.n_inputs)?,
            k,
            standardiser,
            y: samples.y.to_vec(),
            n_outputs: samples.n_outputs,
        })
    }

    fn predict(&self, x: &[f32], own: OwnRow, out: &mut [f32]) -> Result<(), ReproError> {
        let (n_in, n_out) = (self.standardiser.width(), self.n_outputs);
        let n = whole_rows("k-NN queries", n_in, x.len())?;
        check_len("k-NN predictions", n * n_out, out.len())?;
        check_finite("k-NN queries", n_in, x)?;
        let blocks = x.chunks(BLOCK * n_in).zip(out.chunks_mut(BLOCK * n_out));
        for (block, (x, out)) in blocks.enumerate() {
            let mut x = x.to_vec();
            self.standardiser.apply(&mut x)?;
            let own_row = match own {
                OwnRow::None => own,
                OwnRow::Exclude { first } => OwnRow::Exclude { first: first + block * BLOCK },
            };
            let found = self.knn.neighbours(&x, &KnnParams { k: self.k, own_row })?;
            let rows = out.par_chunks_mut(n_out).enumerate();
            rows.for_each(|(query, out)| found.predict(query, &self.y, out));
        }
        Ok(())
    }
}

fn fit_net(
    samples: &Samples<'_>,
    settings: &NetSettings,
    stop: &dyn Fn() -> bool,
) -> Result<Net, ReproError> {
    let spec = MlpSpec {
        inputs: samples.n_inputs,
        hidden: settings.hidden.clone(),
        outputs: samples.n_outputs,
        activation: settings.activation,
    };
    let mlp = Mlp::random(&spec, settings.training.seed).map_err(ReproError::Nets)?;
    let input = standardiser(samples.x, samples.n_inputs)?;
    let output = standardiser(samples.y, samples.n_outputs)?;
    let [input, output] = [input, output].map(|s| Scale::new(s.mean, s.std));
    let (input, output) = (input.map_err(ReproError::Nets)?, output.map_err(ReproError::Nets)?);
    let mut net = Net::new(mlp, input, output).map_err(ReproError::Nets)?;
    let mut rows = *samples;
    let on_progress = &mut |_: &Progress| match stop() {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    };
    let params = &settings.training;
    let info =
        train(&mut net, &mut rows, None, params, None, on_progress).map_err(ReproError::Nets)?;
    if info.stopped_early {
        return Err(ReproError::Stopped);
    }
    Ok(net)
}

fn standardiser(rows: &[f32], width: usize) -> Result<Standardiser, ReproError> {
    let mut fit = StandardiserFit::new(width);
    fit.push(rows)?;
    Ok(fit.finish()?.0)
}

fn predict_net(net: &Net, x: &[f32], out: &mut [f32]) -> Result<(), ReproError> {
    let spec = net.mlp().spec();
    let n = whole_rows("inputs of a net", spec.inputs, x.len())?;
    check_len("predictions of a net", n * spec.outputs, out.len())?;
    check_finite("inputs of a net", spec.inputs, x)?;
    out.par_chunks_mut(NET_ROWS * spec.outputs)
        .zip(x.par_chunks(NET_ROWS * spec.inputs))
        .try_for_each_init(Scratch::default, |scratch, (out, x)| net.forward_batch(x, scratch, out))
        .map_err(ReproError::Nets)
}

impl BatchSource for Samples<'_> {
    fn n_samples(&self) -> usize {
        self.n()
    }

    fn n_inputs(&self) -> usize {
        self.n_inputs
    }

    fn n_outputs(&self) -> usize {
        self.n_outputs
    }

    fn fill(&mut self, rows: &[usize], x: &mut [f32], y: &mut [f32]) -> Result<(), SourceError> {
        let copy = |all: &[f32], width: usize, out: &mut [f32]| {
            for (row, out) in rows.iter().zip(out.chunks_exact_mut(width)) {
                out.copy_from_slice(&all[row * width..(row + 1) * width]);
            }
        };
        copy(self.x, self.n_inputs, x);
        copy(self.y, self.n_outputs, y);
        Ok(())
    }
}
