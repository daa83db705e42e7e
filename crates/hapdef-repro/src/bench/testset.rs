//! Frames that every method is tested on, and its errors there.

use std::ops::Range;

use anyhow::{Context, Result};
use hapdef::{
    ContactPair, ContactStats, Hapdefx, HapdefxScratch, Limb, MapErrorSum, Pipeline, Run, Stage,
    score_lenient, scored,
};
use hapdef_bench::stats::mean;
use serde::Serialize;

use super::methods::Passes;
use crate::run::chain::{Choice, chain};
use crate::run::dataset::{Dataset, Part, Rows, evenly};
use crate::run::presses::{Presses, presses};

/// Most simulated samples of each set, and most presses of each kind on the rig.
const MOST_SIMULATED: usize = 200;
const MOST_PRESSES: usize = 400;

/// Position and force of a contact: what a direct method gives.
pub(super) const N_DIRECT: usize = 4;

/// What is tested on.
pub(super) struct TestSet {
    /// Virtual gauges `[n, n_virtual]` and maps `[n, n_surface]` of simulated samples, µm.
    simulated: Rows,
    single: Vec<Presses>,
    double: Vec<Presses>,
    chain: Hapdefx,
    pub(super) n_virtual: usize,
    pub(super) n_surface: usize,
}

/// Errors of a method.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(super) struct Errors {
    /// Mean absolute error of the map on simulated samples of one to four contacts, µm; none for a
    /// method that gives no map.
    pub(super) map_um: Option<f64>,
    /// Position error on the rig, mean of `single_mm` and, where the scene has them, `double_mm`;
    /// none for a method that gives a part of the map, or one contact only.
    pub(super) contact_mm: Option<f64>,
    /// Mean position error of single presses, mm.
    pub(super) single_mm: Option<f64>,
    /// Mean position error of double presses by the paper's lenient rule with T + 1, mm.
    pub(super) double_mm: Option<f64>,
    /// Share of the contacts that were found.
    pub(super) found: Option<f64>,
}

impl TestSet {
    /// Reads test samples: an even choice of those that no net was trained on.
    pub(super) fn read(run: &Run, limb: &Limb, done: &Pipeline) -> Result<Self> {
        let data = done.data.as_ref().context("no datasets")?;
        let sets = Dataset::open_all(data)?;
        let (n_virtual, n_surface) = (sets[0].n_virtual, sets[0].n_surface);
        let mut simulated = Rows::default();
        for mut set in sets {
            for row in evenly(set.split()?.test, MOST_SIMULATED) {
                simulated.add(&mut set, [Part::Gauges, Part::Map], row..row + 1)?;
            }
        }
        let single = some(&data.rig_single, |set| Ok(set.split()?.test))?;
        let double = match &data.rig_double {
            Some(stage) => some(stage, |set| Ok(0..set.n()))?,
            None => Vec::new(),
        };
        Ok(Self { simulated, single, double, chain: chain(run, limb, done)?, n_virtual, n_surface })
    }

    /// Readings of some presses, for the clock.
    pub(super) fn presses(&self) -> &[Presses] {
        &self.single
    }

    /// Errors of maps; `outputs` are the nodes that they have, all of them if none.
    pub(super) fn errors(&self, passes: &mut Passes, outputs: Option<&[usize]>) -> Result<Errors> {
        let map_um = Some(self.map_error(passes, outputs)?);
        if outputs.is_some() {
            return Ok(Errors { map_um, ..Errors::default() });
        }
        self.errors_of(map_um, |press, map| passes.map(&press.readings, map).map(drop))
    }

    /// Readings of every press, `[n, n_gauges]`: single presses, then double ones.
    pub(super) fn all_readings(&self) -> Vec<f32> {
        let presses = self.single.iter().chain(&self.double);
        presses.flat_map(|press| press.readings.iter().copied()).collect()
    }

