//! Parts far stiffer or softer than the rest.

use hapdef_bench::robustness::Expected;
use hapdef_mesh::Tet10Mesh;
use hapdef_sim::{RigidBody, Supports};
use nalgebra::Point3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};

use super::field::{material, series, stretch};
use super::solid::{Block, grid};
use super::solids::{both, result_if};
use super::table::RobustnessTrials;
use crate::VerifyError;

const E_PA: f64 = 2e9;

/// Where a bar of length 2, clamped at x = 0, has another modulus.
#[derive(Clone, Copy)]
enum Part {
    Supported,
    Free,
    Middle,
}

impl Part {
    fn range(self) -> [f64; 2] {
        match self {
            Self::Supported => [0.0, 1.0],
            Self::Free => [1.0, 2.0],
            Self::Middle => [0.5, 1.5],
        }
    }
}

/// Rows of stiffness jumps; `seed` draws the random ones.
pub(super) fn add(rows: &mut RobustnessTrials, seed: u64) {
    let parts = [
        ("E × f in the supported half", Part::Supported),
        ("E × f in the free half", Part::Free),
        ("E × f in the middle half", Part::Middle),
    ];
    for (case, part) in parts {
        for f in [1e-9, 1e-6, 1e-3, 1e3, 1e6, 1e9] {
            // what holds by itself does not float on something soft
            let floats = match part {
                Part::Supported => f < 1.0,
                Part::Free => f > 1.0,
                // either it floats, or the free end does
                Part::Middle => true,
            };
            let expected = result_if(!floats || (1e-6..=1e6).contains(&f));
            both(rows, (case, format!("f = {f:e}")), expected, move || bar(part, f));
        }
    }
    for f in [1e-9, 1e-6, 1e6, 1e9] {
        let case = "E × f in 5 % of the elements, at random";
        let random = move || scattered(f, seed);
        both(rows, (case, format!("f = {f:e}")), Expected::Either, random);
    }
    let case = "a rigid body (RBE2) for the stiff part";
    both(rows, (case, "free half"), Expected::Result, || rigid(Part::Free));
    both(rows, (case, "middle half"), Expected::Result, || rigid(Part::Middle));
}

fn mesh() -> Result<Tet10Mesh, VerifyError> {
    grid([8, 2, 2], |p| Point3::new(2.0 * p.x, p.y, p.z))
}

/// Elements whose centre lies in a part.
fn is_in(mesh: &Tet10Mesh, element: usize, [from, to]: [f64; 2]) -> bool {
    let corners = &mesh.elements()[element][..4];
    let x = corners.iter().map(|&n| mesh.position(n).x).sum::<f64>() / 4.0;
    from < x && x < to
}

/// The field of the bar whose part has the compliance `compliance`, 1 elsewhere.
fn field(part: Part, compliance: f64) -> super::field::Field {
    let [from, to] = part.range();
    series(E_PA, vec![0.0, from, to, 2.0], vec![1.0, compliance, 1.0])
}

fn bar(part: Part, f: f64) -> Result<Block, VerifyError> {
    let mesh = mesh()?;
    let elements = 0..mesh.elements().len();
    let factor = |e| {
        if is_in(&mesh, e, part.range()) { f } else { 1.0 }
    };
    let scale = Some(elements.map(factor).collect());
    let mut block = Block::clamped(mesh, material(E_PA, 0.0)?, field(part, 1.0 / f));
    block.params.element_stiffness_scale = scale;
    Ok(block)
}

fn rigid(part: Part) -> Result<Block, VerifyError> {
    let mesh = mesh()?;
    let [from, to] = part.range();
    let nodes = mesh.nodes_where(|p| from <= p.x && p.x <= to);
    let mut block = Block::clamped(mesh, material(E_PA, 0.0)?, field(part, 0.0));
    block.params.supports =
        Supports { rigid_bodies: vec![RigidBody { nodes }], ..Supports::default() };
    Ok(block)
}

/// One strain everywhere, driven by what the stress jumps leave on the faces between elements.
fn scattered(f: f64, seed: u64) -> Result<Block, VerifyError> {
    let material = material(E_PA, 0.3)?;
    let mesh = grid([5; 3], |p| p)?;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let factor = |_| {
        if rng.next_u32() < u32::MAX / 20 { f } else { 1.0 }
    };
    let scale = mesh.elements().iter().map(factor).collect();
    let mut block = Block::free(mesh, material, [1.0; 3], stretch(material));
    block.params.element_stiffness_scale = Some(scale);
    Ok(block)
}
