//! The samples of a search, in memory, and the error of a fitted method on them.

use std::ops::Range;

use anyhow::{Context, Result};
use hapdef::{ContactStats, MapErrorSum};

use super::Prepared;
use crate::error::ReproError;
use crate::run::dataset::{Dataset, Part, Rows, blocks, first_of, pair, rig_singles};
use crate::search::{Fitted, Learner, ParameterValues, Samples, SearchMethod};

/// Most validation samples of all sets together.
const MAX_VALIDATION: usize = 1000;
/// Rows predicted together.
const BLOCK: usize = 256;
/// The paper's virtual gauges per gauge (Sun & Martius 2019, figure 5A).
const PAPER_PATCH: usize = 24;

/// The samples of one method.
pub(crate) struct MethodData {
    method: SearchMethod,
    max_patch: usize,
    /// Keys of the datasets.
    pub(crate) keys: String,
    /// What methods are fitted to.
    pub(crate) train: Rows,
    /// What settings are chosen by.
    pub(crate) validation: Rows,
    /// What the chosen settings are scored on, by name; empty during a search.
    pub(crate) tests: Vec<(String, Rows)>,
}

/// Errors of a fitted method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MethodError {
    /// Mean absolute error of map or virtual gauges, µm; mean distance of contacts, mm.
    pub(crate) main: f64,
    /// Mean absolute error of the force, N, where there is one.
    pub(crate) force_n: Option<f64>,
}

impl MethodData {
    /// Reads what `method` needs; test samples only where they are asked for.
    pub(crate) fn load(
        method: SearchMethod,
        prepared: &Prepared,
        with_tests: bool,
    ) -> Result<Self> {
        let empty = Self {
            method,
            max_patch: prepared.max_patch,
            keys: String::new(),
            train: Rows::default(),
            validation: Rows::default(),
            tests: Vec::new(),
        };
        match method {
            SearchMethod::Reconstruction | SearchMethod::Linear | SearchMethod::Knn => {
                empty.with_maps(prepared, with_tests)
            }
            SearchMethod::Transfer | SearchMethod::Direct | SearchMethod::Svr => {
                empty.with_presses(prepared, with_tests)
            }
        }
    }

    fn with_maps(mut self, prepared: &Prepared, with_tests: bool) -> Result<Self> {
        let data = prepared.done.data.as_ref().context("no datasets")?;
        let keys = data.simulated.iter().map(|stage| stage.key.as_str());
        self.keys = keys.collect::<Vec<_>>().join(" ");
        let mut sets = Dataset::open_all(data)?;
        let most = MAX_VALIDATION / sets.len();
        for (i, set) in sets.iter_mut().enumerate() {
            let split = set.split()?;
            let maps = [Part::Gauges, Part::Map];
            self.train.add(set, maps, split.train)?;
            self.validation.add(set, maps, first_of(split.validation, most))?;
            if with_tests {
                let rows = Rows::of(set, maps, split.test)?;
                self.tests.push((format!("{} contacts", i + 1), rows));
            }
        }
        Ok(self)
    }

    fn with_presses(mut self, prepared: &Prepared, with_tests: bool) -> Result<Self> {
        let data = prepared.done.data.as_ref().context("no datasets")?;
        self.keys = data.rig_single.key.clone();
        let (mut set, split) = rig_singles(&prepared.done)?;
        self.train = self.presses(&mut set, split.train)?;
        self.validation = self.presses(&mut set, first_of(split.validation, MAX_VALIDATION))?;
        if with_tests {
            let rows = self.presses(&mut set, split.test)?;
            self.tests.push(("single presses".to_owned(), rows));
        }
        Ok(self)
    }

    fn presses(&self, set: &mut Dataset, rows: Range<usize>) -> Result<Rows> {
        let y = match self.method {
            SearchMethod::Transfer => {
                let patch = PAPER_PATCH.min(self.max_patch);
                first_of_patches(&set.inputs(rows.clone())?, self.max_patch, patch)
            }
            _ => set.contacts(rows.clone())?.into_flattened(),
        };
        Ok(Rows { n: rows.len(), x: set.readings(rows)?, y })
    }

    /// Fits a method to the training samples.
    pub(crate) fn fit(
        &self,
        learner: &Learner,
        values: &ParameterValues,
        stop: &dyn Fn() -> bool,
    ) -> Result<Fitted, ReproError> {
        let (x, n_inputs) = self.inputs(&self.train.x, values);
        let samples =
            Samples { x: &x, n_inputs, y: &self.train.y, n_outputs: self.train.n_outputs() };
        learner.fit(&samples, stop)
    }

    /// The error of a fitted method on some samples.
    pub(crate) fn error(
        &self,
        fitted: &Fitted,
        values: &ParameterValues,
        rows: &Rows,
    ) -> Result<MethodError, ReproError> {
        let (n_inputs, n_outputs) = (self.train.n_inputs(), self.train.n_outputs());
        let is_contact = matches!(self.method, SearchMethod::Direct | SearchMethod::Svr);
        let (mut maps, mut contacts) = (MapErrorSum::new(n_outputs), Vec::new());
        for block in blocks(0..rows.n, BLOCK) {
            let of = |width: usize| block.start * width..block.end * width;
            let (x, _) = self.inputs(&rows.x[of(n_inputs)], values);
            let found = fitted.predictions(&x, block.len())?;
            let truth = &rows.y[of(n_outputs)];
            if is_contact {
                let each = truth.as_chunks::<4>().0.iter().zip(found.as_chunks::<4>().0);
                contacts.extend(each.map(|(truth, found)| pair(truth, found)));
            } else {
                maps.add(truth, &found);
            }
        }
        if is_contact {
            let stats = ContactStats::of(&contacts, rows.n);
            return Ok(MethodError { main: stats.mean_mm, force_n: Some(stats.mean_n) });
        }
        Ok(MethodError { main: maps.finish().mean_abs_um, force_n: None })
    }

    /// The inputs that the settings ask for, and their width.
    fn inputs<'a>(
        &self,
        x: &'a [f32],
        values: &ParameterValues,
    ) -> (std::borrow::Cow<'a, [f32]>, usize) {
        match values.get("patch") {
            Some(&patch) => {
                let patch = (patch as usize).clamp(1, self.max_patch);
                let width = self.train.n_inputs() / self.max_patch * patch;
                (first_of_patches(x, self.max_patch, patch).into(), width)
            }
            None => (x.into(), self.train.n_inputs()),
        }
    }
}

/// The `patch` virtual gauges nearest to each gauge, of `max_patch` that lie in ascending distance.
fn first_of_patches(x: &[f32], max_patch: usize, patch: usize) -> Vec<f32> {
    let each = x.chunks_exact(max_patch);
    each.flat_map(|gauge| &gauge[..patch]).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_smaller_patch_is_the_first_part_of_each_gauges() {
        let two_samples_of_two_gauges = [1., 2., 3., 4., 5., 6., 7., 8., 9., 10., 11., 12.];
        assert_eq!(
            first_of_patches(&two_samples_of_two_gauges, 3, 2),
            [1., 2., 4., 5., 7., 8., 10., 11.]
        );
    }
}
