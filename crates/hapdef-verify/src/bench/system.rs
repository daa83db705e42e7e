//! The same matrix and right-hand sides for every solver.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use hapdef_sim::{ElasticModel, NodalLoad, SimError, StiffnessMatrix};

/// A matrix and sparse right-hand sides.
pub(crate) struct System {
    pub(crate) matrix: StiffnessMatrix,
    /// Equations and values of each load.
    pub(crate) loads: Vec<Vec<(u32, f64)>>,
}

impl System {
    pub(crate) fn of(model: &ElasticModel, loads: &[NodalLoad]) -> Result<Self, SimError> {
        let loads = loads.iter().map(|load| model.right_hand_side(load));
        Ok(Self { matrix: model.stiffness_matrix()?, loads: loads.collect::<Result<_, _>>()? })
    }

    pub(crate) fn n(&self) -> usize {
        self.matrix.col_ptr.len() - 1
    }

    /// Writes the file that `cholmod.c` describes.
    pub(crate) fn write(&self, path: &Path) -> io::Result<()> {
        let mut file = BufWriter::new(std::fs::File::create(path)?);
        let mut start = vec![0_i64];
        for load in &self.loads {
            start.push(start[start.len() - 1] + load.len() as i64);
        }
        let sizes = [self.n(), self.matrix.values.len(), self.loads.len()];
        for size in sizes {
            file.write_all(&(size as i64).to_le_bytes())?;
        }
        for index in self.matrix.col_ptr.iter().chain(&self.matrix.row_idx) {
            file.write_all(&index.to_le_bytes())?;
        }
        for value in &self.matrix.values {
            file.write_all(&value.to_le_bytes())?;
        }
        for offset in start {
            file.write_all(&offset.to_le_bytes())?;
        }
        for (row, _) in self.loads.iter().flatten() {
            file.write_all(&row.to_le_bytes())?;
        }
        for (_, value) in self.loads.iter().flatten() {
            file.write_all(&value.to_le_bytes())?;
        }
        file.flush()
    }
}
