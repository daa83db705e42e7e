//! Single samples with their true and predicted maps, for pictures.

use anyhow::{Context, Result};
use hapdef::{FoundContact, Hapdefx, Limb, Pipeline, Run, ScoredContact};

use super::chain::{candidates, chain, maps, reconstruction};
use super::dataset::{Dataset, rig_singles};
use crate::search::forward;

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
    let maker = Maker { chain: chain(run, limb, done)?, done };
    let data = done.data.as_ref().context("no datasets")?;
    let mut found = vec![maker.single()?];
    if let Some(stage) = &data.rig_double {
        let n = run.profile.n_amplitudes;
        let last = run.profile.n_pairs - 1;
        let rows = [n - 1, (last / 3) * n + n / 2, (2 * last / 3) * n + n - 1];
        let stems = ["figure6b", "figure9a1", "figure9a2"];
        for (row, stem) in rows.into_iter().zip(stems) {
            let mut presses = Dataset::open(stage)?;
            let figure = if stem == "figure6b" { "6B" } else { "9A" };
            let text = format!("Figure {figure}: a double press of the rig, from ten readings");
            found.push(maker.example(&mut presses, row, stem, &text, false)?);
        }
    }
    for (n_contacts, stem, text) in [
        (3, "figure6c", "Figure 6C: three simulated contacts, from true virtual gauges"),
        (4, "figure7", "Figure 7: four simulated contacts, from true virtual gauges"),
    ] {
        if let Some(stage) = data.simulated.get(n_contacts - 1) {
            let mut presses = Dataset::open(stage)?;
            let row = presses.split()?.test.start;
            found.push(maker.example(&mut presses, row, stem, text, true)?);
        }
    }
    Ok(found)
}

struct Maker<'a> {
    chain: Hapdefx,
    done: &'a Pipeline,
}

impl Maker<'_> {
    /// The first test press of the rig that is strong enough.
    fn single(&self) -> Result<Example> {
        let (mut presses, split) = rig_singles(self.done)?;
        let truth = presses.truth(split.test.clone())?;
        let strong = truth.iter().position(|contacts| contacts[0].1 >= LEAST_SHOWN_N);
        let row = split.test.start + strong.unwrap_or(0);
        let text = "Figure 6A: a single press of the rig, from ten readings";
        self.example(&mut presses, row, "figure6a", text, false)
    }

    fn example(
        &self,
        presses: &mut Dataset,
        row: usize,
        stem: &'static str,
        text: &str,
        from_virtual: bool,
    ) -> Result<Example> {
        let rows = row..row + 1;
        let truth_um = presses.maps(rows.clone())?;
        let found_um = if from_virtual {
            let net = reconstruction(self.done)?;
            forward(&net, &presses.inputs(rows.clone())?)?
        } else {
            let readings = presses.readings(rows.clone())?;
            maps(&self.chain, &readings, 1, presses.n_surface)?
        };
        let candidates = candidates(&self.chain, &found_um, presses.n_surface)?.remove(0);
        let truth = presses.truth(rows)?.remove(0);
        let picked = self.chain.top_with_spread(&candidates, truth.len())?;
        let forces: Vec<String> = truth.iter().map(|c| format!("{:.0}", c.1)).collect();
        let as_f64 = |map: &[f32]| map.iter().map(|v| f64::from(*v)).collect();
        Ok(Example {
            stem,
            caption: format!("{text}; {} N", forces.join(" and ")),
            truth_um: as_f64(&truth_um),
            found_um: as_f64(&found_um),
            truth,
            candidates,
            picked,
        })
    }
}
