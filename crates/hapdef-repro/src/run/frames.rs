//! What the chain finds in presses of several contacts: candidates of every press, kept.

use anyhow::{Context, Result};
use hapdef::{FoundContact, Hapdefx, Limb, Pipeline, Run, ScoredContact, Stage};
use hapdef_nets::Net;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::chain::{candidates, chain, maps, reconstruction};
use super::dataset::{Dataset, blocks, rig_singles};
use super::kept::kept;
use crate::search::forward;

const VERSION: u32 = 1;

/// Presses computed together.
const BLOCK: usize = 512;

/// Most presses of a simulated set.
const MAX_SIMULATED: usize = 1000;

/// Candidates that are kept of a press, the greatest force first.
pub(crate) const MAX_KEPT: usize = 8;

/// A candidate: surface node, force, N, displacement, µm.
type Kept = (usize, f64, f64);

/// Candidates of each press of a set.
#[derive(Deserialize, Serialize)]
struct Found {
    rig_single: Vec<Vec<Kept>>,
    rig_double: Vec<Vec<Kept>>,
    validation: Vec<Vec<Vec<Kept>>>,
    test: Vec<Vec<Vec<Kept>>>,
}

/// A press with its true contacts and the candidates found in it.
pub(crate) struct Frame {
    /// The true contacts; on the rig's double presses the held one first.
    pub(crate) truth: Vec<ScoredContact>,
    /// The candidates, greatest force first, at most [`MAX_KEPT`].
    pub(crate) found: Vec<FoundContact>,
}

/// Presses of every kind.
pub(crate) struct Frames {
    /// Single test presses of the rig, from readings.
    pub(crate) rig_single: Vec<Frame>,
    /// Double presses of the rig, from readings.
    pub(crate) rig_double: Vec<Frame>,
    /// Simulated validation samples of one to four contacts, from true virtual gauges.
    pub(crate) validation: Vec<Vec<Frame>>,
    /// Simulated test samples of one to four contacts, from true virtual gauges.
    pub(crate) test: Vec<Vec<Frame>>,
}

/// Runs the chain over all of them, or reads the candidates from the cache.
pub(crate) fn frames(run: &Run, limb: &Limb, done: &Pipeline) -> Result<(Frames, Stage)> {
    let data = done.data.as_ref().context("no datasets")?;
    let doubles = data.rig_double.as_ref().map(|stage| stage.key.as_str());
    let inputs = json!({
        "version": VERSION, "keys": super::keys_of(run, done), "singles": data.rig_single.key,
        "doubles": doubles, "estimator": run.scene.estimator,
    });
    let (found, stage) = kept(run, "frames", &inputs, |_| {
        run.say("candidates in presses of one to four contacts");
        find_all(run, limb, done)
    })?;
    Ok((with_truth(limb, done, found)?, stage))
}

fn find_all(run: &Run, limb: &Limb, done: &Pipeline) -> Result<Found> {
    let data = done.data.as_ref().context("no datasets")?;
    let chain = chain(run, limb, done)?;
    let net = reconstruction(done)?;
    let (mut singles, split) = rig_singles(done)?;
    let rig_single = find(run, &chain, &mut singles, split.test, None)?;
    let rig_double = match &data.rig_double {
        None => vec![],
        Some(stage) => {
            let mut presses = Dataset::open(stage)?;
            let all = 0..presses.n();
            find(run, &chain, &mut presses, all, None)?
        }
    };
    let (mut validation, mut test) = (vec![], vec![]);
    for stage in &data.simulated {
        let mut presses = Dataset::open(stage)?;
        let split = presses.split()?;
        validation.push(find(run, &chain, &mut presses, most(split.validation), Some(&net))?);
        test.push(find(run, &chain, &mut presses, most(split.test), Some(&net))?);
    }
    Ok(Found { rig_single, rig_double, validation, test })
}

fn most(rows: std::ops::Range<usize>) -> std::ops::Range<usize> {
    rows.start..rows.end.min(rows.start + MAX_SIMULATED)
}

/// Candidates from readings, or with a net from the true virtual gauges.
fn find(
    run: &Run,
    chain: &Hapdefx,
    presses: &mut Dataset,
    rows: std::ops::Range<usize>,
    from_virtual: Option<&Net>,
) -> Result<Vec<Vec<Kept>>> {
    let mut kept = Vec::with_capacity(rows.len());
    for rows in blocks(rows, BLOCK) {
        run.check_stop("the candidates")?;
        let maps = match from_virtual {
            Some(net) => forward(net, &presses.inputs(rows)?)?,
            None => {
                let readings = presses.readings(rows.clone())?;
                maps(chain, &readings, rows.len(), presses.n_surface)?
            }
        };
        for found in candidates(chain, &maps, presses.n_surface)? {
            let first = found.iter().take(MAX_KEPT);
            kept.push(first.map(|c| (c.node, c.force_n, c.displacement_um)).collect());
        }
    }
    Ok(kept)
}

fn with_truth(limb: &Limb, done: &Pipeline, found: Found) -> Result<Frames> {
    let data = done.data.as_ref().context("no datasets")?;
    let points = limb.surface_points();
    let frame = |(truth, kept): (Vec<ScoredContact>, Vec<Kept>)| Frame {
        truth,
        found: kept
            .into_iter()
            .map(|(node, force_n, displacement_um)| FoundContact {
                node,
                position_m: points[node].coords.into(),
                force_n,
                displacement_um,
            })
            .collect(),
    };
    let pair = |presses: &mut Dataset, rows, found: Vec<Vec<Kept>>| -> Result<Vec<Frame>> {
        Ok(presses.truth(rows)?.into_iter().zip(found).map(frame).collect())
    };
    let (mut singles, split) = rig_singles(done)?;
    let rig_single = pair(&mut singles, split.test, found.rig_single)?;
    let rig_double = match &data.rig_double {
        None => vec![],
        Some(stage) => {
            let mut presses = Dataset::open(stage)?;
            let all = 0..presses.n();
            pair(&mut presses, all, found.rig_double)?
        }
    };
    let (mut validation, mut tests) = (vec![], vec![]);
    for ((stage, v), t) in data.simulated.iter().zip(found.validation).zip(found.test) {
        let mut presses = Dataset::open(stage)?;
        let split = presses.split()?;
        validation.push(pair(&mut presses, most(split.validation), v)?);
        tests.push(pair(&mut presses, most(split.test), t)?);
    }
    Ok(Frames { rig_single, rig_double, validation, test: tests })
}
