//! The input of a wrap: as given, with its openings capped, and samples of its area.

use nalgebra::Point3;

use super::WrapPlaces;
use super::caps::capped;
use super::distance::Distances;
use super::params::Sizes;
use crate::{MeshError, SurfaceMesh};

/// Vertices as near as this are one, m: a few roundings of files in single precision.
const WELD_M: f64 = 1e-6;

/// The spacing of samples, as a multiple of the grid's.
pub(super) const SAMPLE_SPACING: f64 = 1.5;

/// A triangle has at most this many samples along an edge.
const MAX_ALONG_EDGE: f64 = 200.0;

/// The surface as given, and with its openings capped.
pub(super) struct Input {
    pub capped: SurfaceMesh,
    pub n_caps: usize,
    pub to_capped: Distances,
    pub to_given: Distances,
    pub samples: Vec<Sample>,
}

/// A point of a surface and the area that it stands for.
#[derive(Clone, Copy)]
pub(super) struct Sample {
    pub point: Point3<f64>,
    pub area_m2: f64,
}

impl Input {
    pub(super) fn new(soup: &SurfaceMesh, sizes: &Sizes) -> Result<Self, MeshError> {
        let (given, _) = soup.weld(WELD_M)?;
        let (capped, n_caps) = capped(&given)?;
        Ok(Self {
            n_caps,
            to_capped: Distances::to(&capped)?,
            to_given: Distances::to(&given)?,
            samples: samples(&given, SAMPLE_SPACING * sizes.grid_m),
            capped,
        })
    }

    /// The places where there is no skin at all.
    pub(super) fn all_lost(&self) -> WrapPlaces {
        WrapPlaces {
            lost: self.samples.iter().map(|sample| sample.point).collect(),
            lost_m2: total_m2(self.samples.iter()),
            ..WrapPlaces::default()
        }
    }
}

pub(super) fn total_m2<'a>(samples: impl Iterator<Item = &'a Sample>) -> f64 {
    samples.fold(0.0, |sum, sample| sum + sample.area_m2)
}

/// The middles of the n² like parts of each triangle, n so that they are `spacing_m` long at most.
pub(super) fn samples(mesh: &SurfaceMesh, spacing_m: f64) -> Vec<Sample> {
    let mut samples = Vec::new();
    for triangle in 0..mesh.triangles().len() {
        let [a, b, c] = mesh.corners(triangle);
        let longest_m = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        let n = (longest_m / spacing_m).ceil().clamp(1.0, MAX_ALONG_EDGE);
        let area_m2 = mesh.area_normal_m2(triangle).norm() / (n * n);
        let mut add = |u: f64, v: f64| {
            let point = a + (b - a) * (u / n) + (c - a) * (v / n);
            samples.push(Sample { point, area_m2 });
        };
        for i in 0..n as usize {
            for j in 0..n as usize - i {
                let (u, v) = (i as f64, j as f64);
                add(u + 1.0 / 3.0, v + 1.0 / 3.0);
                if i + j + 1 < n as usize {
                    add(u + 2.0 / 3.0, v + 2.0 / 3.0);
                }
            }
        }
    }
    samples
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::triangles::tests::cuboid;

    #[test]
    fn samples_have_the_area_and_the_middle_of_the_surface() {
        let mesh = cuboid(0.03, 0.05, 0.02);
        let samples = samples(&mesh, 0.004);
        assert!((total_m2(samples.iter()) - mesh.area_m2()).abs() < 1e-15);
        let moment = samples
            .iter()
            .fold(nalgebra::Vector3::zeros(), |sum, s| sum + s.point.coords * s.area_m2);
        let middle = mesh.bounding_box().centre().coords;
        assert!((moment / mesh.area_m2() - middle).norm() < 1e-12);
    }
}
