//! Stress at nodes by patches of elements.

use hapdef_mesh::{FeNodeId, TET10_EDGES, Tet10Mesh, tet10};
use nalgebra::{Matrix3, Point3, SMatrix, SVector, Vector3};

use crate::elements::stress::stress;
use crate::{IsotropicMaterial, SimError, nodal_stress, strain};

/// Coefficients of a quadratic in three variables, for six stress components.
type Fit = SMatrix<f64, 10, 6>;

/// The stress at every node `[n_fe_nodes]`, Pa, by patch recovery: around each corner a quadratic
/// is fitted by least squares to the stress at the Gauss points of the elements that share it, and
/// read at the corner; a mid-side node takes the mean of its two corners' quadratics
/// (Zienkiewicz and Zhu, Int. J. Numer. Meth. Eng. 33, 1992, parts 1 and 2).
///
/// A patch with too few points, as on the skin, grows by the elements that touch it. More accurate
/// than [`nodal_stress`] where stress is smooth, above all on the skin; worse next to a singular
/// edge. Where a fit is not possible the node keeps its value of [`nodal_stress`].
///
/// # Errors
/// [`SimError::Length`].
pub fn patch_stress(
    mesh: &Tet10Mesh,
    material: &IsotropicMaterial,
    displacement: &[Vector3<f64>],
    initial_strain: impl Fn(&Point3<f64>) -> Matrix3<f64>,
) -> Result<Vec<Matrix3<f64>>, SimError> {
    let plain = nodal_stress(mesh, material, displacement, &initial_strain)?;
    let samples = samples(mesh, material, displacement, initial_strain);
    let around = Around::of(mesh);
    let fits: Vec<Option<Patch>> = (0..mesh.nodes().len())
        .map(|node| around.fit(mesh, &samples, FeNodeId::from_index(node)))
        .collect();
    let mut sum = vec![Matrix3::zeros(); plain.len()];
    let mut n = vec![0.0; plain.len()];
    for ids in mesh.elements() {
        let mut add = |node: FeNodeId, corner: FeNodeId| {
            if let Some(patch) = &fits[corner.index()] {
                sum[node.index()] += patch.at(&mesh.position(node));
                n[node.index()] += 1.0;
            }
        };
        for &corner in &ids[..4] {
            add(corner, corner);
        }
        for (i, ends) in TET10_EDGES.iter().enumerate() {
            for &end in ends {
                add(ids[4 + i], ids[end]);
            }
        }
    }
    let mean = |((s, n), plain): ((&Matrix3<f64>, f64), &Matrix3<f64>)| {
        if n > 0.0 { s / n } else { *plain }
    };
    Ok(sum.iter().zip(n).zip(&plain).map(mean).collect())
}

/// Place and stress of an element's four Gauss points.
type Samples = [(Point3<f64>, SVector<f64, 6>); 4];

fn samples(
    mesh: &Tet10Mesh,
    material: &IsotropicMaterial,
    displacement: &[Vector3<f64>],
    initial_strain: impl Fn(&Point3<f64>) -> Matrix3<f64>,
) -> Vec<Samples> {
    let of_element = |(element, ids): (usize, &[FeNodeId; 10])| {
        let nodes = mesh.element_positions(element);
        let own = ids.map(|id| displacement[id.index()]);
        tet10::QUADRATURE4.map(|(r, _)| {
            let at = tet10::position(&nodes, r);
            let s = stress(material, &(strain(&nodes, &own, r) - initial_strain(&at)));
            let six = [s.m11, s.m22, s.m33, s.m12, s.m13, s.m23];
            (at, SVector::from(six))
        })
    };
    mesh.elements().iter().enumerate().map(of_element).collect()
}

/// The quadratic around one corner.
struct Patch {
    centre: Point3<f64>,
    size_m: f64,
    fit: Fit,
}

impl Patch {
    fn at(&self, p: &Point3<f64>) -> Matrix3<f64> {
        let s = self.fit.transpose() * monomials(&((p - self.centre) / self.size_m));
        Matrix3::new(s[0], s[3], s[4], s[3], s[1], s[5], s[4], s[5], s[2])
    }
}

fn monomials(x: &Vector3<f64>) -> SVector<f64, 10> {
    let (x, y, z) = (x.x, x.y, x.z);
    SVector::from([1.0, x, y, z, x * x, y * y, z * z, x * y, x * z, y * z])
}

/// The elements of each node, one list after another.
struct Around {
    first: Vec<usize>,
    elements: Vec<usize>,
}

/// Elements a patch should have: an inner corner of a regular mesh has 24.
const ENOUGH: usize = 16;

impl Around {
    fn of(mesh: &Tet10Mesh) -> Self {
        let mut first = vec![0; mesh.nodes().len() + 1];
        for ids in mesh.elements() {
            for id in &ids[..4] {
                first[id.index() + 1] += 1;
            }
        }
        for i in 1..first.len() {
            first[i] += first[i - 1];
        }
        let mut next = first.clone();
        let mut elements = vec![0; 4 * mesh.elements().len()];
        for (element, ids) in mesh.elements().iter().enumerate() {
            for id in &ids[..4] {
                elements[next[id.index()]] = element;
                next[id.index()] += 1;
            }
        }
        Self { first, elements }
    }

    fn of_node(&self, node: FeNodeId) -> &[usize] {
        &self.elements[self.first[node.index()]..self.first[node.index() + 1]]
    }

    /// The quadratic around `node`; none for a mid-side node or where the points don't carry one.
    fn fit(&self, mesh: &Tet10Mesh, samples: &[Samples], node: FeNodeId) -> Option<Patch> {
        let mut patch = self.of_node(node).to_vec();
        if patch.is_empty() {
            return None;
        }
        while patch.len() < ENOUGH {
            let corners = patch.iter().flat_map(|&e| &mesh.elements()[e][..4]);
            let mut grown: Vec<usize> = corners.flat_map(|&c| self.of_node(c)).copied().collect();
            grown.sort_unstable();
            grown.dedup();
            if grown.len() == patch.len() {
                break;
            }
            patch = grown;
        }
        let centre = mesh.position(node);
        let points = || patch.iter().flat_map(|&element| &samples[element]);
        let size_m = points().map(|(p, _)| (p - centre).norm()).fold(0.0, f64::max);
        let (mut normal, mut right) = (SMatrix::<f64, 10, 10>::zeros(), Fit::zeros());
        for (p, sigma) in points() {
            let m = monomials(&((p - centre) / size_m));
            normal += m * m.transpose();
            right += m * sigma.transpose();
        }
        let fit = normal.cholesky()?.solve(&right);
        fit.iter().all(|c| c.is_finite()).then_some(Patch { centre, size_m, fit })
    }
}
