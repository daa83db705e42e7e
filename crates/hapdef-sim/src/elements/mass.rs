//! Consistent mass.

use hapdef_mesh::{Tet10Mesh, tet10};
use nalgebra::{Point3, Vector3};

use crate::elements::quadrature::tet_rule;

/// Mass and centre of mass of a mesh of one density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassProperties {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Centre of mass, m.
    pub centre_m: Point3<f64>,
}

impl MassProperties {
    /// Mass and centre of mass of `mesh` at `density_kg_m3`, from the consistent mass matrices.
    #[must_use]
    pub fn of(mesh: &Tet10Mesh, density_kg_m3: f64) -> Self {
        let (mut mass_kg, mut first_moment) = (0.0, Vector3::zeros());
        for element in 0..mesh.elements().len() {
            let nodes = mesh.element_positions(element);
            let m = element_mass_kg(&nodes, density_kg_m3);
            for (node, row) in nodes.iter().zip(m) {
                let share: f64 = row.iter().sum();
                mass_kg += share;
                first_moment += node.coords * share;
            }
        }
        Self { mass_kg, centre_m: Point3::from(first_moment / mass_kg) }
    }
}

/// The consistent mass of one element, mᵢⱼ = ∫ ρ Nᵢ Nⱼ dV, kg, the same in all three directions;
/// exact on curved elements.
#[must_use]
pub fn element_mass_kg(nodes: &[Point3<f64>; 10], density_kg_m3: f64) -> [[f64; 10]; 10] {
    let mut m = [[0.0; 10]; 10];
    for (r, weight) in tet_rule() {
        let shape = tet10::shape(r);
        let mass = density_kg_m3 * weight * tet10::jacobian(nodes, r).determinant();
        for i in 0..10 {
            for j in 0..10 {
                m[i][j] += mass * shape[i] * shape[j];
            }
        }
    }
    m
}
