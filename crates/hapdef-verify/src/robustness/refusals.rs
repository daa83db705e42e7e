//! Problems without a solution, which must be refused with their cause; and their neighbours that
//! have one.

use hapdef_bench::robustness::{Expected, Measured};
use hapdef_mesh::{FeNodeId, Tet10Mesh};
use hapdef_sim::{ElasticModel, ElasticParams, NodalLoad, ShellMesh, ShellParams, SolverChoice};
use nalgebra::{Point3, Vector3};

use super::field::material;
use super::solid::grid;
use super::solids::{paths, pushed};
use super::table::{RobustnessTrials, add as add_row, measured};
use crate::VerifyError;

type Make = fn(SolverChoice) -> Result<Measured, VerifyError>;

/// Case, what is extreme, the expected error, words of its text, and the problem.
type Refused = (&'static str, &'static str, &'static str, &'static str, Make);

const FREE: &str = "FreeRigidModes";

const HELD_BADLY: [Refused; 6] = [
    ("no supports", "none", FREE, "has 6 free motions", |solver| {
        clamped(&cube()?, |_| false, solver)
    }),
    ("one clamped node", "1", FREE, "has 3 free motions", |solver| {
        clamped(&cube()?, |p| *p == Point3::origin(), solver)
    }),
    ("two clamped nodes", "2", FREE, "rotation about (1.000", |solver| {
        let ends = |p: &Point3<f64>| p.y == 0.0 && p.z == 0.0 && (p.x == 0.0 || p.x == 1.0);
        clamped(&cube()?, ends, solver)
    }),
    ("a fully clamped model", "all", "AllClamped", "125", |solver| {
        clamped(&cube()?, |_| true, solver)
    }),
    ("a disconnected piece", "one of two held", FREE, "1 of 2", |solver| {
        clamped(&two_pieces(2.0)?, |p| p.x == 0.0, solver)
    }),
    ("parts that touch with double nodes", "not joined", FREE, "1 of 2", |solver| {
        clamped(&two_pieces(1.0)?, |p| p.x == 0.0, solver)
    }),
];

const BAD_INPUT: [Refused; 5] = [
    ("a load that is no number", "NaN", "LoadNotFinite", "NaN", |solver| loaded(f64::NAN, solver)),
    ("a load that is no number", "∞", "LoadNotFinite", "inf", |solver| {
        loaded(f64::INFINITY, solver)
    }),
    ("an element without volume", "corner in its face", "CornerVolume", "element 0", |solver| {
        clamped(&thin(0.0)?, |p| p.x == 0.0, solver)
    }),
    (
        "an element turned inside out",
        "corner through its face",
        "CornerVolume",
        "element 0",
        |solver| clamped(&thin(-0.1)?, |p| p.x == 0.0, solver),
    ),
    (
        "an element folded by a mid-side node",
        "det J < 0",
        "ElementInverted",
        "element 0",
        |solver| clamped(&folded()?, |p| p.x == 0.0, solver),
    ),
];

/// Rows of refusals.
pub(super) fn add(rows: &mut RobustnessTrials) {
    for (case, extreme, kind, words, run) in HELD_BADLY.into_iter().chain(BAD_INPUT) {
        for (path, solver) in paths() {
            let expected = Expected::Refusal { kind, words };
            add_row(rows, (case, extreme), path, expected, move || run(solver));
        }
    }
    let shells: [(_, _, _, _, fn() -> _); 3] = [
        ("no supports", "none", FREE, "has 6 free motions", || square([1.0, 1.0], &[])),
        ("a fully clamped model", "all", "AllClamped", "", || square([1.0, 1.0], &[0, 1, 2, 3])),
        ("an element without area", "corner on its side", "Flat", "shell element 1", || {
            square([0.5, 0.5], &[0])
        }),
    ];
    for (case, extreme, kind, words, run) in shells {
        add_row(rows, (case, extreme), "shell", Expected::Refusal { kind, words }, run);
    }
}

fn cube() -> Result<Tet10Mesh, VerifyError> {
    grid([2; 3], |p| p)
}

/// What `mesh` does under a force at its far end, held where `take`; not compared with anything,
/// as it should not be solved.
fn clamped(
    mesh: &Tet10Mesh,
    take: impl Fn(&Point3<f64>) -> bool,
    solver: SolverChoice,
) -> Result<Measured, VerifyError> {
    pulled(mesh, take, Vector3::new(1.0, 2.0, 3.0), solver)
}

fn loaded(force: f64, solver: SolverChoice) -> Result<Measured, VerifyError> {
    pulled(&cube()?, |p| p.x == 0.0, Vector3::new(0.0, force, 0.0), solver)
}

fn pulled(
    mesh: &Tet10Mesh,
    take: impl Fn(&Point3<f64>) -> bool,
    force: Vector3<f64>,
    solver: SolverChoice,
) -> Result<Measured, VerifyError> {
    let params = ElasticParams::new(material(2e9, 0.3)?, mesh.nodes_where(take));
    let model = ElasticModel::build(mesh, &ElasticParams { solver, ..params })?;
    let last = FeNodeId::from_index(mesh.nodes().len() - 1);
    let (_, info) = model.solve(&NodalLoad::nodal(last, force))?;
    // nothing is known of the solution, so that it counts as wrong
    Ok(measured(&model, &info, f64::NAN))
}

/// Two cubes, the second from x = `from`, without a common node.
fn two_pieces(from: f64) -> Result<Tet10Mesh, VerifyError> {
    let cube = cube()?;
    let n = cube.nodes().len();
    let second = cube.nodes().iter().map(|p| p + Vector3::x() * from);
    let nodes = cube.nodes().iter().copied().chain(second).collect();
    let shifted = cube
        .elements()
        .iter()
        .map(|element| element.map(|node| FeNodeId::from_index(node.index() + n)));
    let elements = cube.elements().iter().copied().chain(shifted).collect();
    Ok(Tet10Mesh::new(nodes, elements)?)
}

/// A grid with an inner node pushed to or through the opposite face of an element.
fn thin(height: f64) -> Result<Tet10Mesh, VerifyError> {
    pushed(&grid([3; 3], |p| p)?, height)
}

/// A cube with a mid-side node moved to a corner and beyond.
fn folded() -> Result<Tet10Mesh, VerifyError> {
    let cube = cube()?;
    let element = cube.elements()[0];
    let mut nodes = cube.nodes().to_vec();
    let [a, b] = [element[0], element[1]].map(|n| cube.position(n));
    nodes[element[4].index()] = a + (b - a) * 1.2;
    Ok(Tet10Mesh::new(nodes, cube.elements().to_vec())?)
}

/// Two triangles, the last corner at `at`, held at `clamped`.
fn square(at: [f64; 2], clamped: &[usize]) -> Result<Measured, VerifyError> {
    let nodes = vec![
        Point3::origin(),
        Point3::new(1.0, 0.0, 0.0),
        Point3::new(0.0, 1.0, 0.0),
        Point3::new(at[0], at[1], 0.0),
    ];
    let triangles = [[0, 1, 2], [1, 3, 2]].map(|t| t.map(FeNodeId::from_index));
    let mesh = ShellMesh::new(nodes, triangles.to_vec(), vec![0.01; 4])?;
    let ids = clamped.iter().map(|&n| FeNodeId::from_index(n)).collect();
    let model = ElasticModel::build_shell(&mesh, &ShellParams::new(material(2e9, 0.3)?, ids))?;
    let force = NodalLoad::nodal(FeNodeId::from_index(3), Vector3::z());
    let (_, info) = model.solve(&force)?;
    Ok(measured(&model, &info, f64::NAN))
}
