//! How many unknowns the live gauges can determine.

use crate::dense::{add_scaled, cholesky, dot, padded, solve_lower};
use crate::noise::NoiseParams;
use crate::response::ResponseMap;
use crate::sites::ScanSites;

/// A direction of the readings counts where a contact moves the readings by this many
/// standard deviations of the noise along it: blind gauges and twins otherwise vouch for contacts that
/// nothing checks. At three noise alone explains such a movement in 0.3 % of the frames.
const SEEN_SDS: f64 = 3.0;

/// Directions in which contacts of `force_n` move the readings of the gauges `live`: readings
/// at the scan sites in units of the noise and of loads that are no contacts, the longest taken and taken out of all others, until
/// none is longer than three. Blind gauges add nothing, and twins no more than one of them.
pub(crate) fn effective_rank(
    map: &ResponseMap,
    sites: &ScanSites,
    noise: &NoiseParams,
    live: &[usize],
    force_n: f64,
) -> usize {
    let mut l = noise.covariance(live);
    if !cholesky(&mut l, live.len(), 0.0) {
        return 0;
    }
    let scaled = |g: Vec<f64>| -> Vec<f64> {
        let mut row: Vec<f64> = live.iter().map(|&gauge| force_n * g[gauge]).collect();
        solve_lower(&l, live.len(), &mut row);
        row.resize(padded(live.len()), 0.0);
        row
    };
    let at_sites = sites.points().iter().map(|point| scaled(map.normal(point)));
    let mut rows: Vec<Vec<f64>> = at_sites.collect();
    let mut n = 0;
    while n < live.len() {
        let longest = rows
            .iter()
            .max_by(|a, b| dot(a, a).total_cmp(&dot(b, b)))
            .filter(|row| dot(row, row) > SEEN_SDS * SEEN_SDS);
        let Some(longest) = longest.cloned() else {
            break;
        };
        let square = dot(&longest, &longest);
        for row in &mut rows {
            let share = dot(row, &longest) / square;
            add_scaled(row, -share, &longest);
        }
        n += 1;
    }
    n
}
