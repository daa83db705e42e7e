//! Stage: how well the trained nets do on the rig's test presses.

use std::ops::Range;

use hapdef_data::{DatasetReader, Split};
use hapdef_live::estimator::{ChainNets, FoundContact, Hapdefx, HapdefxScratch};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::dataset::{Datasets, samples_path};
use super::nets::NetKind;
use super::train::TrainedNets;
use crate::cache::Stage;
use crate::error::HapdefError;
use crate::hapdefx::hapdefx;
use crate::limb::Limb;
use crate::map_error::{MapError, MapErrorSum};
use crate::run::Run;
use crate::scoring::{ContactPair, ScoredContact, score_lenient, score_one_to_one};
use crate::stats::ContactStats;

const VERSION: u32 = 2;

/// Frames that pass the nets together.
const BLOCK: usize = 64;

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

/// Errors of the varied contact in a range of its force, where it was found.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub struct ForceBin {
    /// Middle of the range, N.
    pub force_n: f64,
    /// Mean position error, mm.
    pub position_mm: f64,
    /// Mean absolute force error, N.
    pub force_error_n: f64,
    /// Presses in which it was found.
    pub n: usize,
    /// Presses in which it was not.
    pub n_missed: usize,
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
    let mut reader = DatasetReader::open(&samples_path(&data.rig_single))?;
    let test = Split::of(reader.n())?.test;
    let (frames, map) = run_chain(chain, &mut reader, test)?;
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
    let mut reader = DatasetReader::open(&samples_path(stage))?;
    let all = 0..reader.n();
    let (frames, map) = run_chain(chain, &mut reader, all)?;
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
        error_by_force: bins(&varied, run.scene.contact.force_range_n[1]),
    })
}

/// One press, what was truly there and what the chain found.
struct Frame {
    readings: Vec<f32>,
    truth: Vec<ScoredContact>,
    found: Vec<FoundContact>,
}

/// Runs the chain over `rows` of a dataset, block by block in parallel.
fn run_chain(
    chain: &Hapdefx,
    reader: &mut DatasetReader,
    rows: Range<usize>,
) -> Result<(Vec<Frame>, MapError), HapdefError> {
    let mut frames = Vec::with_capacity(rows.len());
    let mut error = MapErrorSum::new(reader.width("deformation")?);
    let starts: Vec<usize> = rows.clone().step_by(BLOCK).collect();
    for wave in starts.chunks(2 * rayon::current_num_threads().max(1)) {
        let blocks =
            wave.iter().map(|&start| read_block(reader, start..(start + BLOCK).min(rows.end)));
        let blocks: Vec<Block> = blocks.collect::<Result<_, _>>()?;
        let done: Vec<_> = blocks.into_par_iter().map(|block| solve(chain, block)).collect();
        for solved in done {
            let (block, map, found) = solved?;
            error.add(&block.map, &map);
            frames.extend(block.into_frames(found));
        }
    }
    Ok((frames, error.finish()))
}

struct Block {
    n: usize,
    readings: Vec<f32>,
    map: Vec<f32>,
    positions: Vec<f32>,
    forces: Vec<f32>,
}

impl Block {
    fn into_frames(self, found: Vec<Vec<FoundContact>>) -> Vec<Frame> {
        let n_contacts = self.forces.len() / self.n;
        let n_gauges = self.readings.len() / self.n;
        let frame = |(i, found): (usize, Vec<FoundContact>)| {
            let truth = (i * n_contacts..(i + 1) * n_contacts).map(|c| {
                let p = &self.positions[c * 3..c * 3 + 3];
                ([p[0], p[1], p[2]].map(f64::from), f64::from(self.forces[c]))
            });
            let readings = self.readings[i * n_gauges..(i + 1) * n_gauges].to_vec();
            Frame { readings, truth: truth.collect(), found }
        };
        found.into_iter().enumerate().map(frame).collect()
    }
}

fn read_block(reader: &mut DatasetReader, rows: Range<usize>) -> Result<Block, HapdefError> {
    let mut read = |tensor: &str| -> Result<Vec<f32>, HapdefError> {
        let mut values = vec![0.0; rows.len() * reader.width(tensor)?];
        reader.read_rows(tensor, rows.clone(), &mut values)?;
        Ok(values)
    };
    Ok(Block {
        n: rows.len(),
        readings: read("readings")?,
        map: read("deformation")?,
        positions: read("contact_positions")?,
        forces: read("contact_forces")?,
    })
}

/// A block, its reconstructed maps and the candidates in each.
type Solved = (Block, Vec<f32>, Vec<Vec<FoundContact>>);

fn solve(chain: &Hapdefx, block: Block) -> Result<Solved, HapdefError> {
    let mut scratch = HapdefxScratch::default();
    let mut map = vec![0.0; block.map.len()];
    chain.maps(&block.readings, &mut scratch, &mut map)?;
    let rows = map.chunks_exact(map.len() / block.n);
    let found = rows.map(|row| chain.candidates(row, &mut scratch)).collect::<Result<_, _>>()?;
    Ok((block, map, found))
}

fn scored(found: &[FoundContact]) -> Vec<ScoredContact> {
    found.iter().map(|c| (c.position_m, c.force_n)).collect()
}

/// Bins of equal width over the varied force: pairs of force and matched contact, if there is one.
fn bins(varied: &[(f64, Option<ContactPair>)], strongest_n: f64) -> Vec<ForceBin> {
    const N_BINS: usize = 8;
    let width = strongest_n / N_BINS as f64;
    let bin_of = |force_n: f64| ((force_n / width) as usize).min(N_BINS - 1);
    let bin = |i: usize| {
        let inside = || varied.iter().filter(move |(force_n, _)| bin_of(*force_n) == i);
        let found: Vec<&ContactPair> = inside().filter_map(|(_, pair)| pair.as_ref()).collect();
        let mean = |value: &dyn Fn(&ContactPair) -> f64| {
            found.iter().map(|pair| value(pair)).sum::<f64>() / found.len() as f64
        };
        (!found.is_empty()).then(|| ForceBin {
            force_n: (i as f64 + 0.5) * width,
            position_mm: mean(&|pair| pair.position_error_m * 1e3),
            force_error_n: mean(&|pair| pair.force_error_n.abs()),
            n: found.len(),
            n_missed: inside().count() - found.len(),
        })
    };
    (0..N_BINS).filter_map(bin).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_press_falls_into_one_bin_found_or_missed() {
        let pair = |position_error_m| ContactPair {
            detected: 0,
            truth: 1,
            position_error_m,
            force_error_n: -2.0,
        };
        let varied = [
            (0.0, Some(pair(0.004))),
            (1.0, Some(pair(0.002))),
            (2.0, None),
            (34.0, Some(pair(0.001))),
        ];
        let bins = bins(&varied, 34.0);
        assert_eq!(bins.len(), 2);
        assert_eq!((bins[0].n, bins[0].n_missed, bins[1].n), (2, 1, 1));
        assert!((bins[0].position_mm - 3.0).abs() < 1e-12);
        assert!((bins[1].force_error_n - 2.0).abs() < 1e-12);
    }
}
