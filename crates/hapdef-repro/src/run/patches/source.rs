//! Samples superposed when asked for, with smaller patches than the table holds.

use hapdef::{ComplianceTable, DrawnContact};
use hapdef_nets::train::{BatchSource, SourceError};
use rayon::prelude::*;

/// Presses superposed together.
const BLOCK: usize = 512;

/// Patches of `size` nodes, the beginnings of those in a compliance table.
#[derive(Clone, Copy)]
pub(super) struct Patches<'a> {
    table: &'a ComplianceTable,
    n_gauges: usize,
    /// Nodes of a patch.
    pub(super) size: usize,
}

impl<'a> Patches<'a> {
    pub(super) fn new(table: &'a ComplianceTable, n_gauges: usize, size: usize) -> Self {
        Self { table, n_gauges, size }
    }

    /// Virtual gauges in all.
    pub(super) fn width(&self) -> usize {
        self.n_gauges * self.size
    }

    /// Virtual gauges, `[n, width]`, µm, of presses.
    pub(super) fn virtual_gauges(&self, presses: &[Vec<DrawnContact>]) -> Vec<f32> {
        let mut out = vec![0.0; presses.len() * self.width()];
        let mut maps = vec![0.0; BLOCK * self.table.n_surface()];
        let blocks = presses.chunks(BLOCK);
        for (presses, out) in blocks.zip(out.chunks_mut(BLOCK * self.width())) {
            let rows: Vec<&Vec<DrawnContact>> = presses.iter().collect();
            self.superpose(&rows, out, &mut maps);
        }
        out
    }

    /// Virtual gauges `[n, width]` and maps `[n, n_surface]`, µm, of presses.
    fn superpose(&self, presses: &[&Vec<DrawnContact>], virtual_um: &mut [f32], maps: &mut [f32]) {
        let wide = self.table.n_virtual() / self.n_gauges;
        let rows = virtual_um.par_chunks_mut(self.width());
        rows.zip(maps.par_chunks_mut(self.table.n_surface())).zip(presses).for_each_init(
            || (self.table.scratch(), vec![0.0; self.table.n_virtual()]),
            |(scratch, all), ((virtual_um, map), contacts)| {
                self.table.superpose(contacts, scratch, map, all);
                let patches = all.chunks_exact(wide);
                for (out, patch) in virtual_um.chunks_exact_mut(self.size).zip(patches) {
                    out.copy_from_slice(&patch[..self.size]);
                }
            },
        );
    }
}

/// Virtual gauges and maps of presses.
pub(super) struct SuperposedSource<'a> {
    patches: Patches<'a>,
    presses: Vec<Vec<DrawnContact>>,
}

impl<'a> SuperposedSource<'a> {
    pub(super) fn new(patches: Patches<'a>, presses: Vec<Vec<DrawnContact>>) -> Self {
        Self { patches, presses }
    }
}

impl BatchSource for SuperposedSource<'_> {
    fn n_samples(&self) -> usize {
        self.presses.len()
    }

    fn n_inputs(&self) -> usize {
        self.patches.width()
    }

    fn n_outputs(&self) -> usize {
        self.patches.table.n_surface()
    }

    fn fill(&mut self, rows: &[usize], x: &mut [f32], y: &mut [f32]) -> Result<(), SourceError> {
        let presses: Vec<&Vec<DrawnContact>> = rows.iter().map(|row| &self.presses[*row]).collect();
        self.patches.superpose(&presses, x, y);
        Ok(())
    }
}
