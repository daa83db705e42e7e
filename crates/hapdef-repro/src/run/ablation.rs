//! Figure 8's ablations that need nets of their own, trained briefly.

use crate::search::forward;
use anyhow::{Context, Result};
use hapdef::{Limb, Pipeline, Run, Stage};
use hapdef_nets::train::MemorySource;
use hapdef_nets::{MlpSpec, Net};
use serde_json::json;

use super::chain::{candidates, chain, maps};
use super::dataset::{Dataset, blocks, rig_singles};
use super::fit::{Brief, fit};
use super::singles::{MethodAnswers, contacts, strongest};

/// Presses computed together.
const BLOCK: usize = 512;

/// Readings straight to the map, and position and force straight from the predicted map.
pub(crate) fn ablations(
    run: &Run,
    limb: &Limb,
    done: &Pipeline,
) -> Result<(Vec<MethodAnswers>, Vec<Stage>)> {
    let data = done.data.as_ref().context("no datasets")?;
    let brief = Brief::reconstruction(&run.profile);
    let (to_map, map_stage) = readings_to_map(run, done)?;
    let (to_contact, contact_stage) = fit(
        run,
        "D → P, A",
        &json!({ "set": data.simulated[0].key }),
        brief,
        |n_surface, _| MlpSpec::direct(n_surface),
        || maps_to_contacts(&data.simulated[0]),
    )?;
    let mut answers = ["R → D → k-Max", "R → S → D → net"]
        .map(|name| MethodAnswers { name: name.into(), found: vec![] });
    let chain = chain(run, limb, done)?;
    let (mut presses, split) = rig_singles(done)?;
    for rows in blocks(split.test, BLOCK) {
        run.check_stop("the ablations")?;
        let readings = presses.read("readings", rows.clone())?;
        let found = candidates(&chain, &forward(&to_map, &readings)?, presses.n_surface)?;
        answers[0].found.extend(found.iter().map(|c| strongest(c)));
        let maps = maps(&chain, &readings, rows.len(), presses.n_surface)?;
        answers[1].found.extend(contacts(&forward(&to_contact, &maps)?));
    }
    Ok((answers.to_vec(), vec![map_stage, contact_stage]))
}

/// The net from readings straight to the map, trained briefly.
pub(crate) fn readings_to_map(run: &Run, done: &Pipeline) -> Result<(Net, Stage)> {
    let data = done.data.as_ref().context("no datasets")?;
    fit(
        run,
        "R → D",
        &json!({ "presses": data.rig_single.key }),
        Brief::reconstruction(&run.profile),
        MlpSpec::reconstruction,
        || readings_to_maps(done),
    )
}

fn readings_to_maps(done: &Pipeline) -> Result<MemorySource> {
    let (mut presses, split) = rig_singles(done)?;
    let x = presses.read("readings", split.train.clone())?;
    let y = presses.maps(split.train)?;
    Ok(MemorySource::new(presses.width("readings")?, presses.n_surface, x, y)?)
}

fn maps_to_contacts(stage: &Stage) -> Result<MemorySource> {
    let mut presses = Dataset::open(stage)?;
    let train = presses.split()?.train;
    let x = presses.maps(train.clone())?;
    let y = presses.contacts(train)?.into_flattened();
    Ok(MemorySource::new(presses.n_surface, 4, x, y)?)
}
