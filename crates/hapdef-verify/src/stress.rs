//! Stress at a node of a shell.

use hapdef_sim::{ShellMesh, ShellStrain, SimError};
use nalgebra::{Matrix3, Point3, Vector3};

use crate::VerifyError;
use crate::meshes::Place;
use crate::problem::Solution;

/// Triangles that meet at a larger angle than 40° meet at a fold.
const FOLD_COS: f64 = 0.766;

impl Solution {
    /// The stress (σ_tt, σ_ss, σ_ts) at a node, `z` from the mid-surface towards the triangles'
    /// normals; t is `along` laid into each triangle, and s = n × t.
    ///
    /// A linear fit, weighted by area, to the stress at the centroids of the triangles within two
    /// rings around the node, not across folds (Zienkiewicz and Zhu, Int. J. Numer. Methods Eng. 33,
    /// 1992, with section forces by [`ShellStrain::resultants`]).
    pub(crate) fn shell_stress(
        &self,
        place: Place,
        z: f64,
        along: impl Fn(&Point3<f64>) -> Vector3<f64>,
    ) -> Result<Vector3<f64>, VerifyError> {
        let (mesh, _) = self.problem.body.shell()?;
        let node = self.problem.body.node(place)?.index();
        let triangles = around(mesh, node);
        let origin = mesh.nodes()[node];
        let axes = frame(mesh, triangles.first().copied().unwrap_or(0), &along);
        let (mut left, mut right) = (Matrix3::zeros(), Matrix3::zeros());
        for &triangle in &triangles {
            let [a, b, c] = mesh.corners(triangle);
            let area = 0.5 * (b - a).cross(&(c - a)).norm();
            let from = centroid(&[a, b, c]) - origin;
            let row = Vector3::new(1.0, from.dot(&axes[0]), from.dot(&axes[1]));
            left += row * row.transpose() * area;
            right += row * self.at_centroid(mesh, triangle, z, &along)?.transpose() * area;
        }
        let scale = left.diagonal().map(|d| d.max(f64::MIN_POSITIVE).sqrt().recip());
        let scaled = Matrix3::from_diagonal(&scale);
        let inverse = (scaled * left * scaled).try_inverse().ok_or_else(|| {
            let what = "the triangles around the node where stress is read";
            let found = format!("{} at {origin}", triangles.len());
            VerifyError::setup(what, "at least three that don't lie on a line", found)
        })?;
        let fit = scaled * inverse * scaled * right;
        Ok(fit.row(0).transpose())
    }

    /// Stress at a triangle's centroid.
    fn at_centroid(
        &self,
        mesh: &ShellMesh,
        triangle: usize,
        z: f64,
        along: impl Fn(&Point3<f64>) -> Vector3<f64>,
    ) -> Result<Vector3<f64>, VerifyError> {
        let (kind, material) = (self.problem.element.shell_kind(), &self.problem.material);
        let thickness = mesh.corner_thickness_m(triangle);
        let directors = Some(&mesh.directors()[triangle]);
        let (corners, at) = (mesh.corners(triangle), [1.0 / 3.0; 3]);
        let strain = ShellStrain::new(kind, &corners, directors, &thickness, material, &at)
            .map_err(|problem| SimError::ShellElement { element: triangle, problem })?;
        let nodes = mesh.triangles()[triangle].map(|node| node.index());
        let values: [f64; 18] = std::array::from_fn(|i| match i % 6 {
            c @ 0..3 => self.motion.displacement[nodes[i / 6]][c],
            c => self.motion.rotation[nodes[i / 6]][c - 3],
        });
        let t = thickness.iter().sum::<f64>() / 3.0;
        let forces = strain.resultants(&values, t, material);
        let [xx, yy, xy]: [f64; 3] = std::array::from_fn(|i| {
            forces.force_n_m[i] / t + 12.0 * z / t.powi(3) * forces.moment_n[i]
        });
        let [x, y] = frame(mesh, triangle, along);
        let [e1, e2, _] = strain.axes();
        let stress = e1 * e1.transpose() * xx
            + e2 * e2.transpose() * yy
            + (e1 * e2.transpose() + e2 * e1.transpose()) * xy;
        let part = |a: &Vector3<f64>, b: &Vector3<f64>| (a.transpose() * stress * b).x;
        Ok(Vector3::new(part(&x, &x), part(&y, &y), part(&x, &y)))
    }
}

/// `along` in the triangle's plane, and normal × that.
fn frame(
    mesh: &ShellMesh,
    triangle: usize,
    along: impl Fn(&Point3<f64>) -> Vector3<f64>,
) -> [Vector3<f64>; 2] {
    let normal = normal(mesh, triangle);
    let along = along(&centroid(&mesh.corners(triangle)));
    let flat = along - normal * normal.dot(&along);
    let t = flat.try_normalize(0.0).unwrap_or(along);
    [t, normal.cross(&t)]
}

fn normal(mesh: &ShellMesh, triangle: usize) -> Vector3<f64> {
    let [a, b, c] = mesh.corners(triangle);
    let area = (b - a).cross(&(c - a));
    area.try_normalize(0.0).unwrap_or(area)
}

/// Triangles within two rings of a node, on the near side of folds.
fn around(mesh: &ShellMesh, node: usize) -> Vec<usize> {
    let triangles = mesh.triangles();
    let touching = |nodes: &[usize]| -> Vec<usize> {
        let touches = |t: &usize| triangles[*t].iter().any(|n| nodes.contains(&n.index()));
        (0..triangles.len()).filter(touches).collect()
    };
    let first = touching(&[node]);
    let near: Vec<usize> = first.iter().flat_map(|&t| triangles[t].map(|n| n.index())).collect();
    let side = first.first().map(|&t| normal(mesh, t)).unwrap_or_default();
    let mut all = touching(&near);
    all.retain(|&t| normal(mesh, t).dot(&side) > FOLD_COS);
    all
}

fn centroid([a, b, c]: &[Point3<f64>; 3]) -> Point3<f64> {
    Point3::from((a.coords + b.coords + c.coords) / 3.0)
}
