//! Patch tests: constant strains, and bending, are met to round-off on any mesh.

use hapdef_mesh::FeNodeId;
use hapdef_sim::{IsotropicMaterial, ShellKind, ShellMesh, ShellStrain, SimError, shell_stiffness};
use nalgebra::{DMatrix, DVector, Matrix3, Point3, Vector3};

use super::invariance::worst;
use super::prelude::*;
use crate::robustness::{Block, bend, grid, material, turn, uniform, wobble};

const IRONS: &str = "Irons and Razzaque, Experience with the patch test, 1972: a complete polynomial \
    of the element's degree is met on any mesh";

/// Rows of solids: a distorted cube under the tractions of the field.
pub(super) fn solids() -> Vec<Case> {
    type Blocks = fn() -> Result<Vec<Block>, VerifyError>;
    let rows: [(_, _, Blocks); 2] = [
        ("patch.linear", "Patch test, six constant strains", || {
            // upper triangular, as the block's holds leave them free
            let places = [[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]];
            let stretched = places.map(|[i, j]| {
                let mut gradient = Matrix3::zeros();
                gradient[(i, j)] = 1e-3;
                let material = material(2e9, 0.3)?;
                Ok(Block::free(distorted()?, material, [1.0; 3], uniform(material, gradient)))
            });
            stretched.into_iter().collect()
        }),
        ("patch.bending", "Patch test, pure bending", || {
            let material = material(2e9, 0.3)?;
            Ok(vec![Block::free(distorted()?, material, [1.0; 3], bend(material, [1.0; 3]))])
        }),
    ];
    let case = |(name, title, blocks): (_, _, Blocks)| Case {
        name,
        title,
        quantity: "largest |u − exact| / largest |exact|",
        source: IRONS,
        target: Target::within(1e-10),
        solve: Solve::by(move |_, _| {
            let mut sizes = (0, 0);
            let value = worst(blocks()?, |block| {
                let measured = block.measure()?;
                let n_equations = measured.solver.as_ref().map_or(0, |solver| solver.n_equations);
                sizes = (block.mesh.nodes().len(), n_equations);
                Ok(measured.value)
            })?;
            let mesh = "distorted 3 × 3 × 3 cells".to_owned();
            Ok(Measured { value, mesh, n_nodes: sizes.0, n_equations: sizes.1, h: 1.0 })
        }),
        ..Case::default()
    };
    rows.map(case).into()
}

/// A unit cube whose inner corners are moved; edges stay straight.
fn distorted() -> Result<hapdef_mesh::Tet10Mesh, VerifyError> {
    grid([3; 3], |p| wobble(p, 0.08))
}

const E: f64 = 1e6;
const NU: f64 = 0.25;

/// Thin and thicker than an element's size over five.
const THICKNESSES: [f64; 2] = [0.02, 0.001];

/// Displacement gradient (11, 12, 21, 22) and curvature (11, 22, 12).
type Field = ([f64; 4], [f64; 3]);

/// Rows of shells.
pub(super) fn shells() -> Vec<Case> {
    let patches: [(_, _, &'static [Field]); 4] = [
        (
            "patch.membrane",
            "Patch test, membrane strain",
            &[([1e-3, 0.0, 0.0, 0.0], [0.0; 3]), ([1e-3, 0.5e-3, 0.5e-3, 1e-3], [0.0; 3])],
        ),
        ("patch.shear", "Patch test, membrane shear", &[([0.0, 1e-3, 0.0, 0.0], [0.0; 3])]),
        (
            "patch.bending",
            "Patch test, bending",
            &[([0.0; 4], [1e-2, 0.0, 0.0]), ([0.0; 4], [0.0, 1e-2, 0.0])],
        ),
        ("patch.twist", "Patch test, twist", &[([0.0; 4], [0.0, 0.0, 1e-2])]),
    ];
    let case = |(name, title, fields): (_, _, &'static [Field])| Case {
        name,
        title,
        quantity: "largest error of displacement, rotation or strain / largest value",
        source: "MacNeal and Harder, 1985, figure 1: a constant strain is met on any mesh",
        target: Target::within(1e-10),
        solve: Solve::by(move |element, _| {
            let trials = fields.iter().flat_map(|field| THICKNESSES.map(|t| (field, t)));
            let kind = element.shell_kind();
            let value = worst(trials, |(field, t)| patch_error(kind, t, field))?;
            let mesh = "ten distorted triangles".to_owned();
            Ok(Measured { value, mesh, n_nodes: 8, n_equations: 24, h: 1.0 })
        }),
        ..Case::default()
    };
    patches.into_iter().flat_map(|patch| case(patch).both()).collect()
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
    let positions = nodes.iter().map(|p| turn() * Point3::new(p[0], p[1], 0.0));
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
    let turn = turn();
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
    let factor = inner.clone().cholesky().ok_or_else(|| {
        VerifyError::setup("the patch's stiffness", "positive definite", "a pivot ≤ 0")
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Verdict;
    use crate::run::run_case;

    #[test]
    fn constant_strains_are_met_on_a_distorted_patch() {
        let patches = shells();
        assert_eq!(patches.len(), 8, "four patches, each thin and thick");
        for case in patches {
            assert_eq!(run_case(&case).verdict, Verdict::Pass, "{}", case.id());
        }
    }
}
