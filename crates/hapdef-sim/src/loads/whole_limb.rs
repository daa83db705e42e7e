//! Loads on a whole limb that are no contacts: what the next joint passes on, weight, motion, temperature.

use hapdef_contact::LimbLoad;
use hapdef_mesh::{FeNodeId, Tet10Mesh};
use nalgebra::{Matrix3, Point3, Vector3};

use crate::{IsotropicMaterial, NodalLoad, SimError};

/// A limb that such loads act on.
#[derive(Clone, Copy, Debug)]
pub struct LoadedLimb<'a> {
    /// Its solid.
    pub mesh: &'a Tet10Mesh,
    /// Its material.
    pub material: IsotropicMaterial,
    /// Thermal expansion, 1/K.
    pub expansion_per_k: f64,
    /// Nodes of the face that the next joint is fixed to; none where there is no next joint.
    pub flange: &'a [FeNodeId],
    /// Where forces on the flange act and moments are taken about, m.
    pub flange_point_m: Point3<f64>,
}

impl LoadedLimb<'_> {
    /// One unit of a load as forces on the limb's nodes.
    ///
    /// Inertia is that of a rigid body that moves with the mount, ρ (g − a − α × r − ω × (ω × r)) per volume
    /// (Goldstein, Classical Mechanics, 3rd ed., section 4.10): the limb's own vibrations are left out.
    ///
    /// # Errors
    /// [`SimError::Flange`] where the flange has too few nodes for a wrench.
    pub fn unit(&self, load: LimbLoad) -> Result<NodalLoad, SimError> {
        let axis = |i: usize| Vector3::ith(i, 1.0);
        let Self { mesh, material, flange, flange_point_m, .. } = self;
        let inertia = |acceleration: &dyn Fn(&Vector3<f64>) -> Vector3<f64>| {
            let density = material.density_kg_m3();
            NodalLoad::body_force(mesh, |x| acceleration(&x.coords) * density)
        };
        let wrench = |force_n, moment_nm| {
            NodalLoad::wrench(mesh, flange, flange_point_m, &force_n, &moment_nm)
        };
        Ok(match load {
            LimbLoad::FlangeForce(i) => wrench(axis(i), Vector3::zeros())?,
            LimbLoad::FlangeMoment(i) => wrench(Vector3::zeros(), axis(i))?,
            LimbLoad::SpecificForce(i) => inertia(&|_| axis(i)),
            LimbLoad::AngularAcceleration(i) => inertia(&|r| -axis(i).cross(r)),
            LimbLoad::AngularRates(i, j) => inertia(&|r| centrifugal(&axis(i), &axis(j), r)),
            LimbLoad::Temperature => {
                NodalLoad::thermal(mesh, material, self.expansion_per_k, |_| 1.0)
            }
        })
    }
}

/// What ωᵢ ωⱼ = 1 adds to −ω × (ω × r); a product of two different rates occurs twice.
fn centrifugal(a: &Vector3<f64>, b: &Vector3<f64>, r: &Vector3<f64>) -> Vector3<f64> {
    let once = -a.cross(&b.cross(r));
    if a == b { once } else { once - b.cross(&a.cross(r)) }
}