    /// Errors of maps `[n, n_surface]` of every press, in the order of [`Self::all_readings`].
    pub(super) fn errors_of_maps(&self, maps: &[f32]) -> Result<Errors> {
        let mut maps = maps.chunks_exact(self.n_surface);
        self.errors_of(None, |_, map| {
            map.copy_from_slice(maps.next().context("a map for each press")?);
            Ok(())
        })
    }

    /// Errors of what `map_of` makes of each press, the single ones first.
    fn errors_of(
        &self,
        map_um: Option<f64>,
        mut map_of: impl FnMut(&Presses, &mut [f32]) -> Result<()>,
    ) -> Result<Errors> {
        let single = self.contact_errors(&self.single, 1, &mut map_of)?;
        let double = self.contact_errors(&self.double, 2, &mut map_of)?;
        let parts = [single, double];
        let measured: Vec<f64> = parts.iter().filter(|s| s.n > 0).map(|s| s.mean_mm).collect();
        let n_expected: usize = parts.iter().map(|s| s.n_expected).sum();
        let n: usize = parts.iter().map(|s| s.n).sum();
        Ok(Errors {
            map_um,
            contact_mm: (!measured.is_empty()).then(|| mean(measured)),
            single_mm: mean_mm(&single),
            double_mm: mean_mm(&double),
            found: (n_expected > 0).then(|| n as f64 / n_expected as f64),
        })
    }

    /// Errors of a method from readings to position, m, and force, N, of a single contact.
    pub(super) fn direct_errors(&self, passes: &mut Passes) -> Result<Errors> {
        let (mut pairs, mut out) = (Vec::new(), [0.0_f32; N_DIRECT]);
        for press in &self.single {
            passes.map(&press.readings, &mut out)?;
            let [x, y, z, force_n] = out.map(f64::from);
            pairs.extend(score_lenient(&[([x, y, z], force_n)], &press.truth[0])?);
        }
        let stats = ContactStats::of(&pairs, self.single.len());
        Ok(Errors { single_mm: mean_mm(&stats), ..Errors::default() })
    }

    fn map_error(&self, passes: &mut Passes, outputs: Option<&[usize]>) -> Result<f64> {
        let n_outputs = outputs.map_or(self.n_surface, <[usize]>::len);
        let (mut sum, mut map) = (MapErrorSum::new(n_outputs), vec![0.0; n_outputs]);
        let maps = self.simulated.y.chunks_exact(self.n_surface);
        for (x, truth) in self.simulated.x.chunks_exact(self.n_virtual).zip(maps) {
            passes.map_of_gauges(x, &mut map)?;
            match outputs {
                Some(outputs) => {
                    let wanted: Vec<f32> = outputs.iter().map(|&node| truth[node]).collect();
                    sum.add(&wanted, &map);
                }
                None => sum.add(truth, &map),
            }
        }
        Ok(sum.finish().mean_abs_um)
    }

    fn contact_errors(
        &self,
        presses: &[Presses],
        n_contacts: usize,
        map_of: &mut impl FnMut(&Presses, &mut [f32]) -> Result<()>,
    ) -> Result<ContactStats> {
        let mut pairs: Vec<ContactPair> = Vec::new();
        let mut scratch = HapdefxScratch::default();
        let mut map = vec![0.0; self.n_surface];
        for press in presses {
            map_of(press, &mut map)?;
            let found = self.chain.candidates(&map, &mut scratch)?;
            let chosen = Choice::ForceWithSpread.of(&self.chain, &found, n_contacts)?;
            pairs.extend(score_lenient(&scored(&chosen), &press.truth[0])?);
        }
        Ok(ContactStats::of(&pairs, n_contacts * presses.len()))
    }
}

/// Over the contacts that were found, if any was.
fn mean_mm(stats: &ContactStats) -> Option<f64> {
    (stats.n > 0).then_some(stats.mean_mm)
}

/// An even choice of the presses of a set, one by one.
fn some(stage: &Stage, rows: impl Fn(&Dataset) -> Result<Range<usize>>) -> Result<Vec<Presses>> {
    let all = presses(stage, rows, MOST_PRESSES, true)?;
    Ok(all.iter().flat_map(Presses::one_by_one).collect())
}
