//! Single test presses of the rig and what each method makes of them.

use std::ops::Range;

use anyhow::{Context, Result};
use hapdef::stages::NetKind;
use hapdef::{ContactPair, ContactStats, FoundContact, HapdefError, Limb, Pipeline, Run, Stage};
use hapdef_data::{Split, Standardiser, StandardiserFit};
use hapdef_repro::{Knn, KnnParams};
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::chain::{candidates, chain, forward, maps, reconstruction};
use super::presses::Presses;
use super::svr::SvrScore;

const VERSION: u32 = 1;

/// Presses computed together.
const BLOCK: usize = 512;

/// Bins of the force.
const N_BINS: usize = 8;

/// Position, m, and force, N, of a contact.
type Contact = [f32; 4];

/// What a method says of each test press; none where it found nothing.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(crate) struct MethodAnswers {
    /// For tables and legends.
    pub(crate) name: String,
    /// `[n_test]`.
    pub(crate) found: Vec<Option<Contact>>,
}

/// The test presses and every method's answers.
pub(crate) struct Singles {
    /// `[n_test]`.
    pub(crate) truth: Vec<Contact>,
    /// The methods of figure 4: SVR, k-NN, FNN.
    pub(crate) direct: Vec<MethodAnswers>,
    /// The ablations of figure 8; the whole chain first.
    pub(crate) ablations: Vec<MethodAnswers>,
}

/// Errors of the presses in a range of force.
pub(crate) struct Bin {
    /// Middle of the range, N.
    pub(crate) force_n: f64,
    /// Mean position error, mm.
    pub(crate) position_mm: f64,
    /// Mean absolute force error, N.
    pub(crate) error_n: f64,
}

/// Answers of all methods that need no training of their own, or reads them from the cache.
pub(crate) fn singles(
    run: &Run,
    limb: &Limb,
    done: &Pipeline,
    svr: &SvrScore,
) -> Result<(Singles, Stage)> {
    let data = done.data.as_ref().context("no datasets")?;
    let inputs = json!({
        "version": VERSION, "keys": super::keys_of(run, done), "presses": data.rig_single.key,
        "estimator": run.scene.estimator,
    });
    let stage = run.cache.stage("singles", &inputs, |_| {
        run.say("single presses: k-NN, the direct net, the chain and its ablations");
        let answers = answer(run, limb, done).and_then(|found| Ok(serde_json::to_value(found)?));
        answers.map_err(|error| HapdefError::Stale {
            path: "single presses".into(),
            what: format!("{error:#}"),
        })
    })?;
    let [knn, fnn, ablations @ ..]: [MethodAnswers; 5] =
        serde_json::from_value(stage.record.info.clone()).context("the singles stage")?;
    let (mut presses, test) = open(done)?;
    let truth = presses.truth(test)?;
    let truth = truth.iter().map(|c| {
        let (p, force_n) = c[0];
        [p[0], p[1], p[2], force_n].map(|v| v as f32)
    });
    let svr = MethodAnswers {
        name: "SVR".into(),
        found: svr.found.iter().map(|found| Some(*found)).collect(),
    };
    let singles = Singles {
        truth: truth.collect(),
        direct: vec![svr, knn, fnn],
        ablations: ablations.to_vec(),
    };
    Ok((singles, stage))
}

/// The rig's single presses and which of them are for testing.
pub(crate) fn open(done: &Pipeline) -> Result<(Presses, Range<usize>)> {
    let data = done.data.as_ref().context("no datasets")?;
    let presses = Presses::open(&data.rig_single)?;
    let test = Split::of(presses.n())?.test;
    Ok((presses, test))
}

fn answer(run: &Run, limb: &Limb, done: &Pipeline) -> Result<Vec<MethodAnswers>> {
    let (mut presses, test) = open(done)?;
    let nets = done.nets.as_ref().context("no nets")?;
    let direct = nets.load(NetKind::Direct)?;
    let chain = chain(run, limb, done)?;
    let from_virtual = reconstruction(done)?;
    let knn = NearestPresses::new(&mut presses)?;
    let names = ["k-NN", "direct FNN", "R → S → D → k-Max", "true S → D → k-Max", "true D → k-Max"];
    let mut answers = names.map(|name| MethodAnswers { name: name.into(), found: vec![] });
    for rows in super::samples::blocks(test, BLOCK) {
        run.check_stop("the single presses")?;
        let n_surface = presses.n_surface;
        let readings = presses.read("readings", rows.clone())?;
        let virtual_um = presses.read("virtual_gauges", rows.clone())?;
        let truth_um = presses.read("deformation", rows.clone())?;
        answers[0].found.extend(knn.answers(&readings)?);
        answers[1].found.extend(contacts(&forward(&direct, &readings)?));
        let chained = maps(&chain, &readings, rows.len(), n_surface)?;
        let from_virtual = forward(&from_virtual, &virtual_um)?;
        for (answers, maps) in answers[2..].iter_mut().zip([&chained, &from_virtual, &truth_um]) {
            let found = candidates(&chain, maps, n_surface)?;
            answers.found.extend(found.iter().map(|c| strongest(c)));
        }
    }
    Ok(answers.to_vec())
}

