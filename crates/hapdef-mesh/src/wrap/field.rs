//! Flood, closing and opening on the grid.

use super::WrapFault;
use super::distance::Distances;
use super::grid::{Band, Grid};
use super::input::Input;
use super::level_set::zero_surface;
use super::params::Sizes;
use crate::MeshError;

/// How far from 0 the least values lie, as a part of the grid's spacing: distances that are a level's
/// exactly, as on planes along the grid, then don't make surfaces inside.
const LEAST: f64 = 1e-3;

/// The closed and opened shape.
pub(super) struct Shape {
    pub grid: Grid,
    /// Negative inside the skin, at the grid's points; a distance in metres near it.
    pub values: Vec<f32>,
    /// The edge of the flood, δ outside of the input.
    pub edge: Distances,
}

/// The shape of `input` after the closing by `close_m` and the opening by r.
pub(super) fn opened(input: &Input, sizes: &Sizes, close_m: f64) -> Result<Shape, MeshError> {
    let (h, r) = (sizes.grid_m, sizes.round_over_m);
    let grid = Grid::around(&input.capped.bounding_box(), close_m + 4.0 * h, h)?;
    let width_m = 2.0 * h;
    // Flood: u > δ, connected with the grid's corner.
    let band = Band { level_m: close_m, width_m };
    let u = grid.distances(&input.to_capped, &band, |_| true);
    let is_open = |point: usize| f64::from(u[point]) > close_m;
    let is_outside = grid.flood(is_open);
    let n_hidden = (0..grid.len()).filter(|&p| is_open(p) && !is_outside[p]).count();
    let n_inside = is_outside.iter().filter(|outside| !**outside).count();
    let flooded: Vec<f32> = (0..grid.len())
        .map(|p| {
            let value = f64::from(u[p]) - close_m;
            let inside = if is_open(p) { -width_m } else { value.min(-LEAST * h) };
            (if is_outside[p] { value.max(LEAST * h) } else { inside }) as f32
        })
        .collect();
    let edge = Distances::to(&zero_surface(&grid, &flooded, h)?)?;
    // Closing, then the core: deeper than r below the closed shape, or δ + r below the flood's edge.
    let level_m = close_m + r;
    let depth = grid.distances(&edge, &Band { level_m, width_m }, |p| !is_outside[p]);
    let is_deep = |point: usize| !is_outside[point] && f64::from(depth[point]) > level_m;
    let Some((core, _)) = grid.largest(is_deep) else {
        let share_enclosed = n_hidden as f64 / n_inside.max(1) as f64;
        let places = Box::new(input.all_lost());
        return Err(WrapFault::NoCore { round_over_m: r, close_m, share_enclosed, places }.into());
    };
    let above_core: Vec<f32> = (0..grid.len())
        .map(|p| {
            let value = level_m - f64::from(depth[p]);
            let outside = if is_outside[p] { width_m } else { value.max(LEAST * h) };
            (if core[p] { value.min(-LEAST * h) } else { outside }) as f32
        })
        .collect();
    // Opening: what is nearer than r to the core. The band is as wide as the skin's edges ask for.
    let to_core = Distances::to(&zero_surface(&grid, &above_core, h)?)?;
    let band = Band { level_m: r, width_m: width_m.max(0.5 * sizes.edge_m + h) };
    let mut values = grid.distances(&to_core, &band, |p| !core[p]);
    for (value, in_core) in values.iter_mut().zip(&core) {
        *value = if *in_core { -(r as f32) } else { *value - r as f32 };
    }
    Ok(Shape { grid, values, edge })
}
