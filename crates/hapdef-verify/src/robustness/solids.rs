//! Solids whose shape, stiffness, size or load is extreme.

use hapdef_mesh::{FeNodeId, Tet10Mesh};
use hapdef_report::robustness::Expected;
use hapdef_sim::{IterativeParams, MultigridParams, SolverChoice};
use nalgebra::Point3;

use super::field::{bend, material, stretch};
use super::solid::{Block, grid, moved};
use super::table::{Trial, trial};
use crate::VerifyError;

const E_PA: f64 = 2e9;
const NU: f64 = 0.3;

/// Both solvers, with the words of the table.
pub(super) fn paths() -> [(&'static str, SolverChoice); 2] {
    // several levels even on a small mesh
    let multigrid = MultigridParams { dense_below: 200, ..MultigridParams::default() };
    let iterative = IterativeParams { multigrid, ..IterativeParams::default() };
    [("direct", SolverChoice::Direct), ("iterative", SolverChoice::Iterative(iterative))]
}

/// A trial of `make` on both solvers.
pub(super) fn both(
    case: &'static str,
    extreme: impl Into<String>,
    expected: Expected,
    make: impl Fn() -> Result<Block, VerifyError> + Clone + 'static,
) -> Vec<Trial> {
    let extreme = extreme.into();
    let on = |(path, solver): (_, SolverChoice)| {
        let make = make.clone();
        trial((case, extreme.clone()), path, expected, move || {
            let mut block = make()?;
            block.params.solver = solver;
            block.measure()
        })
    };
    paths().into_iter().map(on).collect()
}

/// Rows of solids.
pub(super) fn trials() -> Vec<Trial> {
    let mut trials = shapes();
    trials.extend(scales());
    trials.extend(both("one element", "ten nodes", Expected::Result, one_element));
    trials
}

/// Thin plates and slivers.
fn shapes() -> Vec<Trial> {
    let mut trials = Vec::new();
    for t in [1e-2, 1e-3, 1e-4, 1e-5, 1e-6] {
        for (case, bent) in
            [("thin plate in bending, solid", true), ("thin plate stretched, solid", false)]
        {
            let extreme = format!("t/L {t:e}");
            trials.extend(both(case, extreme, result_if(t >= 1e-2), move || plate(t, bent)));
        }
    }
    type Make = fn(f64) -> Result<Block, VerifyError>;
    for height in [0.1, 0.01, 1e-3, 1e-4] {
        for (case, make) in
            [("a layer of slivers", layer as Make), ("one sliver in a block", one_sliver)]
        {
            let extreme = format!("height × {height:e}");
            trials.extend(both(case, extreme, result_if(height >= 0.01), move || make(height)));
        }
    }
    trials
}

/// Materials, sizes and loads.
fn scales() -> Vec<Trial> {
    let mut trials = Vec::new();
    for e in [1e3, 1e6, 1e11, 1e13] {
        let make = move || block(e, NU, 1.0, 1.0);
        let extreme = format!("E {e:e} Pa");
        trials.extend(both("a block, soft to stiff", extreme, Expected::Result, make));
    }
    for nu in [0.0, 0.3, 0.49, 0.4999, 0.49999, 0.4999999] {
        let make = move || block(E_PA, nu, 1.0, 1.0);
        let expected = result_if(nu < 0.4999);
        trials.extend(both("a block, to incompressible", format!("ν {nu}"), expected, make));
    }
    for (extreme, size) in [("1 µm wide", 1e-6), ("1 mm wide", 1e-3), ("1 km wide", 1e3)] {
        let make = move || block(E_PA, NU, size, 1.0);
        trials.extend(both("a block, small to large", extreme, Expected::Result, make));
    }
    for force in [1e-12, 1.0, 1e12] {
        let make = move || block(E_PA, NU, 1.0, force / (1e-3 * E_PA));
        let extreme = format!("about {force:e} N");
        trials.extend(both("a block, light to heavy load", extreme, Expected::Result, make));
    }
    trials
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

/// Inner nodes wander by a tenth of a cell.
fn wobble(p: Point3<f64>) -> Point3<f64> {
    let inside = p.iter().map(|c| c * (1.0 - c)).product::<f64>() * 64.0;
    Point3::new(
        p.x + 0.03 * inside * (17.0 * p.y).sin(),
        p.y + 0.03 * inside * (13.0 * p.z + 1.0).sin(),
        p.z + 0.03 * inside * (11.0 * p.x + 2.0).cos(),
    )
}

/// A distorted block of edge `size` under `load` times the tractions of its field.
pub(super) fn block(e: f64, nu: f64, size: f64, load: f64) -> Result<Block, VerifyError> {
    let material = material(e, nu)?;
    let mesh = grid([3; 3], |p| Point3::from(wobble(p).coords * size))?;
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

/// An inner node is moved towards the opposite face of one of its elements, until that element has
/// `height` times its height.
fn one_sliver(height: f64) -> Result<Block, VerifyError> {
    let material = material(E_PA, NU)?;
    let mesh = grid([3; 3], wobble)?;
    let (element, corner) = inner_corner(&mesh)?;
    let element = mesh.elements()[element];
    let apex = element[corner];
    let base = (0..4).filter(|&k| k != corner).map(|k| mesh.position(element[k]).coords);
    let foot = base.sum::<nalgebra::Vector3<f64>>() / 3.0;
    let mesh = moved(&mesh, |node, p| {
        if node == apex { Point3::from(foot + (p.coords - foot) * height) } else { p }
    })?;
    Ok(Block::free(mesh, material, [1.0; 3], stretch(material)))
}

/// An element and which of its corners lies inside the unit cube.
pub(super) fn inner_corner(mesh: &Tet10Mesh) -> Result<(usize, usize), VerifyError> {
    let is_inside = |n: FeNodeId| mesh.position(n).iter().all(|&c| c > 0.1 && c < 0.9);
    let corners = (0..mesh.elements().len()).flat_map(|e| (0..4).map(move |k| (e, k)));
    corners
        .into_iter()
        .find(|&(e, k)| is_inside(mesh.elements()[e][k]))
        .ok_or_else(|| VerifyError::not_run("the grid has no inner node"))
}

fn one_element() -> Result<Block, VerifyError> {
    let material = material(E_PA, NU)?;
    let nodes: Vec<Point3<f64>> = [
        [0.0; 3],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.5, 0.0, 0.0],
        [0.5, 0.5, 0.0],
        [0.0, 0.5, 0.0],
        [0.0, 0.0, 0.5],
        [0.5, 0.0, 0.5],
        [0.0, 0.5, 0.5],
    ]
    .map(Point3::from)
    .to_vec();
    let mesh = Tet10Mesh::new(nodes, vec![std::array::from_fn(FeNodeId::from_index)])?;
    Ok(Block::free(mesh, material, [1.0; 3], stretch(material)))
}
