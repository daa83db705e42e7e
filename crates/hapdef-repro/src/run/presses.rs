//! Presses of a dataset: readings, maps, and where which force was.

use std::ops::Range;

use anyhow::Result;
use hapdef::stages::samples_path;
use hapdef::{DrawnContact, ScoredContact, Stage};
use hapdef_data::DatasetReader;

/// A dataset of presses, simulated or on the rig.
pub(crate) struct Presses {
    reader: DatasetReader,
    /// Contacts of a press.
    pub(crate) n_contacts: usize,
    /// Surface nodes of a map.
    pub(crate) n_surface: usize,
}

impl Presses {
    /// Opens a dataset stage.
    pub(crate) fn open(stage: &Stage) -> Result<Self> {
        let reader = DatasetReader::open(&samples_path(stage))?;
        Ok(Self {
            n_contacts: reader.width("contact_forces")?,
            n_surface: reader.width("deformation")?,
            reader,
        })
    }

    /// Presses there are.
    pub(crate) fn n(&self) -> usize {
        self.reader.n()
    }

    /// A tensor of `rows`, row-major.
    pub(crate) fn read(&mut self, tensor: &str, rows: Range<usize>) -> Result<Vec<f32>> {
        let mut values = vec![0.0; rows.len() * self.reader.width(tensor)?];
        self.reader.read_rows(tensor, rows, &mut values)?;
        Ok(values)
    }

    /// True contacts of each of `rows`.
    pub(crate) fn truth(&mut self, rows: Range<usize>) -> Result<Vec<Vec<ScoredContact>>> {
        let positions = self.read("contact_positions", rows.clone())?;
        let forces = self.read("contact_forces", rows)?;
        let contact = |(p, f): (&[f32], &f32)| ([p[0], p[1], p[2]].map(f64::from), f64::from(*f));
        let all: Vec<_> = positions.chunks_exact(3).zip(&forces).map(contact).collect();
        Ok(all.chunks(self.n_contacts).map(<[_]>::to_vec).collect())
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