/// Net outputs `[n, 4]` as contacts.
pub(crate) fn contacts(rows: &[f32]) -> Vec<Option<Contact>> {
    let (rows, _) = rows.as_chunks::<4>();
    rows.iter().map(|row| Some(*row)).collect()
}

/// The candidate of greatest force.
pub(crate) fn strongest(found: &[FoundContact]) -> Option<Contact> {
    let first = found.first()?;
    let [x, y, z] = first.position_m;
    Some([x, y, z, first.force_n].map(|v| v as f32))
}

/// k nearest training presses by standardised readings, k = 6, weights 1/distance.
struct NearestPresses {
    knn: Knn,
    standardiser: Standardiser,
    targets: Vec<Contact>,
}

impl NearestPresses {
    fn new(presses: &mut Presses) -> Result<Self> {
        let train = Split::of(presses.n())?.train;
        let mut x = presses.read("readings", train.clone())?;
        let n_gauges = x.len() / train.len();
        let mut fit = StandardiserFit::new(n_gauges);
        fit.push(&x)?;
        let (standardiser, _) = fit.finish()?;
        standardiser.apply(&mut x)?;
        let targets = presses.truth(train)?.into_iter().map(|contacts| {
            let (p, force_n) = contacts[0];
            [p[0], p[1], p[2], force_n].map(|v| v as f32)
        });
        Ok(Self { knn: Knn::new(&x, n_gauges)?, standardiser, targets: targets.collect() })
    }

    fn answers(&self, readings: &[f32]) -> Result<Vec<Option<Contact>>> {
        let mut x = readings.to_vec();
        self.standardiser.apply(&mut x)?;
        let found = self.knn.neighbours(&x, &KnnParams::default())?;
        let fetch = |row: usize, out: &mut [f32]| {
            out.copy_from_slice(&self.targets[row]);
            Ok::<(), std::convert::Infallible>(())
        };
        let one = |query| {
            let mut out = [0.0; 4];
            found.predict(query, fetch, &mut out)?;
            Ok(Some(out))
        };
        (0..found.n_queries()).map(one).collect()
    }
}

impl Singles {
    /// A method's errors, press by press; none where it found nothing.
    pub(crate) fn errors(&self, method: &MethodAnswers) -> Vec<Option<ContactPair>> {
        let pair = |(truth, found): (&Contact, &Option<Contact>)| {
            let found = (*found)?;
            let offset = (0..3).map(|i| f64::from(found[i] - truth[i]).powi(2));
            Some(ContactPair {
                detected: 0,
                truth: 0,
                position_error_m: offset.sum::<f64>().sqrt(),
                force_error_n: f64::from(found[3] - truth[3]),
            })
        };
        self.truth.iter().zip(&method.found).map(pair).collect()
    }

    /// A method's errors in a few numbers.
    pub(crate) fn stats(&self, method: &MethodAnswers) -> ContactStats {
        let pairs: Vec<ContactPair> = self.errors(method).into_iter().flatten().collect();
        ContactStats::of(&pairs, self.truth.len())
    }

    /// A method's mean errors by the press's force, in bins of equal width up to `strongest_n`.
    pub(crate) fn by_force(&self, method: &MethodAnswers, strongest_n: f64) -> Vec<Bin> {
        let width = strongest_n / N_BINS as f64;
        let mut sums = [(0.0, 0.0, 0.0); N_BINS];
        for (truth, pair) in self.truth.iter().zip(self.errors(method)) {
            if let Some(pair) = pair {
                let bin = ((f64::from(truth[3]) / width) as usize).min(N_BINS - 1);
                sums[bin].0 += 1.0;
                sums[bin].1 += pair.position_error_m * 1e3;
                sums[bin].2 += pair.force_error_n.abs();
            }
        }
        let bins = sums.iter().enumerate().filter(|(_, sums)| sums.0 > 0.0);
        bins.map(|(i, (n, position, force))| Bin {
            force_n: (i as f64 + 0.5) * width,
            position_mm: position / n,
            error_n: force / n,
        })
        .collect()
    }
}
