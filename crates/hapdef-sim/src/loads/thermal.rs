//! Loads of strains that carry no stress: thermal expansion, swelling, shrink fits.

use std::collections::BTreeMap;

use hapdef_mesh::{Tet10Mesh, tet10};
use nalgebra::{Matrix3, Point3, Vector3};

use crate::elements::stress::stress;
use crate::{IsotropicMaterial, NodalLoad, space_gradients};

impl NodalLoad {
    /// The load of an initial strain `strain(x)`: fᵢ = ∫ σ(ε₀) ∇Nᵢ dV, so that the displacements
    /// solve ∫ (ε − ε₀) : D : δε dV = 0 (Zienkiewicz, Taylor and Zhu, The Finite Element Method,
    /// 6th ed., section 2.2). The stress that is left is σ(ε − ε₀), see
    /// [`nodal_stress`](crate::nodal_stress).
    ///
    /// By the rule of the stiffness, so that a strain the elements can follow leaves no stress.
    #[must_use]
    pub fn initial_strain(
        mesh: &Tet10Mesh,
        material: &IsotropicMaterial,
        strain: impl Fn(&Point3<f64>) -> Matrix3<f64>,
    ) -> Self {
        let mut forces = BTreeMap::new();
        for (element, ids) in mesh.elements().iter().enumerate() {
            let nodes = mesh.element_positions(element);
            for (r, weight) in tet10::QUADRATURE4 {
                let (det_j, gradients) = space_gradients(&nodes, r);
                let sigma = stress(material, &strain(&tet10::position(&nodes, r)));
                for (id, gradient) in ids.iter().zip(gradients) {
                    *forces.entry(*id).or_insert_with(Vector3::zeros) +=
                        sigma * gradient * (weight * det_j);
                }
            }
        }
        Self::from_map(forces)
    }

    /// The load of a temperature rise `rise_k(x)`, K, with the expansion coefficient
    /// `expansion_per_k`, 1/K: [`Self::initial_strain`] of α ΔT I.
    #[must_use]
    pub fn thermal(
        mesh: &Tet10Mesh,
        material: &IsotropicMaterial,
        expansion_per_k: f64,
        rise_k: impl Fn(&Point3<f64>) -> f64,
    ) -> Self {
        Self::initial_strain(mesh, material, |p| {
            Matrix3::identity() * (expansion_per_k * rise_k(p))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ElementMatrix, stiffness};
    use hapdef_mesh::{FeNodeId, TET10_EDGES};

    /// K u of the free expansion is its load.
    #[test]
    fn the_load_is_the_stiffness_times_free_expansion() {
        let corners =
            [[0.0; 3], [1.0, 0.0, 0.1], [0.2, 1.0, 0.0], [0.1, 0.3, 1.0]].map(Point3::from);
        let nodes: [Point3<f64>; 10] = std::array::from_fn(|i| match i {
            0..4 => corners[i],
            _ => nalgebra::center(&corners[TET10_EDGES[i - 4][0]], &corners[TET10_EDGES[i - 4][1]]),
        });
        let ids = std::array::from_fn(FeNodeId::from_index);
        let mesh = Tet10Mesh::new(nodes.to_vec(), vec![ids]).expect("valid");
        let material = IsotropicMaterial::new(2e9, 0.3, 1000.0).expect("valid");
        let load = NodalLoad::thermal(&mesh, &material, 1e-5, |_| 30.0);
        assert!(load.total_n().norm() < 1e-6);
        let k: ElementMatrix = stiffness(&nodes, &material).expect("not inverted");
        for (node, force) in &load.forces_n {
            for direction in 0..3 {
                let row = k[3 * node.index() + direction];
                let ku: f64 = (0..30).map(|j| row[j] * nodes[j / 3][j % 3] * 3e-4).sum();
                assert!((ku - force[direction]).abs() < 1e-9 * 2e9 * 3e-4, "{node:?}");
            }
        }
    }
}
