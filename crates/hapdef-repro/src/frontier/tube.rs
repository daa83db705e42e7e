//! A tube of ten-node tetrahedra with gauges on its inner wall: a limb of any size of mesh.

use std::f64::consts::TAU;

use anyhow::Result;
use hapdef_inverse::{Skin, SkinFaces, SkinParams};
use hapdef_mesh::{FeNodeId, Tet10Mesh, Tri6Face, kuhn_tube};
use hapdef_sim::{GaugeParams, GaugeSite, GaugeStrain};
use nalgebra::{Point3, Vector3};

/// Radius of the inner wall, thickness of the wall, and length, m: about a shin's.
const INNER_M: f64 = 0.03;
const WALL_M: f64 = 0.0025;
const LENGTH_M: f64 = 0.15;

/// (1 + √5)/2: turns by it never meet.
const GOLDEN_RATIO: f64 = 1.618_033_988_749_895;

/// A tube, one cell thick, as many cells around as along.
pub(super) struct Tube {
    pub(super) mesh: Tet10Mesh,
    /// Nodes of the lower rim.
    pub(super) clamped: Vec<FeNodeId>,
    /// Nodes of the outer side, rising.
    pub(super) outside: Vec<FeNodeId>,
    faces: Vec<Tri6Face>,
}

impl Tube {
    /// A tube of `n_cells` cells around and along: some 12 `n_cells`² nodes.
    pub(super) fn new(n_cells: usize) -> Result<Self> {
        let mesh = kuhn_tube([n_cells, n_cells, 1], |at| {
            let (turn, radius_m) = (TAU * at.x, INNER_M + WALL_M * at.z);
            Point3::new(radius_m * turn.cos(), radius_m * turn.sin(), LENGTH_M * at.y)
        })?;
        let per_layer = 2 * n_cells * (2 * n_cells + 1);
        let lower_rim = |i: &usize| i % per_layer < 2 * n_cells;
        let ids = |on: Vec<usize>| on.into_iter().map(FeNodeId::from_index).collect();
        Ok(Self {
            clamped: ids((0..3 * per_layer).filter(lower_rim).collect()),
            outside: ids((2 * per_layer..3 * per_layer).collect()),
            faces: mesh.boundary().faces,
            mesh,
        })
    }

    /// `n` gauges of 8 × 5 mm on the inner wall, spread along a spiral, each turned further.
    pub(super) fn gauges(&self, n: usize) -> Result<Vec<GaugeStrain>> {
        let params = GaugeParams::default();
        let gauge = |i: usize| {
            let turn = TAU * GOLDEN_RATIO * i as f64;
            let along = LENGTH_M * (0.1 + 0.6 * (i as f64 + 0.5) / n as f64);
            let out = Vector3::new(turn.cos(), turn.sin(), 0.0);
            let around = Vector3::new(-turn.sin(), turn.cos(), 0.0);
            let tilt = TAU * i as f64 / 6.0;
            let site = GaugeSite {
                position: Point3::from(INNER_M * out + along * Vector3::z()),
                axis: tilt.cos() * Vector3::z() + tilt.sin() * around,
                length_m: 0.008,
                width_m: 0.005,
            };
            Ok(GaugeStrain::with_params(&self.mesh, &self.faces, &site, &params)?)
        };
        (0..n).map(gauge).collect()
    }

    /// The outer side, its nodes in the order of [`Self::outside`].
    pub(super) fn skin(&self) -> Result<Skin> {
        let is_outside = |face: &&Tri6Face| {
            let mut nodes = face.nodes.iter();
            nodes.all(|node| *node >= self.outside[0])
        };
        let place = |node: FeNodeId| self.outside.partition_point(|other| *other < node) as u32;
        let faces: Vec<[u32; 6]> =
            self.faces.iter().filter(is_outside).map(|face| face.nodes.map(place)).collect();
        let points = self.outside.iter().map(|node| self.mesh.position(*node));
        Ok(Skin::new(points.collect(), SkinFaces::Quadratic(&faces), None, &SkinParams::default())?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tube_has_its_volume_its_sides_and_its_gauges() {
        let tube = Tube::new(24).unwrap();
        let volume_m3: f64 = (0..tube.mesh.elements().len())
            .map(|e| hapdef_mesh::tet10::volume(&tube.mesh.element_positions(e)))
            .sum();
        let exact_m3 = TAU / 2.0 * ((INNER_M + WALL_M).powi(2) - INNER_M.powi(2)) * LENGTH_M;
        assert!((volume_m3 / exact_m3 - 1.0).abs() < 1e-3, "{volume_m3}");
        assert_eq!(tube.clamped.len(), 2 * 24 * 3);
        assert_eq!(tube.outside.len(), 2 * 24 * 49);
        assert_eq!(tube.skin().unwrap().n_nodes(), 2 * 24 * 49);
        assert_eq!(tube.gauges(64).unwrap().len(), 64);
    }
}
