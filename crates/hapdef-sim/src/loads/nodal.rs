//! Loads as forces on FE nodes.

use std::collections::BTreeMap;

use hapdef_mesh::{
    FaceTraction, FeNodeId, SolidDeck, Tet10Mesh, Tri6Face, face_positions, tet10, tri6,
};
use nalgebra::{Point3, Vector3};

use crate::SimError;
use crate::elements::quadrature::tet_rule;

/// Forces on FE nodes: one right-hand side.
///
/// A node may occur more than once; its forces add. Forces on clamped nodes go straight into the
/// support.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NodalLoad {
    /// Nodes and the force on each, N.
    pub forces_n: Vec<(FeNodeId, Vector3<f64>)>,
    /// Nodes and the moment on each, N m; for shells only.
    pub moments_nm: Vec<(FeNodeId, Vector3<f64>)>,
}

impl NodalLoad {
    /// A single force on one node, N.
    #[must_use]
    pub fn nodal(node: FeNodeId, force_n: Vector3<f64>) -> Self {
        Self { forces_n: vec![(node, force_n)], ..Self::default() }
    }

    /// A single moment on one node, N m; for shells only.
    #[must_use]
    pub fn nodal_moment(node: FeNodeId, moment_nm: Vector3<f64>) -> Self {
        Self { moments_nm: vec![(node, moment_nm)], ..Self::default() }
    }

    /// Point forces and tractions of a deck.
    ///
    /// # Errors
    /// As [`Self::traction`].
    pub fn of_deck(deck: &SolidDeck) -> Result<Self, SimError> {
        let forces = Self { forces_n: deck.nodal_forces.clone(), ..Self::default() };
        Ok(forces.plus(&Self::traction(&deck.mesh, &deck.face_tractions)?))
    }

    /// The load equivalent to constant tractions (force per area, in space directions) on curved
    /// faces: fᵢ = ∫ Nᵢ t dA.
    ///
    /// # Errors
    /// [`SimError::NodeOutOfRange`] and [`SimError::LoadNotFinite`] with the traction's number.
    pub fn traction(mesh: &Tet10Mesh, tractions: &[FaceTraction]) -> Result<Self, SimError> {
        let mut forces = BTreeMap::new();
        for (load, traction) in tractions.iter().enumerate() {
            check_finite(load, &traction.traction_pa)?;
            let positions = positions(mesh, &traction.nodes)?;
            add_face(&mut forces, &traction.nodes, &positions, |area| {
                traction.traction_pa * area.norm()
            });
        }
        Ok(Self::from_map(forces))
    }

    /// The load of a uniform pressure on curved faces: fᵢ = −p ∫ Nᵢ n dA, n outward.
    ///
    /// # Errors
    /// [`SimError::LoadNotFinite`], [`SimError::NodeOutOfRange`].
    pub fn pressure(
        mesh: &Tet10Mesh,
        faces: &[Tri6Face],
        pressure_pa: f64,
    ) -> Result<Self, SimError> {
        check_finite(0, &Vector3::repeat(pressure_pa))?;
        let mut forces = BTreeMap::new();
        for face in faces {
            let positions = positions(mesh, &face.nodes)?;
            add_face(&mut forces, &face.nodes, &positions, |area| -area * pressure_pa);
        }
        Ok(Self::from_map(forces))
    }

    /// The load of a force per volume `density_n_m3(x)`: fᵢ = ∫ Nᵢ b dV, with a rule exact to
    /// degree 7.
    #[must_use]
    pub fn body_force(
        mesh: &Tet10Mesh,
        density_n_m3: impl Fn(&Point3<f64>) -> Vector3<f64>,
    ) -> Self {
        let mut forces = BTreeMap::new();
        for (element, ids) in mesh.elements().iter().enumerate() {
            let nodes = mesh.element_positions(element);
            for (r, weight) in tet_rule() {
                let volume = weight * tet10::jacobian(&nodes, r).determinant();
                let force = density_n_m3(&tet10::position(&nodes, r)) * volume;
                for (id, shape) in ids.iter().zip(tet10::shape(r)) {
                    *forces.entry(*id).or_insert_with(Vector3::zeros) += force * shape;
                }
            }
        }
        Self::from_map(forces)
    }

