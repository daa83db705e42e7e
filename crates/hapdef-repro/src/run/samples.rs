//! Virtual gauges and maps of the simulated sets, read by blocks.

use std::ops::Range;

use anyhow::Result;
use hapdef::stages::{Datasets, samples_path};
use hapdef_data::{DatasetReader, Split};

/// One simulated set.
pub(crate) struct SampleSet {
    reader: DatasetReader,
    /// Which samples train, validate and test.
    pub(crate) split: Split,
    /// Virtual gauges of a sample.
    pub(crate) n_virtual: usize,
    /// Surface nodes of a map.
    pub(crate) n_surface: usize,
}

impl SampleSet {
    /// Opens every simulated set, single contacts first.
    pub(crate) fn open_all(data: &Datasets) -> Result<Vec<Self>> {
        data.simulated
            .iter()
            .map(|stage| {
                let reader = DatasetReader::open(&samples_path(stage))?;
                Ok(Self {
                    split: Split::of(reader.n())?,
                    n_virtual: reader.width("virtual_gauges")?,
                    n_surface: reader.width("deformation")?,
                    reader,
                })
            })
            .collect()
    }

    /// Virtual gauges of `rows`, `[n, n_virtual]`, µm.
    pub(crate) fn inputs(&mut self, rows: Range<usize>) -> Result<Vec<f32>> {
        let mut x = vec![0.0; rows.len() * self.n_virtual];
        self.reader.read_rows("virtual_gauges", rows, &mut x)?;
        Ok(x)
    }

    /// Maps of `rows`, `[n, n_surface]`, µm.
    pub(crate) fn maps(&mut self, rows: Range<usize>) -> Result<Vec<f32>> {
        let mut y = vec![0.0; rows.len() * self.n_surface];
        self.reader.read_rows("deformation", rows, &mut y)?;
        Ok(y)
    }

    /// The map of one sample into `out` `[n_surface]`, µm.
    pub(crate) fn map_into(
        &mut self,
        row: usize,
        out: &mut [f32],
    ) -> Result<(), hapdef_data::DataError> {
        self.reader.read_rows("deformation", row..row + 1, out)
    }
}

/// `rows` in blocks of at most `n`.
pub(crate) fn blocks(rows: Range<usize>, n: usize) -> impl Iterator<Item = Range<usize>> {
    let end = rows.end;
    rows.step_by(n).map(move |start| start..(start + n).min(end))
}
