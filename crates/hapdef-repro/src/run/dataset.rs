//! A dataset read by rows: readings, virtual gauges, maps, and where which force was.

use std::ops::Range;

use anyhow::{Context, Result};
use hapdef::stages::{Datasets, samples_path};
use hapdef::{ContactPair, DrawnContact, Pipeline, ScoredContact, Stage};
use hapdef_data::{DatasetReader, Split};
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
        self.x.extend(set.part(inputs, rows.clone())?);
        self.y.extend(set.part(outputs, rows)?);
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

/// Presses, simulated or on the rig.
pub(crate) struct Dataset {
    reader: DatasetReader,
    /// Contacts of a press.
    pub(crate) n_contacts: usize,
    /// Virtual gauges of a press.
    pub(crate) n_virtual: usize,
    /// Surface nodes of a map.
    pub(crate) n_surface: usize,
}

impl Dataset {
    /// Opens a dataset stage.
    pub(crate) fn open(stage: &Stage) -> Result<Self> {
        let reader = DatasetReader::open(&samples_path(stage))?;
        Ok(Self {
            n_contacts: reader.width("contact_forces")?,
            n_virtual: reader.width("virtual_gauges")?,
            n_surface: reader.width("deformation")?,
            reader,
        })
    }

    /// Opens every simulated set, single contacts first.
    pub(crate) fn open_all(data: &Datasets) -> Result<Vec<Self>> {
        data.simulated.iter().map(Self::open).collect()
    }

    /// Presses there are.
    pub(crate) fn n(&self) -> usize {
        self.reader.n()
    }

    /// Which presses train, validate and test.
    pub(crate) fn split(&self) -> Result<Split> {
        Ok(Split::of(self.n())?)
    }

    /// A tensor of `rows`, row-major.
    fn read(&mut self, tensor: &str, rows: Range<usize>) -> Result<Vec<f32>> {
        let mut values = vec![0.0; rows.len() * self.reader.width(tensor)?];
        self.reader.read_rows(tensor, rows, &mut values)?;
        Ok(values)
    }

    /// Readings of `rows`, `[n, n_gauges]`, µε.
    pub(crate) fn readings(&mut self, rows: Range<usize>) -> Result<Vec<f32>> {
        self.read("readings", rows)
    }

    /// Virtual gauges of `rows`, `[n, n_virtual]`, µm.
    pub(crate) fn inputs(&mut self, rows: Range<usize>) -> Result<Vec<f32>> {
        self.read("virtual_gauges", rows)
    }

    /// Maps of `rows`, `[n, n_surface]`, µm.
    pub(crate) fn maps(&mut self, rows: Range<usize>) -> Result<Vec<f32>> {
        self.read("deformation", rows)
    }

    /// A part of `rows`, row-major.
    pub(crate) fn part(&mut self, part: Part, rows: Range<usize>) -> Result<Vec<f32>> {
        match part {
            Part::Readings => self.readings(rows),
            Part::Gauges => self.inputs(rows),
            Part::Map => self.maps(rows),
            Part::Contact => Ok(self.contacts(rows)?.into_flattened()),
        }
    }

    /// Positions, m, and forces, N, of the contacts of `rows`, `[n * n_contacts]`.
    pub(crate) fn contacts(&mut self, rows: Range<usize>) -> Result<Vec<[f32; 4]>> {
        let positions = self.read("contact_positions", rows.clone())?;
        let forces = self.read("contact_forces", rows)?;
        let places = positions.as_chunks::<3>().0.iter().zip(forces);
        Ok(places.map(|([x, y, z], force_n)| [*x, *y, *z, force_n]).collect())
    }

    /// True contacts of each of `rows`.
    pub(crate) fn truth(&mut self, rows: Range<usize>) -> Result<Vec<Vec<ScoredContact>>> {
        let contact =
            |[x, y, z, force_n]: &[f32; 4]| ([x, y, z].map(|v| f64::from(*v)), f64::from(*force_n));
        let all = self.contacts(rows)?;
        Ok(all.chunks(self.n_contacts).map(|press| press.iter().map(contact).collect()).collect())
    }

    /// Pressed nodes and forces of each of `rows`.
    pub(crate) fn drawn(&mut self, rows: Range<usize>) -> Result<Vec<Vec<DrawnContact>>> {
        let mut nodes = vec![0_i32; rows.len() * self.n_contacts];
        self.reader.read_rows("contact_nodes", rows.clone(), &mut nodes)?;
        let forces = self.read("contact_forces", rows)?;
        let drawn = |(node, force): (&i32, &f32)| DrawnContact {
            node: *node as usize,
            force_n: f64::from(*force),
        };
        let all: Vec<_> = nodes.iter().zip(&forces).map(drawn).collect();
        Ok(all.chunks(self.n_contacts).map(<[_]>::to_vec).collect())
    }
}

/// The rig's single presses and which of them are for training and for testing.
pub(crate) fn rig_singles(done: &Pipeline) -> Result<(Dataset, Split)> {
    let data = done.data.as_ref().context("no datasets")?;
    let presses = Dataset::open(&data.rig_single)?;
    let split = presses.split()?;
    Ok((presses, split))
}

/// `rows` in blocks of at most `n`.
pub(crate) fn blocks(rows: Range<usize>, n: usize) -> impl Iterator<Item = Range<usize>> {
    let end = rows.end;
    rows.step_by(n).map(move |start| start..(start + n).min(end))
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
