//! Buffers of a pass, and which of a layer's inputs it reads.

use super::kernels::{Active, ActiveBytes, Extent, MOST_BYTES, Sixteen};
use super::panels::{F32Line, I32Line, Line};

/// Buffers of a pass.
#[derive(Debug, Clone, Default)]
pub(super) struct LayerScratch {
    /// Inputs of the layer before the pass, outputs after it; whole lines.
    pub(super) values: Vec<Sixteen<f32>>,
    /// How far the outputs of the last pass reach.
    pub(super) extent: Extent,
    pub(super) sums: Vec<F32Line>,
    pub(super) whole_sums: Vec<I32Line>,
    /// The inputs as whole numbers.
    pub(super) steps: Vec<u16>,
    active: Vec<Active>,
    active_rows: Vec<u32>,
    active_bytes: [Vec<u8>; MOST_BYTES],
}

impl LayerScratch {
    /// Makes room for a layer of `n_in` inputs and `n_out` outputs.
    pub(super) fn reserve(&mut self, n_in: usize, n_out: usize) {
        fn at_least<T>(buffer: &mut Vec<T>, n: usize) {
            buffer.reserve(n.saturating_sub(buffer.len()));
        }
        let n_lines = n_out.div_ceil(64) * 4;
        at_least(&mut self.values, n_in.max(n_out).div_ceil(16));
        at_least(&mut self.sums, n_lines);
        at_least(&mut self.whole_sums, n_lines * MOST_BYTES);
        at_least(&mut self.steps, n_in);
        at_least(&mut self.active, n_in);
        at_least(&mut self.active_rows, n_in.next_multiple_of(4));
        for bytes in &mut self.active_bytes {
            at_least(bytes, n_in.next_multiple_of(4));
        }
    }

    /// The first `n_in` values that are not 0, and room for the sums.
    pub(super) fn active(&mut self, n_in: usize, n_lines: usize) -> (&[Active], &mut [F32Line]) {
        // Without a branch: half of the values are 0, and nobody can guess which.
        let none = Active { row: 0, value: 0.0 };
        self.active.resize(n_in, none);
        let mut n_active = 0;
        for (row, &value) in self.values.as_flattened()[..n_in].iter().enumerate() {
            let row = row as u32;
            self.active[n_active] = Active { row, value };
            n_active += usize::from(value != 0.0);
        }
        self.sums.resize(n_lines, Line([0.0; 16]));
        (&self.active[..n_active], &mut self.sums)
    }

    /// The steps that are not 0, how many they are, and room for the sums.
    pub(super) fn active_bytes(
        &mut self,
        n_lines: usize,
    ) -> (ActiveBytes<'_>, usize, &mut [I32Line]) {
        let n = self.steps.len().next_multiple_of(4);
        self.active_rows.resize(n, 0);
        let [low, high] = &mut self.active_bytes;
        low.resize(n, 0);
        high.resize(n, 0);
        let mut n_active = 0;
        for (row, &steps) in self.steps.iter().enumerate() {
            self.active_rows[n_active] = row as u32;
            [low[n_active], high[n_active]] = steps.to_le_bytes();
            n_active += usize::from(steps != 0);
        }
        let n_filled = n_active.next_multiple_of(4);
        self.active_rows[n_active..n_filled].fill(0);
        low[n_active..n_filled].fill(0);
        high[n_active..n_filled].fill(0);
        let active = ActiveBytes {
            rows: &self.active_rows[..n_filled],
            bytes: [&low[..n_filled], &high[..n_filled]],
        };
        self.whole_sums.resize(n_lines, Line([0; 16]));
        (active, n_active, &mut self.whole_sums)
    }
}
