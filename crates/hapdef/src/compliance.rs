//! The compliance table: what every surface node and virtual gauge does for a newton at every
//! surface node, and superposition of its rows.

use std::path::Path;

use hapdef_contact::DrawnContact;
use hapdef_data::{DatasetReader, DatasetWriter, TensorSpec};

use crate::error::HapdefError;

const TENSOR: &str = "displacement";

/// Displacement vectors per newton, `[n_loads, n_surface + n_virtual, 3]`, m/N.
///
/// Row `i` answers a unit force of the scene's tip and direction at surface node `i`. Stored in
/// 32 bits: the relative error of 6e-8 is far below that of the mesh.
pub struct ComplianceTable {
    n_surface: usize,
    n_wanted: usize,
    displacement_m_per_n: Vec<f32>,
}

/// Room for one superposed sample.
pub struct SuperpositionScratch {
    sum: Vec<f64>,
}

impl ComplianceTable {
    /// Takes rows `[n_loads, n_wanted, 3]`, m/N, of which the first `n_surface` wanted nodes are
    /// surface nodes and the others virtual gauges.
    #[must_use]
    pub fn new(n_surface: usize, n_wanted: usize, displacement_m_per_n: &[f64]) -> Self {
        let rounded = displacement_m_per_n.iter().map(|v| *v as f32).collect();
        Self { n_surface, n_wanted, displacement_m_per_n: rounded }
    }

    /// Number of surface nodes.
    #[must_use]
    pub fn n_surface(&self) -> usize {
        self.n_surface
    }

    /// Number of virtual gauges.
    #[must_use]
    pub fn n_virtual(&self) -> usize {
        self.n_wanted - self.n_surface
    }

    /// The rows `[n_loads, n_surface + n_virtual, 3]`, m/N, handed over.
    #[must_use]
    pub fn into_rows(self) -> Vec<f32> {
        self.displacement_m_per_n
    }

    /// Scratch of the right size.
    #[must_use]
    pub fn scratch(&self) -> SuperpositionScratch {
        SuperpositionScratch { sum: vec![0.0; self.n_wanted * 3] }
    }

    /// Displacement magnitude of a set of contacts: vectors are superposed first, the magnitude is
    /// taken after (the finite-element tool's "total deformation" of all forces at once).
    ///
    /// Writes `surface_um` `[n_surface]` and `virtual_um` `[n_virtual]`, µm.
    pub fn superpose(
        &self,
        contacts: &[DrawnContact],
        scratch: &mut SuperpositionScratch,
        surface_um: &mut [f32],
        virtual_um: &mut [f32],
    ) {
        let vectors = self.vectors(contacts, scratch);
        for (value, [x, y, z]) in surface_um.iter_mut().chain(virtual_um).zip(vectors) {
            *value = ((x * x + y * y + z * z).sqrt() * 1e6) as f32;
        }
    }

