//! Figure 8's ablations that need nets of their own, trained briefly.

use anyhow::{Context, Result};
use hapdef::{Limb, Pipeline, Run, Stage};
use hapdef_nets::train::MemorySource;
use hapdef_nets::{MlpSpec, Net};
use serde_json::json;

use super::chain::{MapFrom, candidates, chain};
use super::dataset::{Dataset, Part, Rows, blocks, rig_singles};
use super::fit::{Training, fit};
use super::singles::{MethodAnswers, contacts, strongest};
use crate::search::forward;

/// Presses computed together.
const BLOCK: usize = 512;

/// Readings straight to the map, and position and force straight from the predicted map.
pub(crate) fn ablations(
    run: &Run,
    limb: &Limb,
    done: &Pipeline,
) -> Result<(Vec<MethodAnswers>, Vec<Stage>)> {
    let data = done.data.as_ref().context("no datasets")?;
    let (to_map, map_stage) = readings_to_map(run, done)?;
    let (to_contact, contact_stage) = fit(
        run,
        "D → P, A",
        &json!({ "set": data.simulated[0].key }),
        &Training::reconstruction(run),
        |n_surface, _| MlpSpec::direct(n_surface),
        || maps_to_contacts(&data.simulated[0]),
    )?;
    let mut answers = ["R → D → k-Max", "R → S → D → net"]
        .map(|name| MethodAnswers { name: name.into(), found: vec![] });
    let chain = chain(run, limb, done)?;
    let (mut presses, split) = rig_singles(done)?;
    for rows in blocks(split.test, BLOCK) {
        run.check_stop("the ablations")?;
        let readings = presses.readings(rows.clone())?;
        let found = candidates(&chain, &forward(&to_map, &readings)?, presses.n_surface)?;
        answers[0].found.extend(found.iter().map(|c| strongest(c)));
        let maps = MapFrom::Readings(&chain).maps(&mut presses, rows)?;
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
        &Training::reconstruction(run),
        MlpSpec::reconstruction,
        || readings_to_maps(done),
    )
}

fn readings_to_maps(done: &Pipeline) -> Result<MemorySource> {
    let (mut presses, split) = rig_singles(done)?;
    Rows::of(&mut presses, [Part::Readings, Part::Map], split.train)?.source()
}

fn maps_to_contacts(stage: &Stage) -> Result<MemorySource> {
    let mut presses = Dataset::open(stage)?;
    let train = presses.split()?.train;
    Rows::of(&mut presses, [Part::Map, Part::Contact], train)?.source()
}
