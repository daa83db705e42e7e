//! The skin of the closed and opened shape, with its wall.

use std::time::Instant;

use super::fidelity::Fidelity;
use super::field::{Shape, opened};
use super::input::Input;
use super::level_set::zero_surface;
use super::params::Sizes;
use super::{WrapFault, WrapInfo, WrapParams, WrapSeconds, Wrapped, thin};
use crate::surface::clean::part;
use crate::surface::topology::bodies;
use crate::surface::triangles::corner_angles_rad;
use crate::{MeshError, RemeshParams, SurfaceMesh, remesh, self_intersections};

/// Edge lengths that are tried, each [`SHORTER`] times the one before.
const N_EDGES: usize = 5;

const SHORTER: f64 = 0.75;

/// The skin that the closing by `close_m` gives, if it is faithful.
pub(super) fn of_closing(
    input: &Input,
    params: &WrapParams,
    sizes: &Sizes,
    close_m: f64,
) -> Result<Wrapped, MeshError> {
    let start = Instant::now();
    let shape = opened(input, sizes, close_m)?;
    let grid_s = start.elapsed().as_secs_f64();
    let Walled { skin, wall_m, edge_m } = walled(&shape, sizes)?;
    let until_skin_s = start.elapsed().as_secs_f64();
    let fidelity = Fidelity::of(&skin, input, &shape, sizes, close_m)?;
    fidelity.check(params, sizes, close_m)?;
    let check_s = start.elapsed().as_secs_f64() - until_skin_s;
    let info = WrapInfo {
        n_caps: input.n_caps,
        grid_m: sizes.grid_m,
        close_m,
        round_over_m: sizes.round_over_m,
        edge_m,
        share_inside: fidelity.share_inside,
        share_lost: fidelity.share_lost,
        share_bridged: fidelity.share_bridged,
        input_to_skin_m: fidelity.input_to_skin_m,
        skin_to_input_m: fidelity.skin_to_input_m,
        smallest_angle_deg: smallest_angle_deg(&skin),
        n_crossings: self_intersections(&skin).len(),
        n_thinned: wall_m.iter().filter(|t| **t < sizes.wall_m).count(),
        places: fidelity.places,
        elapsed: WrapSeconds { grid_s, skin_s: until_skin_s - grid_s, check_s },
    };
    Ok(Wrapped { skin, wall_m, info })
}

struct Walled {
    skin: SurfaceMesh,
    wall_m: Vec<f64>,
    edge_m: f64,
}

/// The skin with the longest edges of those tried that a wall fits into.
fn walled(shape: &Shape, sizes: &Sizes) -> Result<Walled, MeshError> {
    let mut edge_m = sizes.edge_m;
    let mut tries = 1;
    loop {
        let refused = match with_edges(shape, sizes, edge_m) {
            Ok((skin, wall_m)) => return Ok(Walled { skin, wall_m, edge_m }),
            Err(cause) => cause,
        };
        if tries == N_EDGES {
            let (edges_m, cause) = ([sizes.edge_m, edge_m], refused.to_string());
            return Err(WrapFault::NoWall { edges_m, wall_m: sizes.wall_m, cause }.into());
        }
        tries += 1;
        edge_m *= SHORTER;
    }
}

fn with_edges(
    shape: &Shape,
    sizes: &Sizes,
    edge_m: f64,
) -> Result<(SurfaceMesh, Vec<f64>), MeshError> {
    let rough = largest_body(&zero_surface(&shape.grid, &shape.values, 0.5 * edge_m)?)?;
    // Everything is round, so there is no feature to keep, and a chord may cut as much as an edge
    // length across a radius of r makes it.
    let params = RemeshParams {
        feature_angle_rad: std::f64::consts::PI,
        max_distance_m: (0.25 * edge_m).max(0.5 * sizes.round_over_m),
        max_volume_change: 0.03,
        ..RemeshParams::new(edge_m)
    };
    let (skin, _) = remesh(&rough, &params)?;
    let wall_m = thin::fitting_wall(&skin, sizes.wall_m)?;
    Ok((skin, wall_m))
}

/// The body with the most triangles: crumbs of the opening aside.
fn largest_body(mesh: &SurfaceMesh) -> Result<SurfaceMesh, MeshError> {
    match bodies(mesh.triangles()).into_iter().max_by_key(Vec::len) {
        Some(body) => part(mesh, &body),
        None => Ok(mesh.clone()),
    }
}

fn smallest_angle_deg(mesh: &SurfaceMesh) -> f64 {
    let of = |t| corner_angles_rad(&mesh.corners(t)).into_iter().fold(f64::INFINITY, f64::min);
    (0..mesh.triangles().len()).map(of).fold(f64::INFINITY, f64::min).to_degrees()
}
