//! A tube of ten-node tetrahedra with gauges on its inner wall: a limb of any size of mesh.

use std::f64::consts::TAU;

use anyhow::Result;
use hapdef_inverse::{Skin, SkinFaces, SkinParams};
use hapdef_mesh::{FeNodeId, TET10_EDGES, Tet10Mesh, Tri6Face};
use hapdef_sim::{GaugeParams, GaugeSite, GaugeStrain};
use nalgebra::{Point3, Vector3};

/// Radius of the inner wall, thickness of the wall, and length, m: about a shin's.
const INNER_M: f64 = 0.03;
const WALL_M: f64 = 0.0025;
const LENGTH_M: f64 = 0.15;

/// (1 + √5)/2: turns by it never meet.
const GOLDEN_RATIO: f64 = 1.618_033_988_749_895;

/// The six orders in which a cell's directions can be walked: Kuhn's subdivision.
const WALKS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [1, 2, 0],
    [2, 0, 1],
    [0, 2, 1],
    [2, 1, 0],
    [1, 0, 2],
];

/// A tube, one cell thick, as many cells around as along.
pub(super) struct Tube {
    pub(super) mesh: Tet10Mesh,
    /// Nodes of the lower rim.
    pub(super) clamped: Vec<FeNodeId>,
    /// Nodes of the outer side, rising.
    pub(super) outside: Vec<FeNodeId>,
    faces: Vec<Tri6Face>,
    n_cells: usize,
}

impl Tube {
    /// A tube of `n_cells` cells around and along: some 12 `n_cells`² nodes.
    pub(super) fn new(n_cells: usize) -> Result<Self> {
        let lattice = Lattice { n_cells };
        let nodes = (0..lattice.n_nodes()).map(|i| lattice.position(i));
        let mesh = Tet10Mesh::new(nodes.collect(), lattice.elements())?;
        let of_layer = |i: &usize, axis: usize, at: usize| lattice.place(*i)[axis] == at;
        let ids = |axis: usize, at: usize| {
            let on = (0..lattice.n_nodes()).filter(|i| of_layer(i, axis, at));
            on.map(FeNodeId::from_index).collect::<Vec<_>>()
        };
        let faces = mesh.boundary().faces;
        Ok(Self {
            clamped: ids(1, 0),
            outside: ids(2, 2),
            faces,
            mesh,
            n_cells,
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
            Ok(GaugeStrain::with_params(
                &self.mesh,
                &self.faces,
                &site,
                &params,
            )?)
        };
        (0..n).map(gauge).collect()
    }

    /// The outer side, its nodes in the order of [`Self::outside`].
    pub(super) fn skin(&self) -> Result<Skin> {
        let lattice = Lattice {
            n_cells: self.n_cells,
        };
        let is_outside = |face: &&Tri6Face| {
            let mut nodes = face.nodes.iter();
            nodes.all(|node| lattice.place(node.index())[2] == 2)
        };
        let place = |node: FeNodeId| self.outside.partition_point(|other| *other < node) as u32;
        let faces: Vec<[u32; 6]> = self
            .faces
            .iter()
            .filter(is_outside)
            .map(|face| face.nodes.map(place))
            .collect();
        let points = self.outside.iter().map(|node| self.mesh.position(*node));
        Ok(Skin::new(
            points.collect(),
            SkinFaces::Quadratic(&faces),
            None,
            &SkinParams::default(),
        )?)
    }
}

/// Nodes at the corners and the middles of cells: around (closed), along, outward.
struct Lattice {
    n_cells: usize,
}

impl Lattice {
    fn n_nodes(&self) -> usize {
        2 * self.n_cells * (2 * self.n_cells + 1) * 3
    }

    fn index(&self, [around, along, outward]: [usize; 3]) -> usize {
        let n = 2 * self.n_cells;
        around % n + n * (along + (n + 1) * outward)
    }

    fn place(&self, index: usize) -> [usize; 3] {
        let n = 2 * self.n_cells;
        [index % n, index / n % (n + 1), index / (n * (n + 1))]
    }

    fn position(&self, index: usize) -> Point3<f64> {
        let n = (2 * self.n_cells) as f64;
        let [around, along, outward] = self.place(index).map(|i| i as f64);
        let (turn, radius_m) = (TAU * around / n, INNER_M + WALL_M * outward / 2.0);
        Point3::new(
            radius_m * turn.cos(),
            radius_m * turn.sin(),
            LENGTH_M * along / n,
        )
    }

    fn elements(&self) -> Vec<[FeNodeId; 10]> {
        let mut elements = Vec::with_capacity(6 * self.n_cells.pow(2));
        for cell in 0..self.n_cells.pow(2) {
            let origin = [2 * (cell % self.n_cells), 2 * (cell / self.n_cells), 0];
            elements.extend((0..6).map(|i| self.element(origin, i)));
        }
        elements
    }

    fn element(&self, origin: [usize; 3], walk: usize) -> [FeNodeId; 10] {
        let mut corners = [origin; 4];
        for step in 0..3 {
            corners[step + 1] = corners[step];
            corners[step + 1][WALKS[walk][step]] += 2;
        }
        if walk >= 3 {
            corners.swap(1, 2);
        }
        std::array::from_fn(|i| {
            let at = corners.get(i).copied().unwrap_or_else(|| {
                let [a, b] = TET10_EDGES[i - 4].map(|corner| corners[corner]);
                std::array::from_fn(|d| (a[d] + b[d]) / 2)
            });
            FeNodeId::from_index(self.index(at))
        })
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
