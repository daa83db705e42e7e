//! Stress from displacements, at any point and recovered at nodes.

use hapdef_mesh::{TET10_EDGES, Tet10Mesh, tet10};
use nalgebra::{Matrix3, Point3, Vector3};

use crate::{IsotropicMaterial, SimError, strain};

/// σ = λ tr(ε) I + 2μ ε, Pa, of an elastic strain.
#[must_use]
pub fn stress(material: &IsotropicMaterial, strain: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::identity() * (material.lame_lambda_pa() * strain.trace())
        + strain * (2.0 * material.shear_modulus_pa())
}

/// The stress at every node `[n_fe_nodes]`, Pa, from displacements `[n_fe_nodes]`, m.
///
/// Stress is taken at the four Gauss points, where it is most accurate, extrapolated to the
/// corners by the linear field through them, put on mid-side nodes as the mean of their corners,
/// and averaged over the elements of a node with equal weights: the nodal stress that ANSYS and
/// CalculiX print (CalculiX 2.20 manual, section 6.2.6). One material for the whole mesh: an
/// average across a change of material has no meaning.
///
/// `initial_strain` at a point is the part of the strain that carries no stress, such as α ΔT I;
/// return zeros where there is none.
///
/// # Errors
/// [`SimError::Length`].
pub fn nodal_stress(
    mesh: &Tet10Mesh,
    material: &IsotropicMaterial,
    displacement: &[Vector3<f64>],
    initial_strain: impl Fn(&Point3<f64>) -> Matrix3<f64>,
) -> Result<Vec<Matrix3<f64>>, SimError> {
    let n_nodes = mesh.nodes().len();
    if displacement.len() != n_nodes {
        return Err(SimError::Length {
            what: "the displacement field",
            expected: n_nodes,
            found: displacement.len(),
        });
    }
    let mut sum = vec![Matrix3::zeros(); n_nodes];
    let mut n_elements = vec![0.0; n_nodes];
    for (element, ids) in mesh.elements().iter().enumerate() {
        let nodes = mesh.element_positions(element);
        let own = ids.map(|id| displacement[id.index()]);
        let at_gauss = tet10::QUADRATURE4.map(|(r, _)| {
            let elastic = strain(&nodes, &own, r) - initial_strain(&tet10::position(&nodes, r));
            stress(material, &elastic)
        });
        for (id, sigma) in ids.iter().zip(at_nodes(&at_gauss)) {
            sum[id.index()] += sigma;
            n_elements[id.index()] += 1.0;
        }
    }
    Ok(sum.iter().zip(n_elements).map(|(s, n)| s / n).collect())
}

/// The linear field through the four Gauss points at the ten nodes.
///
/// Gauss point i has the volume coordinates B for corner i and A for the others; the field is
/// σ(L) = Σ sᵢ (Lᵢ − A)/(B − A) with B + 3A = 1.
fn at_nodes(at_gauss: &[Matrix3<f64>; 4]) -> [Matrix3<f64>; 10] {
    let a = tet10::QUADRATURE4[0].0[0];
    let b = 1.0 - 3.0 * a;
    let total: Matrix3<f64> = at_gauss.iter().sum();
    let corner = |i: usize| (at_gauss[i] - total * a) / (b - a);
    std::array::from_fn(|i| match i {
        0..4 => corner(i),
        _ => (corner(TET10_EDGES[i - 4][0]) + corner(TET10_EDGES[i - 4][1])) * 0.5,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use hapdef_mesh::FeNodeId;

    fn one_element() -> Tet10Mesh {
        let corners = [
            Point3::new(0.0, 0.0, 0.0),
            Point3::new(1.0, 0.1, 0.0),
            Point3::new(0.2, 1.3, 0.1),
            Point3::new(0.1, 0.2, 0.9),
        ];
        let nodes = (0..10).map(|i| match i {
            0..4 => corners[i],
            _ => nalgebra::center(&corners[TET10_EDGES[i - 4][0]], &corners[TET10_EDGES[i - 4][1]]),
        });
        Tet10Mesh::new(nodes.collect(), vec![std::array::from_fn(FeNodeId::from_index)])
            .expect("a valid tetrahedron")
    }

    /// A quadratic displacement has linear stress, which the extrapolation meets at every node.
    #[test]
    fn a_linear_stress_is_recovered_at_every_node() {
        let mesh = one_element();
        let material = IsotropicMaterial::new(2e9, 0.3, 1000.0).expect("valid");
        let field = |p: &Point3<f64>| Vector3::new(p.x * p.y, p.z * p.z - p.x, p.y * p.z) * 1e-3;
        let exact = |p: &Point3<f64>| {
            let grad = Matrix3::new(p.y, p.x, 0.0, -1.0, 0.0, 2.0 * p.z, 0.0, p.z, p.y) * 1e-3;
            stress(&material, &((grad + grad.transpose()) * 0.5))
        };
        let u: Vec<_> = mesh.nodes().iter().map(field).collect();
        let found = nodal_stress(&mesh, &material, &u, |_| Matrix3::zeros()).expect("full field");
        for (p, sigma) in mesh.nodes().iter().zip(found) {
            assert!((sigma - exact(p)).amax() < 1e-12 * 2e9, "at {p}: {sigma}");
        }
    }

    /// The same on patches, of a mesh whose elements are too few for a quadratic and of one with
    /// enough.
    #[test]
    fn patches_recover_a_linear_stress_too() {
        let material = IsotropicMaterial::new(2e9, 0.3, 1000.0).expect("valid");
        let field = |p: &Point3<f64>| Vector3::new(p.x * p.y, p.z * p.z - p.x, p.y * p.z) * 1e-3;
        for mesh in [one_element(), one_element().refine().refine()] {
            let u: Vec<_> = mesh.nodes().iter().map(field).collect();
            let none = |_: &Point3<f64>| Matrix3::zeros();
            let plain = nodal_stress(&mesh, &material, &u, none).expect("full field");
            let patch =
                crate::elements::patch_stress(&mesh, &material, &u, none).expect("full field");
            for (a, b) in plain.iter().zip(patch) {
                assert!((a - b).amax() < 1e-9 * 2e9 * 1e-3, "{a} {b}");
            }
        }
    }

    #[test]
    fn free_expansion_has_no_stress() {
        let mesh = one_element();
        let material = IsotropicMaterial::new(2e9, 0.3, 1000.0).expect("valid");
        let u: Vec<_> = mesh.nodes().iter().map(|p| p.coords * 1e-4).collect();
        let found = nodal_stress(&mesh, &material, &u, |_| Matrix3::identity() * 1e-4);
        assert!(found.expect("full field").iter().all(|s| s.amax() < 1e-6));
        assert!(matches!(
            nodal_stress(&mesh, &material, &u[1..], |_| Matrix3::zeros()),
            Err(SimError::Length { .. })
        ));
    }
}
