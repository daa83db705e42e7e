//! Every method from readings to the map that the frontier compares.

use std::time::Instant;

use anyhow::{Context, Result};
use hapdef::stages::{Datasets, NetKind, TrainedNets};
use hapdef::{Limb, Pipeline, Run};
use hapdef_nets::Net;
use hapdef_nets::infer::{InferParams, LowRank, Precision, PreparedNet};

use super::clock::Times;
use super::methods::{Method, Passes};
use super::narrow::narrow;
use crate::baselines::LinearParams;
use crate::run::dataset::{Dataset, Rows};
use crate::search::Learner;

/// Hidden layers of narrow F_Rs.
const NARROW: [&[usize]; 3] = [&[256, 256, 64], &[400, 400, 128], &[600, 600, 128]];

/// Ranks of the last layer, and of the last two.
const RANKS: [usize; 3] = [32, 64, 128];
const RANK_OF_TWO: usize = 128;

/// Samples that tell the modes of a layer.
const N_MODE_SAMPLES: usize = 500;

/// Outputs near one point, for a scene that wants one patch.
const N_WANTED: usize = 800;

/// A method from readings to the map.
pub(super) struct Variant {
    pub(super) name: String,
    pub(super) family: Family,
    pub(super) passes: Passes,
    /// Nodes of the map it gives; all of them if none.
    pub(super) outputs: Option<Vec<usize>>,
    /// Training of the part from virtual gauges to the map, s.
    pub(super) training_s: f64,
    pub(super) times: Times,
}

/// What a variant is a variant of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Family {
    Baseline,
    Whole,
    LowRank,
    Narrow,
    Part,
    Direct,
    Peer,
}

impl Family {
    pub(super) const ALL: [Self; 7] = [
        Self::Baseline,
        Self::Whole,
        Self::LowRank,
        Self::Narrow,
        Self::Part,
        Self::Direct,
        Self::Peer,
    ];

    pub(super) fn name(self) -> &'static str {
        [
            "baselines",
            "the paper's nets",
            "low rank",
            "narrow nets",
            "part of the map",
            "direct net",
            "other programs",
        ][self as usize]
    }
}

/// What variants are made from.
struct Maker<'a> {
    run: &'a Run,
    data: &'a Datasets,
    transfer: Net,
    reconstruction: Net,
    training_s: f64,
    rows: Rows,
}

/// Makes every variant; narrow nets come from the cache or are trained.
pub(super) fn variants(run: &Run, limb: &Limb, done: &Pipeline) -> Result<Vec<Variant>> {
    let data = done.data.as_ref().context("no datasets")?;
    let nets = done.nets.as_ref().context("no nets")?;
    let whole = NetKind::Reconstruction { n_sets: data.simulated.len() };
    let maker = Maker {
        run,
        data,
        transfer: nets.load(NetKind::Transfer)?,
        reconstruction: nets.load(whole)?,
        training_s: training_s(nets, whole)?,
        rows: Rows::training(&mut Dataset::open_all(data)?)?,
    };
    let linear = Learner::Linear(LinearParams::default());
    let mut variants =
        vec![maker.baseline("LR", &linear)?, maker.baseline("k-NN", &Learner::Knn { k: 6 })?];
    maker.whole(&mut variants)?;
    maker.low_rank(&mut variants)?;
    maker.narrow(&mut variants)?;
    maker.part(limb, &mut variants)?;
    maker.direct(nets, &mut variants)?;
    Ok(variants)
}

fn training_s(nets: &TrainedNets, kind: NetKind) -> Result<f64> {
    let net = nets.nets.iter().find(|net| net.kind == kind);
    Ok(net.context("a net is not trained")?.stage.record.elapsed_s)
}

