//! Holes in the panels between the ribs.

/// An elliptic hole in one panel. A cell is left out if its centre lies in the ellipse, and the
/// cells around it reach to its rim. A hole that comes nearer to a rib or another hole than one
/// cell loses its round shape there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShinHole {
    /// The panel's sector, counted around from θ = 0.
    pub sector: usize,
    /// The panel's band, counted from below.
    pub band: usize,
    /// Centre in parts of the panel's size, around and along: (0.5, 0.5) is its middle.
    pub centre: (f64, f64),
    /// Half axes in parts of the panel's size, around and along.
    pub half_axes: (f64, f64),
}

/// Cells across the panels that [`BLOCKS`] counts in, around and along.
pub(super) const PANEL_CELLS: (usize, usize) = (5, 6);

/// A hole's half axis over the half width of its block of cells: the rim runs a little inside the
/// block's edges, as far as its corners lie outside.
const ROUNDING: f64 = 0.96;

/// Holes by panel (sector, band) and block of cells: left, bottom, wide, high. They keep one cell
/// from the ribs and from each other; seven of the 21 panels have none.
const BLOCKS: [(usize, usize, [usize; 4]); 19] = [
    (0, 0, [1, 1, 3, 4]),
    (1, 0, [1, 1, 1, 1]),
    (1, 0, [3, 4, 1, 1]),
    (2, 0, [1, 2, 3, 3]),
    (4, 0, [1, 1, 2, 2]),
    (6, 0, [2, 1, 2, 3]),
    (1, 1, [1, 1, 3, 4]),
    (2, 1, [1, 1, 3, 2]),
    (3, 1, [1, 1, 1, 1]),
    (3, 1, [3, 3, 1, 2]),
    (5, 1, [1, 1, 3, 4]),
    (6, 1, [1, 2, 3, 3]),
    (0, 2, [1, 3, 2, 2]),
    (2, 2, [1, 1, 3, 3]),
    (3, 2, [1, 1, 3, 4]),
    (4, 2, [1, 1, 1, 1]),
    (4, 2, [3, 3, 1, 1]),
    (4, 2, [1, 4, 1, 1]),
    (6, 2, [1, 1, 3, 4]),
];

/// The holes of the limb in `fixtures/shin`.
pub(super) fn default_holes() -> Vec<ShinHole> {
    let cells = (PANEL_CELLS.0 as f64, PANEL_CELLS.1 as f64);
    let hole = |&(sector, band, block): &(usize, usize, [usize; 4])| {
        let [left, bottom, wide, high] = block.map(|cells| cells as f64);
        ShinHole {
            sector,
            band,
            centre: ((left + 0.5 * wide) / cells.0, (bottom + 0.5 * high) / cells.1),
            half_axes: (0.5 * ROUNDING * wide / cells.0, 0.5 * ROUNDING * high / cells.1),
        }
    };
    BLOCKS.iter().map(hole).collect()
}
