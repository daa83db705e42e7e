//! The motions of nodes in a block of solutions, and the forces on the unknowns that a load is.

use hapdef_mesh::FeNodeId;
use nalgebra::Vector3;

use crate::NodalLoad;
use crate::factor::panel::Columns;
use crate::supports::unknowns::{Link, Unknowns};

/// The motion of all nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motion {
    /// Displacements `[n_fe_nodes]`, m.
    pub displacement: Vec<Vector3<f64>>,
    /// Rotation vectors `[n_fe_nodes]`, rad; empty for solids.
    pub rotation: Vec<Vector3<f64>>,
}

/// The solutions of one block of loads.
pub(crate) struct SolvedBlock<'a> {
    unknowns: &'a Unknowns,
    /// Load numbers, one per column.
    pub(crate) loads: &'a [usize],
    /// `[n_equations, n_columns]`, m and rad.
    x: &'a Columns,
}

impl<'a> SolvedBlock<'a> {
    pub(crate) fn new(unknowns: &'a Unknowns, loads: &'a [usize], x: &'a Columns) -> Self {
        Self { unknowns, loads, x }
    }

    /// The displacement of `node` in `column`, m; zero where clamped.
    pub(crate) fn displacement(&self, column: usize, node: FeNodeId) -> Vector3<f64> {
        self.value(column, self.unknowns.translation(node))
    }

    /// The displacements of `node`, m: a row per direction, a value per column; nothing where they
    /// are no unknowns of their own.
    pub(crate) fn rows(&self, node: FeNodeId) -> Option<[&[f64]; 3]> {
        match self.unknowns.translation(node) {
            &Link::Free(place) => Some([0, 1, 2].map(|c| self.x.row(3 * place as usize + c))),
            _ => None,
        }
    }

    /// All displacements of `column` `[n_fe_nodes]`, m.
    pub(crate) fn field(&self, column: usize) -> Vec<Vector3<f64>> {
        self.nodes().map(|node| self.displacement(column, node)).collect()
    }

    /// The motion of all nodes in `column`.
    pub(crate) fn motion(&self, column: usize) -> Motion {
        let rotation = |node| {
            let link = self.unknowns.rotation(node)?;
            Some(self.value(column, link))
        };
        Motion {
            displacement: self.field(column),
            rotation: self.nodes().filter_map(rotation).collect(),
        }
    }

    fn value(&self, column: usize, link: &Link) -> Vector3<f64> {
        link.motion(|place| [0, 1, 2].map(|c| self.x.row(3 * place + c)[column]).into())
    }

    fn nodes(&self) -> impl Iterator<Item = FeNodeId> + use<> {
        (0..self.unknowns.n_fe_nodes()).map(FeNodeId::from_index)
    }
}

/// What a load is on the unknowns: places and three-vectors, which add.
pub(crate) fn unknown_forces(
    load: &NodalLoad,
    unknowns: &Unknowns,
) -> impl Iterator<Item = (usize, Vector3<f64>)> {
    let forces =
        load.forces_n.iter().flat_map(|(node, force)| unknowns.translation(*node).forces(*force));
    let moments = load
        .moments_nm
        .iter()
        .filter_map(|(node, moment)| Some((unknowns.rotation(*node)?, moment)))
        .flat_map(|(link, moment)| link.forces(*moment));
    forces.chain(moments)
}
