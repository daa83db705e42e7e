//! One pass of exchanges on the tail of two contacts.

use crate::error::InverseError;
use crate::placement::information::Information;
use crate::placement::score::{bounds, draw_pairs, quantile};
use crate::placement::{Candidates, PlacementParams};

/// Each gauge of `chosen` that is not mounted is taken out in turn and put where the 95th
/// percentile of the two-contact position bound is least, among the candidates that add most to the
/// mean log-det without it; it stays where nothing is better. Correlated information makes greedy
/// choices regrettable, and the tail is not what greedy maximises: this pass mends both.
///
/// # Errors
/// [`InverseError`] for unusable arrays or parameters, or a gauge that is no candidate.
pub fn exchange(
    candidates: &Candidates,
    chosen: &[usize],
    params: &PlacementParams,
) -> Result<Vec<usize>, InverseError> {
    let checked = PlacementParams { mounted: chosen.to_vec(), ..params.clone() };
    candidates.check(&checked)?;
    let tail = Tail::new(candidates, params);
    let mut layout = chosen.to_vec();
    let mut least = tail.of(&layout);
    for place in 0..layout.len() {
        if params.mounted.contains(&layout[place]) {
            continue;
        }
        let mut others = layout.clone();
        others.remove(place);
        for c in promising(candidates, &others, params) {
            let mut trial = layout.clone();
            trial[place] = c;
            let found = tail.of(&trial);
            if found < least {
                (layout, least) = (trial, found);
            }
        }
    }
    Ok(layout)
}

/// How badly the worst placed of drawn pairs of contacts are placed.
pub(crate) struct Tail<'a> {
    candidates: &'a Candidates,
    params: &'a PlacementParams,
    pairs: Vec<[usize; 2]>,
}

impl<'a> Tail<'a> {
    pub(crate) fn new(candidates: &'a Candidates, params: &'a PlacementParams) -> Self {
        Self { candidates, params, pairs: draw_pairs(candidates, params) }
    }

    /// The 95th percentile of the position bound under a layout, m.
    pub(crate) fn of(&self, layout: &[usize]) -> f64 {
        let of_pair = |pair: &[usize; 2]| bounds::<2>(self.candidates, layout, self.params, *pair);
        let mut all: Vec<f64> = self.pairs.iter().flat_map(of_pair).collect();
        quantile(&mut all, 0.95)
    }
}

/// The candidates beside `others` that add most to the mean log-det, best first.
fn promising(candidates: &Candidates, others: &[usize], params: &PlacementParams) -> Vec<usize> {
    let information = Information::of(candidates, params, others);
    let mut ranked: Vec<(usize, f64)> = (0..candidates.n())
        .filter(|&c| candidates.fits(c, others, params))
        .map(|c| (c, information.gain(c)))
        .collect();
    ranked.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    ranked.truncate(params.n_tried);
    ranked.into_iter().map(|(c, _)| c).collect()
}