impl Maker<'_> {
    fn variant(
        &self,
        name: String,
        family: Family,
        precision: Precision,
        method: Method,
    ) -> Result<Variant> {
        let transfer = match family {
            Family::Direct => None,
            _ => Some(PreparedNet::new(&self.transfer, &InferParams::of(precision))?),
        };
        Ok(Variant {
            name,
            family,
            passes: Passes::new(transfer, method),
            outputs: None,
            training_s: self.training_s,
            times: Times::default(),
        })
    }

    fn fnn(&self, name: &str, family: Family, net: &Net, params: &InferParams) -> Result<Variant> {
        let method = Method::Net(PreparedNet::new(net, params)?);
        let name = format!("{name}, {}", params.precision.name());
        self.variant(name, family, params.precision, method)
    }

    fn baseline(&self, name: &str, learner: &Learner) -> Result<Variant> {
        let start = Instant::now();
        let method = Method::Fitted(learner.fit(&self.rows.samples(), &|| false)?);
        let variant = self.variant(name.into(), Family::Baseline, Precision::F32, method)?;
        Ok(Variant { training_s: start.elapsed().as_secs_f64(), ..variant })
    }

    fn whole(&self, variants: &mut Vec<Variant>) -> Result<()> {
        for precision in Precision::ALL {
            let params = InferParams::of(precision);
            variants.push(self.fnn("FNN", Family::Whole, &self.reconstruction, &params)?);
        }
        Ok(())
    }

    fn low_rank(&self, variants: &mut Vec<Variant>) -> Result<()> {
        let net = &self.reconstruction;
        let last = net.mlp().layers().len() - 1;
        let x = self.some_inputs();
        let most = (x.len() / self.rows.n_inputs()).min(self.rows.n_outputs());
        let mut add = |name: &str, low_rank: Vec<LowRank>| {
            let params = InferParams { low_rank, ..InferParams::of(Precision::Int8) };
            variants.push(self.fnn(name, Family::LowRank, net, &params)?);
            anyhow::Ok(())
        };
        let mut of_last = None;
        for rank in RANKS.into_iter().filter(|&rank| rank <= most) {
            let (low_rank, _) = LowRank::of_samples(net, last, &x, rank)?;
            add(&format!("FNN rank {rank}"), vec![low_rank.clone()])?;
            of_last = Some(low_rank);
        }
        let width = net.mlp().layers()[last - 1].bias.len();
        if let Some(of_last) = of_last
            && RANK_OF_TWO <= most.min(width)
        {
            let (before, _) = LowRank::of_samples(net, last - 1, &x, RANK_OF_TWO)?;
            let name = format!("FNN rank {RANK_OF_TWO}, last two layers");
            add(&name, vec![before, of_last])?;
        }
        Ok(())
    }

    /// Inputs of at most [`N_MODE_SAMPLES`] samples, evenly apart.
    fn some_inputs(&self) -> Vec<f32> {
        let step = self.rows.n.div_ceil(N_MODE_SAMPLES).max(1);
        let rows = self.rows.x.chunks_exact(self.rows.n_inputs());
        rows.step_by(step).flatten().copied().collect()
    }

    fn narrow(&self, variants: &mut Vec<Variant>) -> Result<()> {
        for hidden in NARROW {
            let (net, stage) = narrow(self.run, self.data, &self.rows, hidden)?;
            let widths: Vec<String> = hidden.iter().map(ToString::to_string).collect();
            let name = format!("FNN {}", widths.join("-"));
            for precision in [Precision::F32, Precision::Int8] {
                let params = InferParams::of(precision);
                let variant = self.fnn(&name, Family::Narrow, &net, &params)?;
                variants.push(Variant { training_s: stage.record.elapsed_s, ..variant });
            }
        }
        Ok(())
    }

    /// Position and force of one contact, straight from readings.
    fn direct(&self, nets: &TrainedNets, variants: &mut Vec<Variant>) -> Result<()> {
        let net = nets.load(NetKind::Direct)?;
        for precision in Precision::ALL {
            let params = InferParams::of(precision);
            let variant = self.fnn("direct FNN", Family::Direct, &net, &params)?;
            variants.push(Variant { training_s: training_s(nets, NetKind::Direct)?, ..variant });
        }
        Ok(())
    }

    /// The outputs nearest to the first surface node.
    fn part(&self, limb: &Limb, variants: &mut Vec<Variant>) -> Result<()> {
        let points = limb.surface_points();
        let mut nodes: Vec<usize> = (0..self.rows.n_outputs()).collect();
        let distance = |node: &usize| (points[*node] - points[0]).norm();
        nodes.sort_by(|a, b| distance(a).total_cmp(&distance(b)).then(a.cmp(b)));
        nodes.truncate(N_WANTED);
        nodes.sort_unstable();
        for precision in Precision::ALL {
            let params = InferParams { wanted: Some(nodes.clone()), ..InferParams::of(precision) };
            let name = format!("FNN, {} outputs", nodes.len());
            let variant = self.fnn(&name, Family::Part, &self.reconstruction, &params)?;
            variants.push(Variant { outputs: Some(nodes.clone()), ..variant });
        }
        Ok(())
    }
}
