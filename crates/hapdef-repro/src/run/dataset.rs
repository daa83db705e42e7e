//! Samples of datasets in memory.

use std::ops::Range;

use anyhow::{Context, Result};
pub(crate) use hapdef::stages::{Dataset, blocks};
use hapdef::{ContactPair, Pipeline};
use hapdef_data::Split;
use hapdef_nets::train::MemorySource;

use crate::search::Samples;

/// Position, m, and force, N, of a contact.
pub(crate) type Contact = [f32; 4];

/// What is an input or an output of a method.
#[derive(Clone, Copy)]
pub(crate) enum Part {
    /// Readings, µε.
    Readings,
    /// Virtual gauges, µm.
    Gauges,
    /// The map, µm.
    Map,
    /// Position, m, and force, N, of the only contact.
    Contact,
}

impl Part {
    /// Those of `rows`, row-major.
    fn of(self, set: &mut Dataset, rows: Range<usize>) -> Result<Vec<f32>> {
        Ok(match self {
            Self::Readings => set.readings(rows)?,
            Self::Gauges => set.inputs(rows)?,
            Self::Map => set.maps(rows)?,
            Self::Contact => set.contacts(rows)?.into_flattened(),
        })
    }
}

/// Inputs and outputs of samples in memory, row-major.
#[derive(Default)]
pub(crate) struct Rows {
    /// Samples.
    pub(crate) n: usize,
    /// Inputs `[n, n_inputs]` and outputs `[n, n_outputs]`.
    pub(crate) x: Vec<f32>,
    pub(crate) y: Vec<f32>,
}

impl Rows {
    /// Those of the presses `rows` of a set.
    pub(crate) fn of(set: &mut Dataset, parts: [Part; 2], rows: Range<usize>) -> Result<Self> {
        let mut all = Self::default();
        all.add(set, parts, rows)?;
        Ok(all)
    }

    /// Virtual gauges and maps of the training samples of these sets.
    pub(crate) fn training(sets: &mut [Dataset]) -> Result<Self> {
        let mut all = Self::default();
        for set in sets {
            let rows = set.split()?.train;
            all.add(set, [Part::Gauges, Part::Map], rows)?;
        }
        Ok(all)
    }

    /// Adds the presses `rows` of a set.
    pub(crate) fn add(
        &mut self,
        set: &mut Dataset,
        [inputs, outputs]: [Part; 2],
        rows: Range<usize>,
    ) -> Result<()> {
        self.n += rows.len();
        self.x.extend(inputs.of(set, rows.clone())?);
        self.y.extend(outputs.of(set, rows)?);
        Ok(())
    }

    /// Inputs of a sample.
    pub(crate) fn n_inputs(&self) -> usize {
        self.x.len() / self.n.max(1)
    }

    /// Outputs of a sample.
    pub(crate) fn n_outputs(&self) -> usize {
        self.y.len() / self.n.max(1)
    }

    /// For a method.
    pub(crate) fn samples(&self) -> Samples<'_> {
        let (n_inputs, n_outputs) = (self.n_inputs(), self.n_outputs());
        Samples { x: &self.x, n_inputs, y: &self.y, n_outputs }
    }

    /// For the training of a net.
    pub(crate) fn source(self) -> Result<MemorySource> {
        let (n_inputs, n_outputs) = (self.n_inputs(), self.n_outputs());
        Ok(MemorySource::new(n_inputs, n_outputs, self.x, self.y)?)
    }
}

/// The rig's single presses and which of them are for training and for testing.
pub(crate) fn rig_singles(done: &Pipeline) -> Result<(Dataset, Split)> {
    let data = done.data.as_ref().context("no datasets")?;
    let presses = Dataset::open(&data.rig_single)?;
    let split = presses.split()?;
    Ok((presses, split))
}

/// The first of `rows`, at most `most`.
pub(crate) fn first_of(rows: Range<usize>, most: usize) -> Range<usize> {
    rows.start..rows.end.min(rows.start + most)
}

/// At most `most` of `rows`, evenly apart.
pub(crate) fn evenly(rows: Range<usize>, most: usize) -> impl Iterator<Item = usize> {
    let n = rows.len().min(most);
    let (start, all) = (rows.start, rows.len());
    (0..n).map(move |i| start + i * all / n)
}

/// A single contact beside the one found.
pub(crate) fn pair(truth: &Contact, found: &Contact) -> ContactPair {
    let offset = (0..3).map(|i| f64::from(found[i] - truth[i]).powi(2));
    ContactPair {
        detected: 0,
        truth: 0,
        position_error_m: offset.sum::<f64>().sqrt(),
        force_error_n: f64::from(found[3] - truth[3]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_chosen_evenly_and_none_twice() {
        assert_eq!(evenly(10..20, 4).collect::<Vec<_>>(), [10, 12, 15, 17]);
        assert_eq!(evenly(3..5, 9).collect::<Vec<_>>(), [3, 4]);
        assert_eq!(evenly(3..3, 9).count(), 0);
    }
}
