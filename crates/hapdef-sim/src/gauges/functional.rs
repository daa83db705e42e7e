//! Readings that are linear in the motion of the FE nodes.

use hapdef_mesh::FeNodeId;
use nalgebra::Vector3;

use crate::NodalLoad;

/// A sensor's reading as a linear functional of the motion: reading = Σ aᵢ · uᵢ + bᵢ · θᵢ over FE
/// nodes with displacement uᵢ and, on shells, rotation θᵢ.
///
/// A strain gauge is one; so is a fibre Bragg grating, or each axis of a three-axis sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearFunctional {
    weights: Vec<NodeWeight>,
    unit: &'static str,
}

/// What the motion of one node adds to a reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeWeight {
    /// The node.
    pub node: FeNodeId,
    /// The reading per metre of displacement in each direction.
    pub per_metre: Vector3<f64>,
    /// The reading per radian of rotation about each direction; shells only.
    pub per_radian: Option<Vector3<f64>>,
}

impl LinearFunctional {
    /// The sum of `weights`; `unit` is that of the reading, as "m/m" of a strain.
    #[must_use]
    pub fn new(weights: Vec<NodeWeight>, unit: &'static str) -> Self {
        Self { weights, unit }
    }

    /// The nodes and their weights.
    #[must_use]
    pub fn weights(&self) -> &[NodeWeight] {
        &self.weights
    }

    /// The unit of the reading.
    #[must_use]
    pub fn unit(&self) -> &'static str {
        self.unit
    }

    /// The reading for displacements and, on shells, rotations of all nodes `[n_fe_nodes]`, m and
    /// rad.
    ///
    /// # Panics
    /// If a list is shorter than the mesh, or rotations are weighted and not given.
    #[must_use]
    pub fn reading(&self, displacement: &[Vector3<f64>], rotation: &[Vector3<f64>]) -> f64 {
        let of_node = |weight: &NodeWeight| {
            let i = weight.node.index();
            let moved = weight.per_metre.dot(&displacement[i]);
            weight.per_radian.map_or(moved, |turn| moved + turn.dot(&rotation[i]))
        };
        self.weights.iter().map(of_node).sum()
    }

    /// The right-hand side of the adjoint problem: its solution at a node is the reading per newton
    /// there, in each direction (Betti–Maxwell reciprocity).
    #[must_use]
    pub fn as_load(&self) -> NodalLoad {
        let turned = |weight: &NodeWeight| Some((weight.node, weight.per_radian?));
        NodalLoad {
            forces_n: self.weights.iter().map(|weight| (weight.node, weight.per_metre)).collect(),
            moments_nm: self.weights.iter().filter_map(turned).collect(),
        }
    }
}

impl AsRef<LinearFunctional> for LinearFunctional {
    fn as_ref(&self) -> &LinearFunctional {
        self
    }
}
