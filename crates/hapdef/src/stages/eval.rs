//! Stage: how well the trained nets do on the rig's test presses.

use std::ops::Range;

use hapdef_live::estimator::{ChainNets, FoundContact, Hapdefx};
use serde::{Deserialize, Serialize};

use super::dataset::Datasets;
use super::dataset_rows::{Dataset, blocks};
use super::nets::NetKind;
use super::train::TrainedNets;
use crate::cache::Stage;
use crate::error::HapdefError;
use crate::hapdefx::{candidates, hapdefx, maps_of_readings, scored};
use crate::limb::Limb;
use crate::map_error::{MapError, MapErrorSum};
use crate::run::Run;
use crate::scoring::{ScoredContact, score_lenient, score_one_to_one};
use crate::stats::{ContactStats, ForceBin, by_force};

const VERSION: u32 = 2;

/// Frames that are read together.
const BLOCK: usize = 512;

/// Scores of the whole chain on the simulated rig.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct EvalReport {
    /// Single presses, test split.
    pub single: SingleScores,
    /// Double presses; absent when the scene has one contact at most.
    pub double: Option<DoubleScores>,
}

/// Scores on single presses.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct SingleScores {
    /// The direct net.
    pub direct: ContactStats,
    /// The whole chain, strongest candidate.
    pub hapdefx: ContactStats,
    /// Presses in which the chain found no candidate.
    pub n_without_candidate: usize,
    /// Error of the reconstructed map.
    pub map: MapError,
}

/// Scores on double presses, the number of contacts given.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct DoubleScores {
    /// The paper's lenient rule: top two candidates, each to the closest true contact.
    pub lenient: ContactStats,
    /// The same after the T + 1 rule.
    pub lenient_spread: ContactStats,
    /// One-to-one matching after the T + 1 rule.
    pub one_to_one: ContactStats,
    /// Presses in which fewer than two candidates were found.
    pub n_short: usize,
    /// Presses in which just two candidates were found, a share of all.
    pub share_two_candidates: f64,
    /// Error of the reconstructed map.
    pub map: MapError,
    /// Error of the varied contact against its force, matched one to one after the T + 1 rule: bins
    /// of equal width over its range.
    pub error_by_force: Vec<ForceBin>,
}

/// Scores the direct net and the whole chain.
///
/// # Errors
/// [`HapdefError`] when a file of an earlier stage is damaged.
pub fn eval(
    run: &Run,
    limb: &Limb,
    data: &Datasets,
    nets: &TrainedNets,
) -> Result<(Stage, EvalReport), HapdefError> {
    let keys: Vec<&str> = nets.nets.iter().map(|net| net.stage.key.as_str()).collect();
    let doubles = data.rig_double.as_ref().map(|stage| stage.key.as_str());
    let inputs = serde_json::json!({
        "version": VERSION, "nets": keys, "singles": data.rig_single.key, "doubles": doubles,
        "estimator": run.scene.estimator,
    });
    let stage = run.cache.stage("eval", &inputs, |_| {
        run.check_stop("the scores")?;
        run.say("scoring the chain on the rig's test presses");
        let chain = trained_chain(run, limb, data, nets)?;
        let report = EvalReport {
            single: single_scores(&chain, data, nets)?,
            double: match &data.rig_double {
                Some(stage) => Some(double_scores(run, &chain, stage)?),
                None => None,
            },
        };
        serde_json::to_value(report).map_err(|error| stale(&error))
    })?;
    let report =
        serde_json::from_value(stage.record.info.clone()).map_err(|error| stale(&error))?;
    Ok((stage, report))
}

fn stale(error: &serde_json::Error) -> HapdefError {
    HapdefError::Stale { path: "eval".into(), what: error.to_string() }
}

/// The paper's chain from the trained nets, F_R trained on all sets of `data`.
///
/// # Errors
/// [`HapdefError::Net`] when a checkpoint can't be read; [`HapdefError::KMax`].
pub fn trained_chain(
    run: &Run,
    limb: &Limb,
    data: &Datasets,
    nets: &TrainedNets,
) -> Result<Hapdefx, HapdefError> {
    let points = limb.surface_points().iter().map(|p| p.coords.into()).collect();
    let nets = ChainNets {
        transfer: nets.load(NetKind::Transfer)?,
        reconstruction: nets.load(NetKind::Reconstruction { n_sets: data.simulated.len() })?,
        sensitivity: nets.load(NetKind::Sensitivity)?,
    };
    hapdefx(nets, points, &run.scene.estimator.hapdefx())
}

