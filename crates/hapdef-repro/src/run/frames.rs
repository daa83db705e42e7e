//! What the chain finds in presses of several contacts: candidates of every press, kept.

use std::ops::Range;

use anyhow::{Context, Result};
use hapdef::{FoundContact, Hapdefx, Limb, Pipeline, Run, ScoredContact, Stage};
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::chain::{MapFrom, candidates, chain, reconstruction};
use super::dataset::{Dataset, blocks, first_of, rig_singles};
use super::kept::kept;

const VERSION: u32 = 2;

/// Presses computed together.
const BLOCK: usize = 512;

/// Most presses of a simulated set.
const MAX_SIMULATED: usize = 1000;

/// Candidates that are kept of a press, the greatest force first.
pub(crate) const MAX_KEPT: usize = 8;

/// A press with its true contacts and the candidates found in it.
#[derive(Deserialize, Serialize)]
pub(crate) struct Frame {
    /// The true contacts; on the rig's double presses the held one first.
    pub(crate) truth: Vec<ScoredContact>,
    /// The candidates, greatest force first, at most [`MAX_KEPT`].
    pub(crate) found: Vec<FoundContact>,
}

/// Presses of every kind.
#[derive(Deserialize, Serialize)]
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

/// Runs the chain over all of them, or reads them from the cache.
pub(crate) fn frames(run: &Run, limb: &Limb, done: &Pipeline) -> Result<(Frames, Stage)> {
    let data = done.data.as_ref().context("no datasets")?;
    let doubles = data.rig_double.as_ref().map(|stage| stage.key.as_str());
    let inputs = json!({
        "version": VERSION, "keys": super::keys_of(run, done), "singles": data.rig_single.key,
        "doubles": doubles, "estimator": run.scene.estimator,
    });
    kept(run, "frames", &inputs, |_| {
        run.say("candidates in presses of one to four contacts");
        find_all(run, limb, done)
    })
}

fn find_all(run: &Run, limb: &Limb, done: &Pipeline) -> Result<Frames> {
    let data = done.data.as_ref().context("no datasets")?;
    let chain = chain(run, limb, done)?;
    let net = reconstruction(done)?;
    let find = |presses: &mut Dataset, rows, from| find(run, &chain, presses, rows, from);
    let (mut singles, split) = rig_singles(done)?;
    let rig_single = find(&mut singles, split.test, MapFrom::Readings(&chain))?;
    let rig_double = match &data.rig_double {
        None => vec![],
        Some(stage) => {
            let mut presses = Dataset::open(stage)?;
            let all = 0..presses.n();
            find(&mut presses, all, MapFrom::Readings(&chain))?
        }
    };
    let (mut validation, mut test) = (vec![], vec![]);
    for mut presses in Dataset::open_all(data)? {
        let split = presses.split()?;
        for (all, rows) in [(&mut validation, split.validation), (&mut test, split.test)] {
            let rows = first_of(rows, MAX_SIMULATED);
            all.push(find(&mut presses, rows, MapFrom::Gauges(&net))?);
        }
    }
    Ok(Frames { rig_single, rig_double, validation, test })
}

fn find(
    run: &Run,
    chain: &Hapdefx,
    presses: &mut Dataset,
    rows: Range<usize>,
    from: MapFrom<'_>,
) -> Result<Vec<Frame>> {
    let mut frames = Vec::with_capacity(rows.len());
    for rows in blocks(rows, BLOCK) {
        run.check_stop("the candidates")?;
        let maps = from.maps(presses, rows.clone())?;
        let found = candidates(chain, &maps, presses.n_surface)?;
        for (truth, mut found) in presses.truth(rows)?.into_iter().zip(found) {
            found.truncate(MAX_KEPT);
            frames.push(Frame { truth, found });
        }
    }
    Ok(frames)
}
