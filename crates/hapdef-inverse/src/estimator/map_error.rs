//! The error of the response map as covariances at the scan sites.

use std::f64::consts::TAU;

use crate::noise::ModelError;
use crate::response::ResponseMap;
use crate::sites::ScanSites;
use crate::skin_point::SkinPoint;
use crate::walk::AtWall;

/// Points of the ring that a wider tip is estimated from.
const N_RING: u32 = 12;

/// The map's error per N² at each site for the live gauges `[n_sites, m, m]`; empty if exact.
pub(super) fn site_errors(
    map: &ResponseMap,
    sites: &ScanSites,
    error: &ModelError,
    live: &[usize],
) -> Vec<f64> {
    if error.is_none() {
        return Vec::new();
    }
    let (m, n_gauges) = (live.len(), map.n_gauges());
    let of_live = |all: &[f64]| -> Vec<f64> { live.iter().map(|&gauge| all[gauge]).collect() };
    let normal = |p| of_live(&map.normal(p));
    let values: Vec<Vec<f64>> = sites.points().iter().map(normal).collect();
    let mean_square = |i: usize| {
        let sum: f64 = values.iter().map(|g| g[i] * g[i]).sum();
        (sum / values.len() as f64).max(f64::MIN_POSITIVE)
    };
    let s2: Vec<f64> = (0..m).map(mean_square).collect();
    let mut errors = vec![0.0; sites.len() * m * m];
    for (site, c) in errors.chunks_exact_mut(m * m).enumerate() {
        let point = &sites.points()[site];
        add_relative(c, error.relative, &values[site], &s2);
        if error.friction_rms > 0.0 {
            let vectors = map.vector(point);
            for tangent in map.skin().tangents(point) {
                let along = |&g: &usize| error.friction_rms * vectors[g].dot(&tangent);
                add_square(c, &live.iter().map(along).collect::<Vec<_>>());
            }
        }
        if error.tip_ring_m > 0.0 {
            add_square(c, &of_live(&smeared_less_own(map, point, error.tip_ring_m)));
        }
        if !error.per_site.is_empty() {
            let given = &error.per_site[site * n_gauges * n_gauges..];
            for i in 0..m {
                for j in 0..m {
                    c[i * m + j] += given[live[i] * n_gauges + live[j]];
                }
            }
        }
    }
    errors
}

/// See [`ModelError::relative`]; `g` and `s2` `[m]`.
fn add_relative(c: &mut [f64], relative: f64, g: &[f64], s2: &[f64]) {
    let m = g.len();
    let q = (0..m).map(|i| g[i] * g[i] / s2[i]).sum::<f64>() / m as f64;
    for i in 0..m {
        c[i * m + i] += 0.5 * relative.powi(2) * (g[i] * g[i] + s2[i] * q);
    }
}

/// c ← c + v vᵀ.
fn add_square(c: &mut [f64], v: &[f64]) {
    for (row, vi) in c.chunks_exact_mut(v.len()).zip(v) {
        for (c, vj) in row.iter_mut().zip(v) {
            *c += vi * vj;
        }
    }
}

/// The mean of g on a ring around `point` less g there `[n_gauges]`.
fn smeared_less_own(map: &ResponseMap, point: &SkinPoint, radius_m: f64) -> Vec<f64> {
    let skin = map.skin();
    let [a, b] = skin.tangents(point);
    let mut change: Vec<f64> = map.normal(point).iter().map(|g| -g).collect();
    for k in 0..N_RING {
        let (s, c) = (f64::from(k) / f64::from(N_RING) * TAU).sin_cos();
        let step = (a * c + b * s) * radius_m;
        let on_ring = skin.walk(point, &step, AtWall::Slide).point;
        for (change, g) in change.iter_mut().zip(map.normal(&on_ring)) {
            *change += g / f64::from(N_RING);
        }
    }
    change
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, Vector3};

    use super::*;
    use crate::patch::tip_ring_m;
    use crate::response::ResponseParams;
    use crate::skin::plate;

    /// Cells of a plate, 1 mm each.
    const N: u32 = 24;

    #[test]
    fn a_ring_smears_a_quadratic_response_as_the_wider_tip_does() {
        let skin = plate(N, 1e-3);
        let bowl = |p: &Point3<f64>| Vector3::z() * (-3e4 * p.x * p.x + 1e4 * p.x * p.y - 2.0);
        let nodal: Vec<Vector3<f64>> = skin.nodes().iter().map(bowl).collect();
        let [own_m, wide_m] = [0.002, 0.004];
        let [own, wide] = [own_m, wide_m].map(|tip_radius_m| {
            let params = ResponseParams { tip_radius_m };
            ResponseMap::from_nodal(skin.clone(), 1, &nodal, &params).unwrap()
        });
        let middle = SkinPoint::trusted(2 * (N / 2 * N + N / 2), [1.0, 0.0, 0.0]);
        let change = wide.normal(&middle)[0] - own.normal(&middle)[0];
        let ring_m = tip_ring_m(wide_m, own_m);
        let expected = smeared_less_own(&own, &middle, ring_m)[0];
        // (r² − r₀²)/16 of the Laplacian, 6e4
        assert!((change.abs() - 0.045).abs() < 1e-3, "{change}");
        assert!((expected / change - 1.0).abs() < 1e-2, "{expected} and {change}");
        assert!(tip_ring_m(own_m, wide_m) == 0.0);
    }
}
