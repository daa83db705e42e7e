//! Patch tests and invariance of the shell elements.

use hapdef_mesh::FeNodeId;
use hapdef_sim::{IsotropicMaterial, ShellKind, ShellMesh, ShellStrain, SimError, shell_stiffness};
use nalgebra::{DMatrix, DVector, Matrix3, Point3, Rotation3, SMatrix, SVector, Vector3};

use super::benchmark::ids;
use crate::{Case, Measured, Reference, Target, VerifyError};

const E: f64 = 1e6;
const NU: f64 = 0.25;

/// Thin and thicker than an element's size over five.
const THICKNESSES: [f64; 2] = [0.02, 0.001];

/// Displacement gradient (11, 12, 21, 22) and curvature (11, 22, 12).
type Field = ([f64; 4], [f64; 3]);

/// Ids, title and fields.
type Patch = ([&'static str; 2], &'static str, &'static [Field]);

const PATCHES: [Patch; 4] = [
    (
        ids!("patch.membrane"),
        "Patch test, membrane strain",
        &[([1e-3, 0.0, 0.0, 0.0], [0.0; 3]), ([1e-3, 0.5e-3, 0.5e-3, 1e-3], [0.0; 3])],
    ),
    (ids!("patch.shear"), "Patch test, membrane shear", &[([0.0, 1e-3, 0.0, 0.0], [0.0; 3])]),
    (
        ids!("patch.bending"),
        "Patch test, bending",
        &[([0.0; 4], [1e-2, 0.0, 0.0]), ([0.0; 4], [0.0, 1e-2, 0.0])],
    ),
    (ids!("patch.twist"), "Patch test, twist", &[([0.0; 4], [0.0, 0.0, 1e-2])]),
];

/// Rows of the table.
pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (ids, title, fields) in PATCHES {
        let quantity = "largest error of displacement, rotation or strain / largest value";
        let source = "MacNeal and Harder, 1985, figure 1: a constant strain is met on any mesh";
        cases.extend(both(ids, title, quantity, source, move |kind| {
            worst(fields.iter().flat_map(|field| THICKNESSES.map(|t| (field, t))), |(field, t)| {
                patch_error(kind, t, field)
            })
        }));
    }
    cases.extend(both(
        ids!("modes"),
        "Six zero-energy modes of an element",
        "largest |K r| / (|K| |r|)",
        "rigid motions carry no force",
        |kind| worst(THICKNESSES, |t| zero_modes(kind, t)),
    ));
    cases.extend(both(
        ids!("order"),
        "Invariance under the order of nodes",
        "largest |K′ − P K Pᵀ| / |K|",
        "the stiffness does not depend on how nodes are counted",
        |kind| worst(THICKNESSES, |t| node_order(kind, t)),
    ));
    cases.extend(both(
        ids!("rotation"),
        "Invariance under rotation",
        "largest |K′ − R K Rᵀ| / |K|",
        "the stiffness turns with the element",
        |kind| worst(THICKNESSES, |t| rotation(kind, t)),
    ));
    cases
}

fn both(
    ids: [&'static str; 2],
    title: &'static str,
    quantity: &'static str,
    source: &'static str,
    error: impl Fn(ShellKind) -> Result<f64, VerifyError> + Clone + 'static,
) -> Vec<Case> {
    let is_patch = ids[0].contains("patch");
    let kinds = [(ShellKind::Thin, "thin shell"), (ShellKind::Thick, "thick shell")];
    let case = |(id, (kind, element))| {
        let error = error.clone();
        let measured = move |_| {
            let (mesh, n_nodes) = if is_patch {
                ("ten distorted triangles", 8)
            } else {
                ("an element with tilted directors", 3)
            };
            Ok(Measured {
                value: error(kind)?,
                mesh: mesh.to_owned(),
                n_nodes,
                n_equations: if is_patch { 24 } else { 18 },
                h: 1.0,
            })
        };
        Case {
            id,
            title,
            element,
            quantity,
            unit: "1",
            reference: Reference::Zero,
            source,
            target: Target::within(1e-10),
            known_miss: None,
            n_levels: 1,
            run: Box::new(measured),
        }
    };
    ids.into_iter().zip(kinds).map(case).collect()
}

fn worst<T>(
    all: impl IntoIterator<Item = T>,
    error: impl Fn(T) -> Result<f64, VerifyError>,
) -> Result<f64, VerifyError> {
    all.into_iter().try_fold(0.0, |worst: f64, one| {
        let error = error(one)?;
        // max would drop what is not a number
        Ok(if error > worst || error.is_nan() { error } else { worst })
    })
}

/// MacNeal and Harder's patch of 0.24 × 0.12 with four inner nodes, in triangles; the outer nodes
/// come first.
fn patch(thickness: f64) -> Result<ShellMesh, VerifyError> {
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
    let quads = [[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7], [4, 5, 6, 7]];
    let triangles = quads
        .iter()
        .flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]])
        .map(|t| t.map(FeNodeId::from_index));
    let turn = Rotation3::from_euler_angles(0.4, -0.7, 1.9);
    let positions = nodes.iter().map(|p| turn * Point3::new(p[0], p[1], 0.0));
    Ok(ShellMesh::new(positions.collect(), triangles.collect(), vec![thickness; 8])?)
}

