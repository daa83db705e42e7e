//! Presses that the rows are tested on.

use anyhow::Result;
use hapdef::{DrawnContact, ScoredContact, Stage};

use super::super::dataset::{Dataset, evenly};

/// Presses that pass a row together.
const BLOCK: usize = 128;

/// Some presses.
#[derive(Default)]
pub(super) struct Frames {
    /// `[n, n_gauges]`, µε; none if simulated.
    pub(super) readings: Vec<f32>,
    /// `[n, n_virtual]`, µm.
    pub(super) virtual_um: Vec<f32>,
    pub(super) drawn: Vec<Vec<DrawnContact>>,
    pub(super) truth: Vec<Vec<ScoredContact>>,
}

impl Frames {
    pub(super) fn one_by_one(&self) -> impl Iterator<Item = Self> + '_ {
        let n = self.drawn.len();
        let row = move |values: &[f32], i: usize| {
            let width = values.len() / n;
            values[i * width..(i + 1) * width].to_vec()
        };
        (0..n).map(move |i| Self {
            readings: row(&self.readings, i),
            virtual_um: row(&self.virtual_um, i),
            drawn: vec![self.drawn[i].clone()],
            truth: vec![self.truth[i].clone()],
        })
    }
}

/// At most `most` presses, evenly apart, in blocks.
pub(super) fn frames(
    stage: &Stage,
    rows: impl Fn(&Dataset) -> Result<std::ops::Range<usize>>,
    most: usize,
    has_readings: bool,
) -> Result<Vec<Frames>> {
    let mut presses = Dataset::open(stage)?;
    let chosen: Vec<usize> = evenly(rows(&presses)?, most).collect();
    let mut all = vec![];
    for block in chosen.chunks(BLOCK) {
        let mut frames = Frames::default();
        for &row in block {
            let rows = row..row + 1;
            if has_readings {
                frames.readings.extend(presses.readings(rows.clone())?);
            }
            frames.virtual_um.extend(presses.inputs(rows.clone())?);
            frames.drawn.extend(presses.drawn(rows.clone())?);
            frames.truth.extend(presses.truth(rows)?);
        }
        all.push(frames);
    }
    Ok(all)
}
