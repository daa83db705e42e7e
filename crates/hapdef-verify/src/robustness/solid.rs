//! A block of ten-node tetrahedra under the tractions of a known field.

use std::collections::BTreeMap;

use hapdef_bench::robustness::Measured;
use hapdef_mesh::{FeNodeId, TET10_FACES, Tet10Mesh, tri6};
use hapdef_sim::{ElasticModel, ElasticParams, HeldMotion, Hold, IsotropicMaterial, NodalLoad};
use nalgebra::{Matrix3, Point3, Rotation3, Vector3};

use super::field::Field;
use super::table::measured;
use crate::VerifyError;
use crate::meshes::{Blocks, moved};

/// A mesh in its own axes, its supports and its load; solved turned in space, so that no coordinate
/// is a round number.
pub(crate) struct Block {
    /// The mesh in its own axes.
    pub(crate) mesh: Tet10Mesh,
    /// Everything but the mesh.
    pub(crate) params: ElasticParams,
    /// The exact displacement and stress.
    pub(crate) field: Field,
    /// A factor on the load.
    pub(crate) load_scale: f64,
}

/// How every block is turned.
pub(crate) fn turn() -> Rotation3<f64> {
    Rotation3::from_euler_angles(0.4, -0.7, 1.9)
}

/// Nodes held along an axis that is turned.
pub(super) fn hold(nodes: Vec<FeNodeId>, axis: usize) -> Hold {
    Hold { nodes, motion: HeldMotion::Translation, direction: turn() * Vector3::ith(axis, 1.0) }
}

/// A grid of `n` cells over the unit cube whose corner nodes are moved by `map`; mid-side nodes lie
/// halfway.
pub(crate) fn grid(
    n: [usize; 3],
    map: impl Fn(Point3<f64>) -> Point3<f64>,
) -> Result<Tet10Mesh, VerifyError> {
    let unit = Blocks::default().block(n, |p| p).finish()?;
    moved(&unit, |_, p| map(p))
}

/// Moves inner points of the unit cube by up to about `by`.
pub(crate) fn wobble(p: Point3<f64>, by: f64) -> Point3<f64> {
    let inside = p.iter().map(|c| c * (1.0 - c)).product::<f64>() * 64.0;
    let (x, y) = ((17.0 * p.y).sin(), (13.0 * p.z + 1.0).sin());
    p + Vector3::new(x, y, (11.0 * p.x + 2.0).cos()) * (by * inside)
}

impl Block {
    /// A block held at three corners only, so that it can't move as a body and carries no reaction:
    /// the origin, (lx, 0, 0) in y and z, (0, ly, 0) in z.
    pub(crate) fn free(
        mesh: Tet10Mesh,
        material: IsotropicMaterial,
        size: [f64; 3],
        field: Field,
    ) -> Self {
        let at = |x: [f64; 3]| mesh.nodes_where(|p| *p == Point3::from(x));
        let [lx, ly, _] = size;
        let held = [([lx, 0.0, 0.0], 1), ([lx, 0.0, 0.0], 2), ([0.0, ly, 0.0], 2)];
        let mut params = ElasticParams::new(material, at([0.0; 3]));
        params.supports.holds = held.map(|(x, axis)| hold(at(x), axis)).to_vec();
        Self { mesh, params, field, load_scale: 1.0 }
    }

    /// A block clamped at x = 0.
    pub(crate) fn clamped(mesh: Tet10Mesh, material: IsotropicMaterial, field: Field) -> Self {
        let clamped = mesh.nodes_where(|p| p.x == 0.0);
        Self { params: ElasticParams::new(material, clamped), mesh, field, load_scale: 1.0 }
    }

    /// Solves it and compares with the field.
    pub(crate) fn measure(&self) -> Result<Measured, VerifyError> {
        let turn = turn();
        let nodes = self.mesh.nodes().iter().map(|p| turn * p).collect();
        let mesh = Tet10Mesh::new(nodes, self.mesh.elements().to_vec())?;
        let model = ElasticModel::build(&mesh, &self.params)?;
        let (u, info) = model.solve(&self.load())?;
        let exact = |p: &Point3<f64>| turn * ((self.field.u)(p) * self.load_scale);
        Ok(measured(&model, &info, relative_error(self.mesh.nodes(), &u, exact)))
    }

    /// The field's tractions on the boundary, and what stress jumps leave on faces between
    /// elements of different moduli: fᵢ = ∫ Nᵢ σ n dA.
    pub(crate) fn load(&self) -> NodalLoad {
        let scale = self.params.element_stiffness_scale.as_deref();
        let factor = |element: usize| scale.map_or(1.0, |scale| scale[element]);
        let mut load = NodalLoad::default();
        for (nodes, inner, outer) in faces(&self.mesh) {
            let jump = |p: &Point3<f64>| {
                let inside = (self.field.stress)(p, factor(inner));
                let outside = outer.map(|e| (self.field.stress)(p, factor(e)));
                (inside - outside.unwrap_or_else(Matrix3::zeros)) * self.load_scale
            };
            let positions = nodes.map(|node| self.mesh.position(node));
            for q in tri6::QUADRATURE {
                let area = tri6::area_vector(&positions, q.xi, q.eta) * q.weight;
                let force = turn() * (jump(&tri6::position(&positions, q.xi, q.eta)) * area);
                if force != Vector3::zeros() {
                    let shares = nodes.iter().zip(tri6::shape(q.xi, q.eta));
                    let forces = shares.map(|(&node, n)| (node, force * n));
                    load.forces_n.extend(forces);
                }
            }
        }
        load
    }
}

/// The largest error of a displacement over the largest displacement.
pub(crate) fn relative_error(
    nodes: &[Point3<f64>],
    found: &[Vector3<f64>],
    exact: impl Fn(&Point3<f64>) -> Vector3<f64>,
) -> f64 {
    let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
    for (p, found) in nodes.iter().zip(found) {
        let exact = exact(p);
        let error = (found - exact).norm();
        worst = if error.is_nan() { f64::INFINITY } else { worst.max(error) };
        largest = largest.max(exact.norm());
    }
    worst / largest
}

type Face = ([FeNodeId; 6], usize, Option<usize>);

/// Every face once: its nodes seen from outside the first element, that element, and the other.
fn faces(mesh: &Tet10Mesh) -> Vec<Face> {
    let mut faces: BTreeMap<[FeNodeId; 3], Face> = BTreeMap::new();
    for (number, element) in mesh.elements().iter().enumerate() {
        for face in TET10_FACES {
            let nodes = face.map(|local| element[local]);
            let mut key = [nodes[0], nodes[1], nodes[2]];
            key.sort_unstable();
            let known = faces.entry(key).or_insert((nodes, number, None));
            if known.1 != number {
                known.2 = Some(number);
            }
        }
    }
    faces.into_values().collect()
}
