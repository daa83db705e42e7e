//! How far two surfaces are apart.

use nalgebra::Point3;

use crate::SurfaceMesh;
use crate::surface::closest::ClosestPoint;

/// The largest sampled distance between two surfaces, each way, m. The larger of the two is the
/// Hausdorff distance as far as the samples see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceDistance {
    /// From the first surface to the nearest point of the second.
    pub from_first_m: f64,
    /// From the second surface to the nearest point of the first.
    pub from_second_m: f64,
}

impl SurfaceDistance {
    /// The larger of the two, m.
    #[must_use]
    pub fn largest_m(&self) -> f64 {
        self.from_first_m.max(self.from_second_m)
    }
}

/// No triangle gets more samples along an edge than this.
const MAX_PER_EDGE: f64 = 200.0;

/// Samples both surfaces on a grid in every triangle, corners included, at most `spacing_m` apart
/// (but at most 200 along an edge and at least two), and takes the largest distance to the other.
#[must_use]
pub fn surface_distance(
    first: &SurfaceMesh,
    second: &SurfaceMesh,
    spacing_m: f64,
) -> SurfaceDistance {
    SurfaceDistance {
        from_first_m: one_way(first, second, spacing_m),
        from_second_m: one_way(second, first, spacing_m),
    }
}

fn one_way(from: &SurfaceMesh, to: &SurfaceMesh, spacing_m: f64) -> f64 {
    let nearest = ClosestPoint::of_surface(to);
    let mut largest: f64 = 0.0;
    for triangle in 0..from.triangles().len() {
        for sample in samples(&from.corners(triangle), spacing_m) {
            if let Some(found) = nearest.nearest(&sample) {
                largest = largest.max(found.distance_m);
            }
        }
    }
    largest
}

fn samples(&[a, b, c]: &[Point3<f64>; 3], spacing_m: f64) -> Vec<Point3<f64>> {
    let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
    let n = (longest / spacing_m).ceil().clamp(2.0, MAX_PER_EDGE) as usize;
    let at =
        |i: usize, j: usize| a + (b - a) * (i as f64 / n as f64) + (c - a) * (j as f64 / n as f64);
    (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j))).map(|(i, j)| at(i, j)).collect()
}
