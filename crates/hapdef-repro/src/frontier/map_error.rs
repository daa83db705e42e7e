//! How far the displacement of the whole skin is from the truth.

/// Mean of the absolute errors of maps.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MeanError {
    sum_um: f64,
    n: usize,
}

impl MeanError {
    pub(super) fn add(&mut self, map_um: &[f32], truth_um: &[f32]) {
        let off = map_um.iter().zip(truth_um).map(|(a, b)| f64::from(a - b));
        self.sum_um += off.map(f64::abs).sum::<f64>();
        self.n += truth_um.len();
    }

    /// Over all nodes of all maps, µm.
    pub(super) fn mean_um(&self) -> f64 {
        self.sum_um / self.n.max(1) as f64
    }
}
