//! Solids whose shape, stiffness, size or load is extreme.

use hapdef_bench::robustness::Expected;
use hapdef_mesh::{FeNodeId, Tet10Mesh};
use hapdef_sim::{IterativeParams, MultigridParams, SolverChoice};
use nalgebra::{Point3, Vector3};

use super::field::{bend, material, stretch};
use super::solid::{Block, grid, wobble};
use super::table::{RobustnessTrials, add as add_row};
use crate::VerifyError;
use crate::meshes::{moved, straight};

const E_PA: f64 = 2e9;
const NU: f64 = 0.3;

/// Both solvers, with the words of the table.
pub(super) fn paths() -> [(&'static str, SolverChoice); 2] {
    // several levels even on a small mesh
    let multigrid = MultigridParams { dense_below: 200, ..MultigridParams::default() };
    let iterative = IterativeParams { multigrid, ..IterativeParams::default() };
    [("direct", SolverChoice::Direct), ("iterative", SolverChoice::Iterative(iterative))]
}

/// Rows of `make` on both solvers.
pub(super) fn both(
    rows: &mut RobustnessTrials,
    (case, extreme): (&'static str, impl Into<String>),
    expected: Expected,
    make: impl Fn() -> Result<Block, VerifyError> + Clone + 'static,
) {
    let extreme = extreme.into();
    for (path, solver) in paths() {
        let make = make.clone();
        add_row(rows, (case, extreme.clone()), path, expected, move || {
            let mut block = make()?;
            block.params.solver = solver;
            block.measure()
        });
    }
}

/// Values of what is extreme, their words, where a result must come, and the cases that are tried at
/// each value.
type Sweep = (&'static [f64], fn(f64) -> String, fn(f64) -> bool, &'static [(&'static str, Make)]);
type Make = fn(f64) -> Result<Block, VerifyError>;

const SWEEPS: &[Sweep] = &[
    (
        &[1e-2, 1e-3, 1e-4, 1e-5, 1e-6],
        |t| format!("t/L {t:e}"),
        |t| t >= 1e-2,
        &[
            ("thin plate in bending, solid", |t| plate(t, true)),
            ("thin plate stretched, solid", |t| plate(t, false)),
        ],
    ),
    (
        &[0.1, 0.01, 1e-3, 1e-4],
        |height| format!("height × {height:e}"),
        |height| height >= 0.01,
        &[("a layer of slivers", layer), ("one sliver in a block", one_sliver)],
    ),
    (
        &[1e3, 1e6, 1e11, 1e13],
        |e| format!("E {e:e} Pa"),
        |_| true,
        &[("a block, soft to stiff", |e| block(e, NU, 1.0, 1.0))],
    ),
    (
        &[0.0, 0.3, 0.49, 0.4999, 0.49999, 0.4999999],
        |nu| format!("ν {nu}"),
        |nu| nu < 0.4999,
        &[("a block, to incompressible", |nu| block(E_PA, nu, 1.0, 1.0))],
    ),
    (&[1e-6, 1e-3, 1e3], wide, |_| true, &[("a block, small to large", sized)]),
    (
        &[1e-12, 1.0, 1e12],
        |force| format!("about {force:e} N"),
        |_| true,
        &[("a block, light to heavy load", |force| block(E_PA, NU, 1.0, force / (1e-3 * E_PA)))],
    ),
    (&[1.0], |_| "ten nodes".to_owned(), |_| true, &[("one element", one_element)]),
];

/// Rows of solids: thin plates and slivers; materials, sizes and loads.
pub(super) fn add(rows: &mut RobustnessTrials) {
    for &(values, words, is_tame, cases) in SWEEPS {
        for &value in values {
            for &(case, make) in cases {
                let expected = result_if(is_tame(value));
                both(rows, (case, words(value)), expected, move || make(value));
            }
        }
    }
}

/// A size of whole µm, mm, m or km.
pub(super) fn wide(size: f64) -> String {
    match size {
        size if size < 1e-4 => format!("{:.0} µm wide", size * 1e6),
        size if size < 1.0 => format!("{:.0} mm wide", size * 1e3),
        size => format!("{:.0} km wide", size / 1e3),
    }
}

/// A result where the problem is tame, else a result or an error.
pub(super) fn result_if(tame: bool) -> Expected {
    if tame { Expected::Result } else { Expected::Either }
}

fn plate(t: f64, bent: bool) -> Result<Block, VerifyError> {
    let material = material(E_PA, NU)?;
    let size = [1.0, 1.0, t];
    let mesh = grid([6, 6, 1], |p| Point3::new(p.x, p.y, t * p.z))?;
    let field = if bent { bend(material, size) } else { stretch(material) };
    Ok(Block::free(mesh, material, size, field))
}

fn sized(size: f64) -> Result<Block, VerifyError> {
    block(E_PA, NU, size, 1.0)
}

/// A distorted block of edge `size` under `load` times the tractions of its field.
pub(super) fn block(e: f64, nu: f64, size: f64, load: f64) -> Result<Block, VerifyError> {
    let material = material(e, nu)?;
    let mesh = grid([3; 3], |p| Point3::from(wobble(p, 0.03).coords * size))?;
    let block = Block::free(mesh, material, [size; 3], stretch(material));
    Ok(Block { load_scale: load, ..block })
}

/// The middle of three layers is `height` times as high as the others.
fn layer(height: f64) -> Result<Block, VerifyError> {
    let material = material(E_PA, NU)?;
    let levels = [0.0, 1.0, 1.0 + height, 2.0 + height];
    let mesh = grid([4, 4, 3], |p| {
        let level = (3.0 * p.z).round() as usize;
        Point3::new(p.x, p.y, 0.5 * levels[level])
    })?;
    Ok(Block::free(mesh, material, [1.0; 3], stretch(material)))
}

/// An inner node is moved until one of its elements has `height` times its height.
fn one_sliver(height: f64) -> Result<Block, VerifyError> {
    let material = material(E_PA, NU)?;
    let mesh = pushed(&grid([3; 3], |p| wobble(p, 0.03))?, height)?;
    Ok(Block::free(mesh, material, [1.0; 3], stretch(material)))
}

/// The mesh of the unit cube with an inner node moved to `height` times its height over the opposite
/// face of one of its elements.
pub(super) fn pushed(mesh: &Tet10Mesh, height: f64) -> Result<Tet10Mesh, VerifyError> {
    let is_inside = |n: FeNodeId| mesh.position(n).iter().all(|&c| c > 0.1 && c < 0.9);
    let corners = mesh.elements().iter().flat_map(|e| (0..4).map(move |k| (e, k)));
    let (element, corner) = corners
        .into_iter()
        .find(|&(e, k)| is_inside(e[k]))
        .ok_or_else(|| VerifyError::not_run("the grid has no inner node"))?;
    let base = (0..4).filter(|&k| k != corner).map(|k| mesh.position(element[k]).coords);
    let foot = base.sum::<Vector3<f64>>() / 3.0;
    moved(mesh, |node, p| match node == element[corner] {
        true => Point3::from(foot + (p.coords - foot) * height),
        false => p,
    })
}

fn one_element(_: f64) -> Result<Block, VerifyError> {
    let material = material(E_PA, NU)?;
    let nodes = straight([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let mesh = Tet10Mesh::new(nodes.to_vec(), vec![std::array::from_fn(FeNodeId::from_index)])?;
    Ok(Block::free(mesh, material, [1.0; 3], stretch(material)))
}
