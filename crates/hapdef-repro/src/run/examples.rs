//! Single samples with their true and predicted maps, for pictures.

use std::ops::Range;

use anyhow::{Context, Result};
use hapdef::{FoundContact, Hapdefx, Limb, Pipeline, Run, ScoredContact};

use super::chain::{Choice, MapFrom, candidates, chain, reconstruction};
use super::dataset::{Dataset, rig_singles};

/// Weakest single press that is shown, N: a faint one shows little.
const LEAST_SHOWN_N: f64 = 15.0;

/// A sample and what the chain makes of it.
pub(crate) struct Example {
    /// Stem of the pictures' files.
    pub(crate) stem: &'static str,
    /// Which figure and what is seen.
    pub(crate) caption: String,
    /// True map, `[n_surface]`, µm.
    pub(crate) truth_um: Vec<f64>,
    /// Predicted map, `[n_surface]`, µm.
    pub(crate) found_um: Vec<f64>,
    /// True contacts.
    pub(crate) truth: Vec<ScoredContact>,
    /// Candidates, greatest force first.
    pub(crate) candidates: Vec<FoundContact>,
    /// As many as there are true contacts, T + 1 rule.
    pub(crate) picked: Vec<FoundContact>,
}

/// Examples for figures 6A to C, 7 and 9A, as far as the scene has the contacts.
pub(crate) fn examples(run: &Run, limb: &Limb, done: &Pipeline) -> Result<Vec<Example>> {
    let chain = chain(run, limb, done)?;
    let net = reconstruction(done)?;
    let (readings, gauges) = (MapFrom::Readings(&chain), MapFrom::Gauges(&net));
    let data = done.data.as_ref().context("no datasets")?;
    let (mut presses, split) = rig_singles(done)?;
    let row = first_strong(&mut presses, split.test)?;
    let text = "Figure 6A: a single press of the rig, from ten readings";
    let mut found = vec![example(&chain, readings, &mut presses, row, ("figure6a", text))?];
    if let Some(stage) = &data.rig_double {
        let n = run.profile.n_amplitudes;
        let last = run.profile.n_pairs - 1;
        let rows = [n - 1, (last / 3) * n + n / 2, (2 * last / 3) * n + n - 1];
        let stems = [("6B", "figure6b"), ("9A", "figure9a1"), ("9A", "figure9a2")];
        let mut presses = Dataset::open(stage)?;
        for (row, (figure, stem)) in rows.into_iter().zip(stems) {
            let text = format!("Figure {figure}: a double press of the rig, from ten readings");
            found.push(example(&chain, readings, &mut presses, row, (stem, &text))?);
        }
    }
    for (n_contacts, stem, text) in [
        (3, "figure6c", "Figure 6C: three simulated contacts, from true virtual gauges"),
        (4, "figure7", "Figure 7: four simulated contacts, from true virtual gauges"),
    ] {
        if let Some(stage) = data.simulated.get(n_contacts - 1) {
            let mut presses = Dataset::open(stage)?;
            let row = presses.split()?.test.start;
            found.push(example(&chain, gauges, &mut presses, row, (stem, text))?);
        }
    }
    Ok(found)
}

/// The first single press of `rows` that is strong enough.
fn first_strong(presses: &mut Dataset, rows: Range<usize>) -> Result<usize> {
    let truth = presses.truth(rows.clone())?;
    let strong = truth.iter().position(|contacts| contacts[0].1 >= LEAST_SHOWN_N);
    Ok(rows.start + strong.unwrap_or(0))
}

fn example(
    chain: &Hapdefx,
    from: MapFrom<'_>,
    presses: &mut Dataset,
    row: usize,
    (stem, text): (&'static str, &str),
) -> Result<Example> {
    let rows = row..row + 1;
    let truth_um = presses.maps(rows.clone())?;
    let found_um = from.maps(presses, rows.clone())?;
    let candidates = candidates(chain, &found_um, presses.n_surface)?.remove(0);
    let truth = presses.truth(rows)?.remove(0);
    let forces: Vec<String> = truth.iter().map(|c| format!("{:.0}", c.1)).collect();
    let as_f64 = |map: Vec<f32>| map.into_iter().map(f64::from).collect();
    Ok(Example {
        stem,
        caption: format!("{text}; {} N", forces.join(" and ")),
        truth_um: as_f64(truth_um),
        found_um: as_f64(found_um),
        picked: Choice::ForceWithSpread.of(chain, &candidates, truth.len())?,
        truth,
        candidates,
    })
}