/// Displacement and rotation of a constant-strain field in the patch's plane: u = G x,
/// w = −½ xᵀ C x.
fn field(g: &Matrix3<f64>, c: &Matrix3<f64>, p: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let slope = -(c * p);
    let drilling = 0.5 * (g[(1, 0)] - g[(0, 1)]);
    [g * p + Vector3::z() * (-0.5 * p.dot(&(c * p))), Vector3::new(slope.y, -slope.x, drilling)]
}

/// Solves for the inner nodes with the outer ones given; the largest error of the inner nodes and of
/// the strain at the upper face.
fn patch_error(kind: ShellKind, thickness: f64, (g, c): &Field) -> Result<f64, VerifyError> {
    let g = Matrix3::new(g[0], g[1], 0.0, g[2], g[3], 0.0, 0.0, 0.0, 0.0);
    let c = Matrix3::new(c[0], c[2], 0.0, c[2], c[1], 0.0, 0.0, 0.0, 0.0);
    let mesh = patch(thickness)?;
    let turn = Rotation3::from_euler_angles(0.4, -0.7, 1.9);
    let exact = mesh.nodes().iter().flat_map(|p| {
        let [u, r] = field(&g, &c, &(turn.inverse() * p.coords)).map(|v| turn * v);
        [u.x, u.y, u.z, r.x, r.y, r.z]
    });
    let exact = DVector::from_iterator(48, exact);
    let material = IsotropicMaterial::new(E, NU, 1.0)?;
    let mut k = DMatrix::zeros(48, 48);
    for (element, nodes) in mesh.triangles().iter().enumerate() {
        let ke = shell_stiffness(kind, &mesh.corners(element), None, &[thickness; 3], &material);
        let ke = ke.map_err(|problem| SimError::ShellElement { element, problem })?;
        let dof = |i: usize| 6 * nodes[i / 6].index() + i % 6;
        for (i, row) in ke.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                k[(dof(i), dof(j))] += value;
            }
        }
    }
    let inner = k.view((24, 24), (24, 24)).into_owned();
    let rhs = -(k.view((24, 0), (24, 24)) * exact.rows(0, 24));
    let factor = inner.clone().cholesky().ok_or_else(|| VerifyError::Setup {
        what: "the patch's stiffness",
        expected: "positive definite".to_owned(),
        found: "a pivot that is not positive".to_owned(),
    })?;
    let first = factor.solve(&rhs);
    // one refinement step: the thin patch has a condition of 1e7
    let found = &first + factor.solve(&(rhs - inner * &first));
    let expected = exact.rows(24, 24).into_owned();
    let apart = (&found - &expected).amax() / expected.amax();
    let all: Vec<f64> = exact.rows(0, 24).iter().chain(found.iter()).copied().collect();
    let strain = turn.matrix()
        * ((g + g.transpose()) * 0.5 + c * (0.5 * thickness))
        * turn.matrix().transpose();
    let of_strain = strain_error(kind, &mesh, &material, &all, &strain)?;
    Ok(apart.max(of_strain))
}

