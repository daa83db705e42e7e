//! A dataset read by rows: readings, virtual gauges, maps, and where which force was.

use std::ops::Range;

use hapdef_contact::DrawnContact;
use hapdef_data::{DatasetReader, Split};

use super::dataset::{Datasets, samples_path};
use crate::cache::Stage;
use crate::error::HapdefError;
use crate::scoring::ScoredContact;

/// Presses, simulated or on the rig.
pub struct Dataset {
    reader: DatasetReader,
    /// Contacts of a press.
    pub n_contacts: usize,
    /// Virtual gauges of a press.
    pub n_virtual: usize,
    /// Surface nodes of a map.
    pub n_surface: usize,
}

impl Dataset {
    /// Opens a dataset stage.
    ///
    /// # Errors
    /// A file that is damaged.
    pub fn open(stage: &Stage) -> Result<Self, HapdefError> {
        let reader = DatasetReader::open(&samples_path(stage))?;
        Ok(Self {
            n_contacts: reader.width("contact_forces")?,
            n_virtual: reader.width("virtual_gauges")?,
            n_surface: reader.width("deformation")?,
            reader,
        })
    }

    /// Opens every simulated set, single contacts first.
    ///
    /// # Errors
    /// A file that is damaged.
    pub fn open_all(data: &Datasets) -> Result<Vec<Self>, HapdefError> {
        data.simulated.iter().map(Self::open).collect()
    }

    /// Presses there are.
    #[must_use]
    pub fn n(&self) -> usize {
        self.reader.n()
    }

    /// Which presses train, validate and test.
    ///
    /// # Errors
    /// A file that is damaged.
    pub fn split(&self) -> Result<Split, HapdefError> {
        Ok(Split::of(self.n())?)
    }

    /// A tensor of `rows`, row-major.
    fn read(&mut self, tensor: &str, rows: Range<usize>) -> Result<Vec<f32>, HapdefError> {
        let mut values = vec![0.0; rows.len() * self.reader.width(tensor)?];
        self.reader.read_rows(tensor, rows, &mut values)?;
        Ok(values)
    }

    /// Readings of `rows`, `[n, n_gauges]`, µε.
    ///
    /// # Errors
    /// A file that is damaged.
    pub fn readings(&mut self, rows: Range<usize>) -> Result<Vec<f32>, HapdefError> {
        self.read("readings", rows)
    }

    /// Virtual gauges of `rows`, `[n, n_virtual]`, µm.
    ///
    /// # Errors
    /// A file that is damaged.
    pub fn inputs(&mut self, rows: Range<usize>) -> Result<Vec<f32>, HapdefError> {
        self.read("virtual_gauges", rows)
    }

    /// Maps of `rows`, `[n, n_surface]`, µm.
    ///
    /// # Errors
    /// A file that is damaged.
    pub fn maps(&mut self, rows: Range<usize>) -> Result<Vec<f32>, HapdefError> {
        self.read("deformation", rows)
    }

    /// Positions, m, and forces, N, of the contacts of `rows`, `[n * n_contacts]`.
    ///
    /// # Errors
    /// A file that is damaged.
    pub fn contacts(&mut self, rows: Range<usize>) -> Result<Vec<[f32; 4]>, HapdefError> {
        let positions = self.read("contact_positions", rows.clone())?;
        let forces = self.read("contact_forces", rows)?;
        let places = positions.as_chunks::<3>().0.iter().zip(forces);
        Ok(places.map(|([x, y, z], force_n)| [*x, *y, *z, force_n]).collect())
    }

    /// True contacts of each of `rows`.
    ///
    /// # Errors
    /// A file that is damaged.
    pub fn truth(&mut self, rows: Range<usize>) -> Result<Vec<Vec<ScoredContact>>, HapdefError> {
        let contact =
            |[x, y, z, force_n]: &[f32; 4]| ([x, y, z].map(|v| f64::from(*v)), f64::from(*force_n));
        let all = self.contacts(rows)?;
        Ok(all.chunks(self.n_contacts).map(|press| press.iter().map(contact).collect()).collect())
    }

    /// Pressed nodes and forces of each of `rows`.
    ///
    /// # Errors
    /// A file that is damaged.
    pub fn drawn(&mut self, rows: Range<usize>) -> Result<Vec<Vec<DrawnContact>>, HapdefError> {
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

/// `rows` in blocks of at most `n`.
pub fn blocks(rows: Range<usize>, n: usize) -> impl Iterator<Item = Range<usize>> {
    let end = rows.end;
    rows.step_by(n).map(move |start| start..(start + n).min(end))
}
