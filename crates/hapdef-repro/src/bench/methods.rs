//! Methods from one frame's virtual gauges to its map.

use crate::baselines::{Knn, KnnParams, LinearRegression};
use anyhow::Result;
use hapdef_data::Standardiser;
use hapdef_nets::infer::{InferScratch, PreparedNet};

/// A method from virtual gauges `[n_virtual]`, µm, to the map `[n_outputs]`, µm.
pub(super) trait MapMethod: Send {
    /// One frame.
    fn map(&mut self, virtual_um: &[f32], out: &mut [f32]) -> Result<()>;

    /// Bytes of what it keeps in memory.
    fn bytes(&self) -> usize;
}

/// A prepared F_R.
pub(super) struct Fnn {
    pub(super) net: PreparedNet,
    pub(super) scratch: InferScratch,
}

/// Linear regression.
pub(super) struct Linear {
    pub(super) regression: LinearRegression,
}

/// k nearest neighbours on standardised virtual gauges, all training maps in memory.
pub(super) struct Neighbourhood {
    pub(super) knn: Knn,
    pub(super) standardiser: Standardiser,
    /// `[n, n_surface]`, µm.
    pub(super) maps: Vec<f32>,
}

impl MapMethod for Fnn {
    fn map(&mut self, virtual_um: &[f32], out: &mut [f32]) -> Result<()> {
        self.net.forward(virtual_um, &mut self.scratch, out)?;
        Ok(())
    }

    fn bytes(&self) -> usize {
        self.net.bytes()
    }
}

impl MapMethod for Linear {
    fn map(&mut self, virtual_um: &[f32], out: &mut [f32]) -> Result<()> {
        Ok(self.regression.predict(virtual_um, out)?)
    }

    fn bytes(&self) -> usize {
        let n_in = self.regression.n_inputs();
        (n_in + 1) * self.regression.n_outputs() * size_of::<f32>()
    }
}

impl MapMethod for Neighbourhood {
    fn map(&mut self, virtual_um: &[f32], out: &mut [f32]) -> Result<()> {
        let mut query = virtual_um.to_vec();
        self.standardiser.apply(&mut query)?;
        let found = self.knn.neighbours(&query, &KnnParams::default())?;
        let width = out.len();
        let fetch = |row: usize, buffer: &mut [f32]| -> std::io::Result<()> {
            buffer.copy_from_slice(&self.maps[row * width..(row + 1) * width]);
            Ok(())
        };
        Ok(found.predict(0, fetch, out)?)
    }

    fn bytes(&self) -> usize {
        size_of_val(&self.maps[..])
            + self.knn.n_rows() * self.standardiser.width() * size_of::<f32>()
    }
}