fn strain_error(
    kind: ShellKind,
    mesh: &ShellMesh,
    material: &IsotropicMaterial,
    all: &[f64],
    strain: &Matrix3<f64>,
) -> Result<f64, VerifyError> {
    worst(mesh.triangles().iter().enumerate(), |(element, nodes)| {
        let values: [f64; 18] = std::array::from_fn(|i| all[6 * nodes[i / 6].index() + i % 6]);
        let thickness = mesh.corner_thickness_m(element);
        let (corners, at) = (mesh.corners(element), [0.2, 0.3, 0.5]);
        let found = ShellStrain::new(kind, &corners, None, &thickness, material, &at);
        let found = found.map_err(|problem| SimError::ShellElement { element, problem })?;
        let found = found.tensor(&values, 0.5 * thickness[0]);
        Ok((found - strain).amax() / strain.amax())
    })
}

const CORNERS: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [0.11, 0.01, 0.02], [0.03, 0.09, -0.01]];
const TILTS: [[f64; 3]; 3] = [[0.1, -0.05, 1.0], [-0.02, 0.08, 1.0], [0.05, 0.12, 1.0]];

type Stiffness = SMatrix<f64, 18, 18>;

/// The test element's stiffness with its corners in `order`, turned by `turn`.
fn element(
    kind: ShellKind,
    thickness: f64,
    order: [usize; 3],
    turn: &Rotation3<f64>,
) -> Result<Stiffness, VerifyError> {
    let corners = order.map(|i| turn * Point3::from(CORNERS[i]));
    let directors = order.map(|i| {
        let tilt = Vector3::from(TILTS[i]);
        turn * (tilt / tilt.norm())
    });
    let thickness = order.map(|i| thickness * (1.0 + 0.1 * i as f64));
    let material = IsotropicMaterial::new(E, NU, 1.0)?;
    let k = shell_stiffness(kind, &corners, Some(&directors), &thickness, &material);
    let k = k.map_err(|problem| SimError::ShellElement { element: 0, problem })?;
    Ok(Stiffness::from_fn(|i, j| k[i][j]))
}

fn zero_modes(kind: ShellKind, thickness: f64) -> Result<f64, VerifyError> {
    let k = element(kind, thickness, [0, 1, 2], &Rotation3::identity())?;
    worst(0..6, |mode| {
        let axis = Vector3::ith(mode % 3, 1.0);
        let r = SVector::<f64, 18>::from_fn(|i, _| {
            let p = Vector3::from(CORNERS[i / 6]);
            match (mode < 3, i % 6) {
                (true, c @ 0..3) => axis[c],
                (true, _) => 0.0,
                (false, c @ 0..3) => axis.cross(&p)[c],
                (false, c) => axis[c - 3],
            }
        });
        Ok((k * r).amax() / (k.amax() * r.amax()))
    })
}

fn node_order(kind: ShellKind, thickness: f64) -> Result<f64, VerifyError> {
    let still = Rotation3::identity();
    let k = element(kind, thickness, [0, 1, 2], &still)?;
    worst([[1, 2, 0], [2, 0, 1]], |order: [usize; 3]| {
        let other = element(kind, thickness, order, &still)?;
        let old = |i: usize| 6 * order[i / 6] + i % 6;
        let moved = Stiffness::from_fn(|i, j| k[(old(i), old(j))]);
        Ok((other - moved).amax() / k.amax())
    })
}

fn rotation(kind: ShellKind, thickness: f64) -> Result<f64, VerifyError> {
    let turn = Rotation3::from_euler_angles(0.4, -1.1, 2.3);
    let k = element(kind, thickness, [0, 1, 2], &Rotation3::identity())?;
    let turned = element(kind, thickness, [0, 1, 2], &turn)?;
    let spin = Stiffness::from_fn(|i, j| if i / 3 == j / 3 { turn[(i % 3, j % 3)] } else { 0.0 });
    Ok((turned - spin * k * spin.transpose()).amax() / k.amax())
}