    /// The load `factor` times this one.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let scaled = |entries: &[(FeNodeId, Vector3<f64>)]| {
            let entries = entries.iter();
            entries.map(|(node, f)| (*node, f * factor)).collect()
        };
        Self { forces_n: scaled(&self.forces_n), moments_nm: scaled(&self.moments_nm) }
    }

    /// This load and `other` together.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            forces_n: [self.forces_n.as_slice(), &other.forces_n].concat(),
            moments_nm: [self.moments_nm.as_slice(), &other.moments_nm].concat(),
        }
    }

    /// The sum of all forces, N.
    #[must_use]
    pub fn total_n(&self) -> Vector3<f64> {
        self.forces_n.iter().map(|(_, force)| force).sum()
    }

    /// The sum of all moments about `point`, N m.
    ///
    /// # Errors
    /// [`SimError::NodeOutOfRange`].
    pub fn moment_nm(
        &self,
        mesh: &Tet10Mesh,
        point: &Point3<f64>,
    ) -> Result<Vector3<f64>, SimError> {
        self.check(mesh.nodes().len(), false)?;
        let arm = |node: &FeNodeId| mesh.nodes()[node.index()] - point;
        Ok(self.forces_n.iter().map(|(node, force)| arm(node).cross(force)).sum())
    }

    /// The work Σ f · u of this load on displacements `[n_fe_nodes]`, J (m for a unit load).
    ///
    /// # Errors
    /// [`SimError::NodeOutOfRange`]; [`SimError::NoRotations`] if the load has moments.
    pub fn work_j(&self, displacement: &[Vector3<f64>]) -> Result<f64, SimError> {
        self.check(displacement.len(), false)?;
        Ok(self.forces_n.iter().map(|(node, force)| force.dot(&displacement[node.index()])).sum())
    }

    pub(crate) fn from_map(forces: BTreeMap<FeNodeId, Vector3<f64>>) -> Self {
        Self { forces_n: forces.into_iter().collect(), ..Self::default() }
    }

    pub(crate) fn check(&self, n_nodes: usize, has_rotations: bool) -> Result<(), SimError> {
        if !self.moments_nm.is_empty() && !has_rotations {
            return Err(SimError::NoRotations { what: "a moment" });
        }
        let entries = self.forces_n.iter().chain(&self.moments_nm);
        for (load, (node, force)) in entries.enumerate() {
            check_node("a load", *node, n_nodes)?;
            check_finite(load, force)?;
        }
        Ok(())
    }
}

pub(crate) fn check_node(
    what: &'static str,
    node: FeNodeId,
    n_nodes: usize,
) -> Result<(), SimError> {
    if node.index() < n_nodes {
        Ok(())
    } else {
        Err(SimError::NodeOutOfRange { what, node: node.index(), n_nodes })
    }
}

fn check_finite(load: usize, value: &Vector3<f64>) -> Result<(), SimError> {
    if value.iter().all(|v| v.is_finite()) {
        Ok(())
    } else {
        Err(SimError::LoadNotFinite { load, value: (*value).into() })
    }
}

fn positions(mesh: &Tet10Mesh, nodes: &[FeNodeId; 6]) -> Result<[Point3<f64>; 6], SimError> {
    for &node in nodes {
        check_node("a face", node, mesh.nodes().len())?;
    }
    Ok(face_positions(mesh, &Tri6Face { nodes: *nodes, element: 0 }))
}

fn add_face(
    forces: &mut BTreeMap<FeNodeId, Vector3<f64>>,
    nodes: &[FeNodeId; 6],
    positions: &[Point3<f64>; 6],
    force_of_area: impl Fn(Vector3<f64>) -> Vector3<f64>,
) {
    for q in tri6::QUADRATURE {
        let force = force_of_area(tri6::area_vector(positions, q.xi, q.eta)) * q.weight;
        for (node, shape) in nodes.iter().zip(tri6::shape(q.xi, q.eta)) {
            *forces.entry(*node).or_insert_with(Vector3::zeros) += force * shape;
        }
    }
}