impl NodalLoad {
    /// Forces on `nodes` with the resultant `force_n` at `point` and the moment `moment_nm` about it, each as small
    /// as the others allow: fᵢ = F/n + ω × rᵢ with rᵢ from the nodes' centre, as an RBE3 element
    /// spreads a load.
    ///
    /// # Errors
    /// [`SimError::Flange`] for fewer than three nodes, or nodes all on a line;
    /// [`SimError::NodeOutOfRange`].
    pub fn wrench(
        mesh: &Tet10Mesh,
        nodes: &[FeNodeId],
        point: &Point3<f64>,
        force_n: &Vector3<f64>,
        moment_nm: &Vector3<f64>,
    ) -> Result<Self, SimError> {
        for node in nodes {
            super::nodal::check_node("a flange", *node, mesh.nodes().len())?;
        }
        let n = nodes.len() as f64;
        let centre: Vector3<f64> =
            nodes.iter().map(|node| mesh.nodes()[node.index()].coords).sum::<Vector3<f64>>() / n;
        let arms: Vec<Vector3<f64>> =
            nodes.iter().map(|node| mesh.nodes()[node.index()].coords - centre).collect();
        let inertia: Matrix3<f64> = arms
            .iter()
            .map(|r| Matrix3::from_diagonal_element(r.norm_squared()) - r * r.transpose())
            .sum();
        let about_centre = moment_nm + (point.coords - centre).cross(force_n);
        let is_line = || inertia.symmetric_eigenvalues().min() <= 1e-12 * inertia.trace();
        let too_few = SimError::Flange { n_nodes: nodes.len() };
        if nodes.len() < 3 || is_line() {
            return Err(too_few);
        }
        let turn = inertia.try_inverse().ok_or(too_few)? * about_centre;
        let force = |(node, r): (&FeNodeId, &Vector3<f64>)| (*node, force_n / n + turn.cross(r));
        Ok(Self { forces_n: nodes.iter().zip(&arms).map(force).collect(), ..Self::default() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block() -> Tet10Mesh {
        Tet10Mesh::block([0.1, 0.04, 0.03], [2, 2, 2]).expect("a block")
    }

    fn loaded(mesh: &Tet10Mesh, flange: &[FeNodeId], load: LimbLoad) -> NodalLoad {
        let material = IsotropicMaterial::new(2e9, 0.3, 1200.0).expect("valid");
        let flange_point_m = Point3::new(0.13, 0.01, 0.02);
        let limb = LoadedLimb { mesh, material, expansion_per_k: 1e-4, flange, flange_point_m };
        limb.unit(load).expect("a load")
    }

    #[test]
    fn a_wrench_has_its_resultant_and_moment() {
        let mesh = block();
        let flange = mesh.nodes_where(|x| x.x > 0.0999);
        let point = Point3::new(0.13, 0.01, 0.02);
        for i in 0..3 {
            let force = loaded(&mesh, &flange, LimbLoad::FlangeForce(i));
            assert!((force.total_n() - Vector3::ith(i, 1.0)).norm() < 1e-12);
            assert!(force.moment_nm(&mesh, &point).expect("nodes").norm() < 1e-12);
            let moment = loaded(&mesh, &flange, LimbLoad::FlangeMoment(i));
            assert!(moment.total_n().norm() < 1e-9);
            let about = moment.moment_nm(&mesh, &point).expect("nodes");
            assert!((about - Vector3::ith(i, 1.0)).norm() < 1e-9);
        }
    }

    /// Resultants of a rigid block: m (g − a), −m α × c and −m ω × (ω × c), c its centre of mass.
    #[test]
    fn inertia_has_the_resultant_of_a_rigid_body() {
        let mesh = block();
        let mass_kg = 1200.0 * 0.1 * 0.04 * 0.03;
        let centre = Vector3::new(0.05, 0.02, 0.015);
        let total = |load: LimbLoad| loaded(&mesh, &[], load).total_n();
        for i in 0..3 {
            let weight = Vector3::ith(i, mass_kg);
            assert!((total(LimbLoad::SpecificForce(i)) - weight).norm() < 1e-9);
            let turned = -weight.cross(&centre);
            assert!((total(LimbLoad::AngularAcceleration(i)) - turned).norm() < 1e-9);
        }
        let rates = Vector3::new(2.0, -3.0, 0.5);
        let mut sum = Vector3::zeros();
        for load in LimbLoad::all() {
            if let LimbLoad::AngularRates(i, j) = load {
                sum += total(load) * (rates[i] * rates[j]);
            }
        }
        let expected = -rates.cross(&rates.cross(&centre)) * mass_kg;
        assert!((sum - expected).norm() < 1e-9 * expected.norm().max(1.0), "{sum} {expected}");
    }

    #[test]
    fn a_flange_on_a_line_is_refused() {
        let mesh = block();
        let edge = mesh.nodes_where(|x| x.x > 0.0999 && x.y < 1e-6);
        let (zero, point) = (Vector3::zeros(), Point3::origin());
        for nodes in [&edge[..], &edge[..2], &[]] {
            let refused = NodalLoad::wrench(&mesh, nodes, &point, &Vector3::x(), &zero);
            assert!(matches!(refused, Err(SimError::Flange { .. })), "{refused:?}");
        }
    }
}
