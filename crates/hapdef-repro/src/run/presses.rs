//! Presses that methods are tested on.

use anyhow::Result;
use hapdef::{DrawnContact, ScoredContact, Stage};

use super::dataset::{Dataset, evenly};

/// Presses that pass a method together.
const BLOCK: usize = 128;

/// Some presses.
#[derive(Default)]
pub(crate) struct Presses {
    /// `[n, n_gauges]`, µε; none if simulated.
    pub(crate) readings: Vec<f32>,
    /// `[n, n_virtual]`, µm.
    pub(crate) virtual_um: Vec<f32>,
    pub(crate) drawn: Vec<Vec<DrawnContact>>,
    pub(crate) truth: Vec<Vec<ScoredContact>>,
}

impl Presses {
    pub(crate) fn one_by_one(&self) -> impl Iterator<Item = Self> + '_ {
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
pub(crate) fn presses(
    stage: &Stage,
    rows: impl Fn(&Dataset) -> Result<std::ops::Range<usize>>,
    most: usize,
    has_readings: bool,
) -> Result<Vec<Presses>> {
    let mut set = Dataset::open(stage)?;
    let chosen: Vec<usize> = evenly(rows(&set)?, most).collect();
    let mut all = vec![];
    for block in chosen.chunks(BLOCK) {
        let mut together = Presses::default();
        for &row in block {
            let rows = row..row + 1;
            if has_readings {
                together.readings.extend(set.readings(rows.clone())?);
            }
            together.virtual_um.extend(set.inputs(rows.clone())?);
            together.drawn.extend(set.drawn(rows.clone())?);
            together.truth.extend(set.truth(rows)?);
        }
        all.push(together);
    }
    Ok(all)
}