    /// Displacement vectors of a set of contacts, `[n_surface + n_virtual]`, m: the surface nodes,
    /// then the virtual gauges.
    pub fn vectors<'s>(
        &self,
        contacts: &[DrawnContact],
        scratch: &'s mut SuperpositionScratch,
    ) -> &'s [[f64; 3]] {
        scratch.sum.fill(0.0);
        for contact in contacts {
            for (sum, unit) in scratch.sum.iter_mut().zip(self.row(contact.node)) {
                *sum += contact.force_n * f64::from(*unit);
            }
        }
        scratch.sum.as_chunks::<3>().0
    }

    /// Displacement of a surface node for a newton at itself, magnitude, `[n_surface]`, µm/N: the
    /// rigidity map of the paper's figure 3.
    #[must_use]
    pub fn self_compliance_um_per_n(&self) -> Vec<f64> {
        (0..self.n_surface)
            .map(|i| {
                let u = &self.row(i)[3 * i..3 * i + 3];
                u.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>().sqrt() * 1e6
            })
            .collect()
    }

    /// Adds the displacement vectors of a force at surface node `node` to `sum_m` `[n_surface]`, m.
    ///
    /// # Panics
    /// If there is no such node.
    pub fn add_displacement_m(&self, node: usize, force_n: f64, sum_m: &mut [[f32; 3]]) {
        let (unit, _) = self.row(node)[..3 * self.n_surface].as_chunks::<3>();
        for (sum, unit) in sum_m.iter_mut().zip(unit) {
            for (to, from) in sum.iter_mut().zip(unit) {
                *to += force_n as f32 * from;
            }
        }
    }

    /// Writes the table as a dataset file.
    ///
    /// # Errors
    /// [`HapdefError::Data`] when the disk refuses.
    pub fn write(&self, path: &Path) -> Result<(), HapdefError> {
        let width = self.n_wanted * 3;
        let spec = TensorSpec::f32(TENSOR, width, "m/N");
        let mut writer =
            DatasetWriter::create(path, self.displacement_m_per_n.len() / width, &[spec])?;
        for rows in self.displacement_m_per_n.chunks(width * 256) {
            writer.append(TENSOR, rows)?;
        }
        writer.finish()?;
        Ok(())
    }

    /// Reads a table of `n_surface` surface nodes.
    ///
    /// # Errors
    /// [`HapdefError::Data`] when the file is damaged, [`HapdefError::Stale`] when it belongs to
    /// another limb.
    pub fn read(path: &Path, n_surface: usize) -> Result<Self, HapdefError> {
        let mut reader = DatasetReader::open(path)?;
        let width = reader.width(TENSOR)?;
        if reader.n() != n_surface || width / 3 < n_surface {
            let what = format!("expected {n_surface} loads, found {} × {width}", reader.n());
            return Err(HapdefError::Stale { path: path.into(), what });
        }
        let mut rows = vec![0.0_f32; n_surface * width];
        reader.read_rows(TENSOR, 0..n_surface, &mut rows)?;
        Ok(Self { n_surface, n_wanted: width / 3, displacement_m_per_n: rows })
    }

    fn row(&self, load: usize) -> &[f32] {
        let width = self.n_wanted * 3;
        &self.displacement_m_per_n[load * width..(load + 1) * width]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two loads, two surface nodes and one virtual gauge.
    fn table() -> ComplianceTable {
        let first = [1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 3.0].map(|v| v * 1e-6);
        let second = [-1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 4.0, 0.0, 0.0].map(|v| v * 1e-6);
        ComplianceTable::new(2, 3, &[first, second].concat())
    }

    fn superposed(contacts: &[(usize, f64)]) -> Vec<f32> {
        let table = table();
        let contacts: Vec<_> =
            contacts.iter().map(|&(node, force_n)| DrawnContact { node, force_n }).collect();
        let (mut surface, mut virtual_um) = ([0.0; 2], [0.0; 1]);
        table.superpose(&contacts, &mut table.scratch(), &mut surface, &mut virtual_um);
        [surface.as_slice(), &virtual_um].concat()
    }

    #[test]
    fn vectors_add_before_the_magnitude_is_taken() {
        assert_eq!(superposed(&[(0, 1.0), (1, 1.0)]), [0.0, 4.0, 5.0]);
    }

    #[test]
    fn one_contact_scales_with_its_force() {
        assert_eq!(superposed(&[(0, 2.0)]), [2.0, 4.0, 6.0]);
    }

    #[test]
    fn the_table_survives_its_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("compliance.safetensors");
        table().write(&path).unwrap();
        let read = ComplianceTable::read(&path, 2).unwrap();
        assert_eq!(read.displacement_m_per_n, table().displacement_m_per_n);
        assert_eq!(read.self_compliance_um_per_n(), table().self_compliance_um_per_n());
        assert!(ComplianceTable::read(&path, 7).is_err());
    }
}
