//! Patch tests: constant membrane strain, curvature and twist on a distorted flat patch.

use hapdef_mesh::FeNodeId;
use hapdef_sim::{IsotropicMaterial, ShellKind, ShellMesh, ShellStrain, shell_stiffness};
use nalgebra::{DMatrix, DVector, Matrix3, Point3, Rotation3};

const E_PA: f64 = 1e6;
const NU: f64 = 0.25;

/// MacNeal and Harder's patch of 0.24 × 0.12 with four inner nodes (1985, figure 1), in triangles.
fn patch(thickness_m: f64) -> ShellMesh {
    let nodes = [
        [0.0, 0.0],
        [0.24, 0.0],
        [0.24, 0.12],
        [0.0, 0.12],
        [0.04, 0.02],
        [0.18, 0.03],
        [0.16, 0.08],
        [0.08, 0.08],
    ];
    let quads = [
        [0, 1, 5, 4],
        [1, 2, 6, 5],
        [2, 3, 7, 6],
        [3, 0, 4, 7],
        [4, 5, 6, 7],
    ];
    let triangles = quads
        .iter()
        .flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]])
        .map(|t| t.map(FeNodeId::from_index));
    let positions = nodes.iter().map(|p| Point3::new(p[0], p[1], 0.0));
    ShellMesh::new(
        positions.collect(),
        triangles.collect(),
        vec![thickness_m; 8],
    )
    .expect("valid")
}

/// Displacement and rotation of a constant-strain field: u = G x, w = −½ xᵀ C x.
fn field(g: &Matrix3<f64>, c: &Matrix3<f64>, p: &Point3<f64>) -> [f64; 6] {
    let (u, slope) = (g * p.coords, -(c * p.coords));
    let w = -0.5 * p.coords.dot(&(c * p.coords));
    let drilling = 0.5 * (g[(1, 0)] - g[(0, 1)]);
    [u.x, u.y, u.z + w, slope.y, -slope.x, drilling]
}

/// Solves with the outer nodes given, and returns the largest error of the inner ones and of the
/// strain at z, relative to the largest value.
fn worst_error(kind: ShellKind, thickness_m: f64, g: Matrix3<f64>, c: Matrix3<f64>) -> f64 {
    let mesh = patch(thickness_m);
    let turn = Rotation3::from_euler_angles(0.4, -0.7, 1.9);
    let material = IsotropicMaterial::new(E_PA, NU, 1.0).expect("valid");
    let exact = DVector::from_iterator(48, mesh.nodes().iter().flat_map(|p| field(&g, &c, p)));
    let spin = DMatrix::from_fn(48, 48, |i, j| {
        if i / 3 == j / 3 {
            turn[(i % 3, j % 3)]
        } else {
            0.0
        }
    });
    let exact = spin * exact;
    let mut k = DMatrix::zeros(48, 48);
    let corners = |t: usize| mesh.corners(t).map(|p| turn * p);
    for (t, nodes) in mesh.triangles().iter().enumerate() {
        let ke =
            shell_stiffness(kind, &corners(t), None, &[thickness_m; 3], &material).expect("valid");
        let dof = |i: usize| 6 * nodes[i / 6].index() + i % 6;
        for i in 0..18 {
            for j in 0..18 {
                k[(dof(i), dof(j))] += ke[i][j];
            }
        }
    }
    let inner = k.view((24, 24), (24, 24)).into_owned();
    let rhs = -(k.view((24, 0), (24, 24)) * exact.rows(0, 24));
    let factor = inner.clone().cholesky().expect("positive definite");
    let first = factor.solve(&rhs);
    // one refinement step: the thin patch has a condition of 1e7
    let found = &first + factor.solve(&(rhs - inner * &first));
    let expected = exact.rows(24, 24).into_owned();
    let mut worst = (&found - &expected).amax() / expected.amax();

    let all = DVector::from_iterator(48, exact.rows(0, 24).iter().chain(found.iter()).copied());
    let z = 0.5 * thickness_m;
    let strain = turn.matrix() * ((g + g.transpose()) * 0.5 + c * z) * turn.matrix().transpose();
    for (t, nodes) in mesh.triangles().iter().enumerate() {
        let values: [f64; 18] = std::array::from_fn(|i| all[6 * nodes[i / 6].index() + i % 6]);
        let at = [0.2, 0.3, 0.5];
        let s = ShellStrain::new(kind, &corners(t), None, &[thickness_m; 3], &material, &at)
            .expect("valid");
        worst = worst.max((s.tensor(&values, z) - strain).amax() / strain.amax());
    }
    worst
}

#[track_caller]
fn check(g: [f64; 4], c: [f64; 3]) {
    let g = Matrix3::new(g[0], g[1], 0.0, g[2], g[3], 0.0, 0.0, 0.0, 0.0);
    let c = Matrix3::new(c[0], c[2], 0.0, c[2], c[1], 0.0, 0.0, 0.0, 0.0);
    for kind in [ShellKind::Thin, ShellKind::Thick] {
        for thickness_m in [0.02, 0.001] {
            let worst = worst_error(kind, thickness_m, g, c);
            assert!(worst < 1e-10, "{kind:?}, t {thickness_m}: error {worst:e}");
        }
    }
}

#[test]
fn membrane_strain() {
    check([1e-3, 0.0, 0.0, 0.0], [0.0; 3]);
    check([1e-3, 0.5e-3, 0.5e-3, 1e-3], [0.0; 3]);
}

#[test]
fn membrane_shear() {
    check([0.0, 1e-3, 0.0, 0.0], [0.0; 3]);
}

#[test]
fn bending() {
    check([0.0; 4], [1e-2, 0.0, 0.0]);
    check([0.0; 4], [0.0, 1e-2, 0.0]);
}

#[test]
fn twist() {
    check([0.0; 4], [0.0, 0.0, 1e-2]);
}