fn single_scores(
    chain: &Hapdefx,
    data: &Datasets,
    nets: &TrainedNets,
) -> Result<SingleScores, HapdefError> {
    let mut set = Dataset::open(&data.rig_single)?;
    let test = set.split()?.test;
    let (frames, map) = run_chain(chain, &mut set, test)?;
    let direct = nets.load(NetKind::Direct)?;
    let mut direct_pairs = Vec::with_capacity(frames.len());
    let mut chain_pairs = Vec::with_capacity(frames.len());
    let mut scratch = hapdef_nets::Scratch::default();
    for frame in &frames {
        let mut out = [0.0_f32; 4];
        direct.forward(&frame.readings, &mut scratch, &mut out)?;
        let [x, y, z, force] = out.map(f64::from);
        direct_pairs.extend(score_lenient(&[([x, y, z], force)], &frame.truth)?);
        chain_pairs.extend(score_lenient(&scored(&chain.top(&frame.found, 1)), &frame.truth)?);
    }
    Ok(SingleScores {
        direct: ContactStats::of(&direct_pairs, frames.len()),
        hapdefx: ContactStats::of(&chain_pairs, frames.len()),
        n_without_candidate: frames.iter().filter(|f| f.found.is_empty()).count(),
        map,
    })
}

fn double_scores(run: &Run, chain: &Hapdefx, stage: &Stage) -> Result<DoubleScores, HapdefError> {
    let mut set = Dataset::open(stage)?;
    let all = 0..set.n();
    let (frames, map) = run_chain(chain, &mut set, all)?;
    let (mut lenient, mut spread, mut strict) = (vec![], vec![], vec![]);
    let mut varied = Vec::with_capacity(frames.len());
    for frame in &frames {
        lenient.extend(score_lenient(&scored(&chain.top(&frame.found, 2)), &frame.truth)?);
        let chosen = scored(&chain.top_with_spread(&frame.found, 2)?);
        spread.extend(score_lenient(&chosen, &frame.truth)?);
        let matched = score_one_to_one(&chosen, &frame.truth)?.pairs;
        let second = matched.iter().find(|pair| pair.truth == 1).copied();
        varied.push((frame.truth[1].1, second));
        strict.extend(matched);
    }
    let n_contacts = 2 * frames.len();
    let n_with = |count: &dyn Fn(usize) -> bool| {
        frames.iter().filter(|frame| count(frame.found.len())).count()
    };
    Ok(DoubleScores {
        lenient: ContactStats::of(&lenient, n_contacts),
        lenient_spread: ContactStats::of(&spread, n_contacts),
        one_to_one: ContactStats::of(&strict, n_contacts),
        n_short: n_with(&|n| n < 2),
        share_two_candidates: n_with(&|n| n == 2) as f64 / frames.len() as f64,
        map,
        error_by_force: by_force(&varied, run.scene.contact.force_range_n[1]),
    })
}

/// One press, what was truly there and what the chain found.
struct Frame {
    readings: Vec<f32>,
    truth: Vec<ScoredContact>,
    found: Vec<FoundContact>,
}

/// Runs the chain over `rows` of a dataset, block by block.
fn run_chain(
    chain: &Hapdefx,
    set: &mut Dataset,
    rows: Range<usize>,
) -> Result<(Vec<Frame>, MapError), HapdefError> {
    let mut frames = Vec::with_capacity(rows.len());
    let mut error = MapErrorSum::new(set.n_surface);
    for rows in blocks(rows, BLOCK) {
        let readings = set.readings(rows.clone())?;
        let maps = maps_of_readings(chain, &readings, rows.len(), set.n_surface)?;
        error.add(&set.maps(rows.clone())?, &maps);
        let found = candidates(chain, &maps, set.n_surface)?;
        let each = readings.chunks_exact(readings.len() / rows.len()).map(<[f32]>::to_vec);
        let each = each.zip(set.truth(rows)?).zip(found);
        frames.extend(each.map(|((readings, truth), found)| Frame { readings, truth, found }));
    }
    Ok((frames, error.finish()))
}
