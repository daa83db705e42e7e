//! Places spread over a shell: for gauges on its inner side, and for presses.

use hapdef_mesh::{FeNodeId, PointIndex};
use hapdef_sim::{GaugeParams, GaugeSite, ShellGaugeStrain, ShellMesh, SimError};
use nalgebra::{Point3, Vector3};

use super::ShellLimbParams;
use crate::error::HapdefError;

/// Gauges on the inner side of a shell.
#[derive(Debug)]
pub(super) struct PlacedGauges {
    pub sites: Vec<GaugeSite>,
    pub gauges: Vec<ShellGaugeStrain>,
    pub n_passed_over: usize,
}

/// `params.n_gauges` gauges on the inner side of `shell`, spread, at least half a diagonal away
/// from what is clamped and from rims, measuring along `long_axis`.
pub(super) fn place_gauges(
    shell: &ShellMesh,
    normals: &[Vector3<f64>],
    clamped: &[FeNodeId],
    long_axis: &Vector3<f64>,
    params: &ShellLimbParams,
) -> Result<PlacedGauges, HapdefError> {
    let [length_m, width_m] = params.gauge_size_m;
    let keep_off_m = 0.5 * length_m.hypot(width_m);
    let mut avoid = rim_nodes(shell);
    avoid.extend(clamped.iter().map(|node| node.index()));
    let candidates = clear_of(shell.nodes(), &avoid, keep_off_m);
    let mut placed = PlacedGauges { sites: Vec::new(), gauges: Vec::new(), n_passed_over: 0 };
    spread(shell.nodes(), &candidates, params.n_gauges, |node| {
        let depth_m = 0.5 * shell.thickness_m()[node];
        let site = GaugeSite {
            position: shell.nodes()[node] - normals[node] * depth_m,
            axis: *long_axis,
            length_m,
            width_m,
        };
        let gauge = gauge_at(shell, &site, depth_m, params)?;
        placed.n_passed_over += usize::from(gauge.is_none());
        let is_taken = gauge.is_some();
        placed.gauges.extend(gauge);
        placed.sites.extend(is_taken.then_some(site));
        Ok(is_taken)
    })?;
    if placed.gauges.len() < params.n_gauges {
        return Err(HapdefError::TooFewGaugeSites {
            n_gauges: params.n_gauges,
            n_found: placed.gauges.len(),
            n_candidates: candidates.len(),
            n_passed_over: placed.n_passed_over,
        });
    }
    Ok(placed)
}

/// The gauge at a site on the inner side, read `depth_m` below the middle; nothing where its
/// footprint doesn't lie on the wall, or its axis goes through it.
pub(super) fn gauge_at(
    shell: &ShellMesh,
    site: &GaugeSite,
    depth_m: f64,
    params: &ShellLimbParams,
) -> Result<Option<ShellGaugeStrain>, HapdefError> {
    let (kind, material) = (params.kind, &params.material);
    let gauge_params = GaugeParams::default();
    on_wall(ShellGaugeStrain::new(shell, kind, material, site, -depth_m, &gauge_params))
}

/// Nothing instead of an error that says a gauge doesn't lie on the wall.
pub(crate) fn on_wall<G>(gauge: Result<G, SimError>) -> Result<Option<G>, HapdefError> {
    match gauge {
        Ok(gauge) => Ok(Some(gauge)),
        Err(
            SimError::GaugeOverhang { .. }
            | SimError::GaugeOffWall { .. }
            | SimError::Direction { .. },
        ) => Ok(None),
        Err(error) => Err(error.into()),
    }
}

/// `n` of `candidates` that `accept` takes, each as far as possible from those before it; the first
/// is the one farthest from the mean of all, ties go to the earlier (Gonzalez, Theoretical Computer
/// Science 38, 1985). Fewer if there are fewer.
pub(super) fn spread(
    points: &[Point3<f64>],
    candidates: &[usize],
    n: usize,
    mut accept: impl FnMut(usize) -> Result<bool, HapdefError>,
) -> Result<Vec<usize>, HapdefError> {
    let n_all = candidates.len() as f64;
    let mean: Vector3<f64> = candidates.iter().map(|&c| points[c].coords / n_all).sum();
    let distances = |from: &Point3<f64>| -> Vec<f64> {
        candidates.iter().map(|&c| (points[c] - from).norm()).collect()
    };
    let mut nearest_m = distances(&Point3::from(mean));
    let mut is_open = vec![true; candidates.len()];
    let mut chosen = Vec::new();
    while chosen.len() < n {
        let farther = |a: usize, b: usize| if nearest_m[b] > nearest_m[a] { b } else { a };
        let open = (0..candidates.len()).filter(|&i| is_open[i]);
        let Some(best) = open.reduce(farther) else {
            break;
        };
        is_open[best] = false;
        if !accept(candidates[best])? {
            continue;
        }
        let from_new = distances(&points[candidates[best]]);
        let is_first = chosen.is_empty();
        for (kept, new) in nearest_m.iter_mut().zip(from_new) {
            *kept = if is_first { new } else { kept.min(new) };
        }
        chosen.push(candidates[best]);
    }
    Ok(chosen)
}

/// The points at least `distance_m` from all of `avoid`, ascending.
pub(super) fn clear_of(points: &[Point3<f64>], avoid: &[usize], distance_m: f64) -> Vec<usize> {
    let avoided: Vec<Point3<f64>> = avoid.iter().map(|&i| points[i]).collect();
    let avoided = PointIndex::new(&avoided);
    let is_clear = |&i: &usize| {
        let nearest = avoided.nearest(&points[i]);
        nearest.is_none_or(|(_, d)| d >= distance_m)
    };
    (0..points.len()).filter(is_clear).collect()
}

/// Nodes on edges of one triangle only, ascending.
pub(super) fn rim_nodes(shell: &ShellMesh) -> Vec<usize> {
    let sides = shell.triangles().iter().flat_map(|nodes| {
        [[0, 1], [1, 2], [2, 0]].map(|[i, j]| {
            let (a, b) = (nodes[i].index(), nodes[j].index());
            [a.min(b), a.max(b)]
        })
    });
    let mut sides: Vec<[usize; 2]> = sides.collect();
    sides.sort_unstable();
    let single = sides.chunk_by(|a, b| a == b).filter(|group| group.len() == 1);
    let mut nodes: Vec<usize> = single.flat_map(|group| group[0]).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(n: usize) -> Vec<Point3<f64>> {
        (0..n).map(|i| Point3::new(i as f64, 0.0, 0.0)).collect()
    }

    #[track_caller]
    fn check(refused: &[usize], n: usize, expected: &[usize]) {
        let points = line(9);
        let all: Vec<usize> = (0..9).collect();
        let chosen = spread(&points, &all, n, |i| Ok(!refused.contains(&i))).unwrap();
        assert_eq!(chosen, expected);
    }

    #[test]
    fn ends_first_then_the_middle() {
        check(&[], 3, &[0, 8, 4]);
    }

    #[test]
    fn a_refused_place_gives_way_to_the_next() {
        check(&[0, 4], 3, &[8, 1, 5]);
    }

    #[test]
    fn there_may_be_fewer() {
        check(&[0, 1, 2, 3, 4, 5, 6], 3, &[8, 7]);
    }

    #[test]
    fn points_near_what_is_avoided_are_left_out() {
        assert_eq!(clear_of(&line(5), &[0], 1.5), [2, 3, 4]);
        assert_eq!(clear_of(&line(2), &[], 1.5), [0, 1]);
    }
}
