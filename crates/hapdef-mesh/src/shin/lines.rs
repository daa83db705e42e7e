//! Where the grid's lines run around and along the limb.

use std::f64::consts::TAU;

use super::ShinParams;

/// Lines around: their angles, and per cell the sector it belongs to or `None` for an axial rib.
pub(super) struct Around {
    pub(super) lines: Vec<f64>,
    pub(super) parts: Vec<Option<usize>>,
    /// First angle and width of each sector's panel.
    pub(super) sectors: Vec<(f64, f64)>,
}

/// The lines of `params`.
pub(super) fn lines_around(params: &ShinParams) -> Around {
    let outline = &params.outline;
    let middle_m = outline.mean_radius_m(outline.bottom_m + 0.5 * outline.height_m);
    let rib = params.rib_width_m / middle_m;
    let sizes = uneven(params.n_sectors, params.unevenness, 2.3);
    let free = TAU - rib * params.n_sectors as f64;
    let mut around = Around { lines: Vec::new(), parts: Vec::new(), sectors: Vec::new() };
    let mut theta = 0.0;
    for (sector, size) in sizes.iter().enumerate() {
        around.lines.push(theta);
        around.parts.push(None);
        theta += rib;
        let width = free * size;
        around.sectors.push((theta, width));
        for cell in 0..params.panel_cells.0 {
            around.lines.push(theta + width * cell as f64 / params.panel_cells.0 as f64);
            around.parts.push(Some(sector));
        }
        theta += width;
    }
    around
}

/// What a row of cells belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BandPart {
    EndRing,
    Band,
    Rib,
}

/// Lines along: their heights, one more than the rows of cells.
pub(super) struct Along {
    pub(super) lines: Vec<f64>,
    pub(super) parts: Vec<BandPart>,
    /// Lower end and height of each band's panels, m.
    pub(super) bands: Vec<(f64, f64)>,
}

/// The lines of `params`.
pub(super) fn lines_along(params: &ShinParams) -> Along {
    let outline = &params.outline;
    let n_ribs = params.n_bands - 1;
    let free = outline.height_m - 2.0 * params.end_ring_m - params.rib_width_m * n_ribs as f64;
    let mut y_m = outline.bottom_m;
    let mut along = Along { lines: vec![y_m], parts: vec![BandPart::EndRing], bands: Vec::new() };
    y_m += params.end_ring_m;
    for (band, size) in uneven(params.n_bands, params.unevenness, 1.7).iter().enumerate() {
        let height = free * size;
        along.bands.push((y_m, height));
        for cell in 0..params.panel_cells.1 {
            along.lines.push(y_m + height * cell as f64 / params.panel_cells.1 as f64);
            along.parts.push(BandPart::Band);
        }
        y_m += height;
        along.lines.push(y_m);
        let last = band == n_ribs;
        along.parts.push(if last { BandPart::EndRing } else { BandPart::Rib });
        y_m += if last { params.end_ring_m } else { params.rib_width_m };
    }
    along.lines.push(outline.bottom_m + outline.height_m);
    along
}

/// `n` shares of 1 that differ by about `unevenness`, without a pattern that repeats.
fn uneven(n: usize, unevenness: f64, step: f64) -> Vec<f64> {
    let sizes: Vec<f64> =
        (0..n).map(|i| 1.0 + unevenness * (step * i as f64 + 0.4).sin()).collect();
    let total: f64 = sizes.iter().sum();
    sizes.iter().map(|size| size / total).collect()
}
