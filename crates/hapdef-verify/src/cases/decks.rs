//! Shell meshes that others wrote: CalculiX's three-node shells, and irregular roofs.

use std::f64::consts::PI;

use hapdef_mesh::{FaceCurve, FeNodeId};
use nalgebra::Point3;

use super::inp::InpDeck;
use super::prelude::*;
use crate::deck::no_material;
use crate::meshes::Triangles;
use crate::problem::push;
use crate::shared;

/// Rows of the table.
pub(super) fn cases() -> Vec<Case> {
    let pressure = Case {
        name: "calculix.pressure",
        title: "CalculiX deck, plate with pressure",
        quantity: "largest deflection of a simply supported plate, 10 × 10, thickness 0.01, 100 Pa",
        unit: "m",
        reference: Reference::Exact(navier(100.0, 10.0, 0.01, 2.1e11, 0.3)),
        source: "Navier's series, Timoshenko and Woinowsky-Krieger, Theory of Plates and Shells, 2nd ed., \
            article 30. CalculiX's own three-node shell US3 gives 0.20822 on this mesh (its \
            reference result), Abaqus 0.206",
        meshes: &[[0; 3]],
        solve: Solve::by(|element, n| deck("pres_load", element, n[0], |s, _| Ok(s.largest()))),
        ..Case::default()
    };
    let twisted = Case {
        name: "calculix.twisted",
        title: "CalculiX deck, twisted beam",
        quantity: "tip displacement along a unit force, L = 12, 1.1 × 0.05, twist 90°, E = 29e6, ν = 0.22",
        unit: "in",
        reference: Reference::Published(1.390),
        source: "Rama, Marinkovic and Zehn, J. Braz. Soc. Mech. Sci. Eng. 40, 2018, as quoted in the deck. \
            CalculiX's own three-node shell US3 gives 1.385756 on this mesh (its reference result)",
        meshes: &[[0; 3]],
        solve: Solve::by(|element, n| {
            deck("twisted_beam", element, n[0], |s, deck| s.u(deck.place(3), 0))
        }),
        ..Case::default()
    };
    let cook = Case {
        name: "calculix.cook",
        title: "CalculiX deck, Cook's membrane",
        quantity: "v at (48, 52), unit shear, on the deck's mesh in its nine equal forces, on finer ones \
            uniform, E = 1, ν = 1/3, thickness 1",
        reference: Reference::Published(23.96),
        source: "Cook, 1974, converged value for a uniform shear (from memory); the deck's end nodes carry twice \
            theirs. CalculiX's own three-node shell US3 gives 22.3152 on the deck's mesh (its \
            reference result)",
        meshes: REFINEMENTS,
        solve: Solve::by(|element, n| {
            deck("cooks_beam_128", element, n[0], |s, deck| s.u(deck.place(1), 1))
        }),
        ..Case::default()
    };
    let roofs = Case {
        name: "scordelis_lo_irregular",
        title: "Scordelis–Lo roof on irregular meshes",
        quantity: "deflection at the middle of the free edge, the roof in inches; cells of very different size \
            and shape in two decks, then the second's split on the cylinder",
        unit: "in",
        reference: Reference::Published(12.0 * 0.3024),
        source: "as the regular roof, 12 · 0.3024; meshes by Abaqus/CAE from FinEtoolsFlexStructures",
        meshes: REFINEMENTS,
        solve: Solve::of(ROOF),
        ..Case::default()
    };
    [pressure.both(), twisted.both(), cook.both(), roofs.both()].concat()
}

const REFINEMENTS: &[[usize; 3]] = &[[0; 3], [1, 0, 0], [2, 0, 0], [3, 0, 0]];

/// The centre deflection of a simply supported square plate under uniform pressure.
fn navier(pressure: f64, side: f64, thickness: f64, e: f64, nu: f64) -> f64 {
    let rigidity = e * thickness.powi(3) / (12.0 * (1.0 - nu * nu));
    let odd = || (0..100).map(|i| f64::from(2 * i + 1));
    let sign = |m: f64| if (m as i64 / 2) % 2 == 0 { 1.0 } else { -1.0 };
    let term = |m: f64, n: f64| sign(m) * sign(n) / (m * n * (m * m + n * n).powi(2));
    let sum: f64 = odd().flat_map(|m| odd().map(move |n| term(m, n))).sum();
    16.0 * pressure * side.powi(4) / (PI.powi(6) * rigidity) * sum
}

impl InpDeck {
    /// The place of a label among the nodes.
    fn index(&self, label: usize) -> usize {
        self.nodes.range(..label).count()
    }

    fn place(&self, label: usize) -> Place {
        Place::At(self.nodes.get(&label).copied().unwrap_or_default().into())
    }

    fn nodes_of(&self, name: &str) -> Vec<usize> {
        self.labels(name).into_iter().map(|label| self.index(label)).collect()
    }
}

/// CalculiX's deck, its triangles split in four `n_refinements` times; from the first on the forces on
/// a set of nodes become a uniform load along it.
fn deck(
    name: &str,
    element: Element,
    n_refinements: usize,
    value: fn(&Solution, &InpDeck) -> Result<f64, VerifyError>,
) -> Result<Measured, VerifyError> {
    let deck = InpDeck::read(&shared(&format!("fe/calculix/lin_stat_{name}.inp"))?)?;
    let stated = deck.elastic.zip(deck.thickness);
    let (elastic, thickness) = stated.ok_or_else(|| no_material("no material or no section"))?;
    let mut triangles = Triangles {
        nodes: deck.nodes.values().copied().collect(),
        corners: deck.elements.iter().map(|e| e.map(|label| deck.index(label))).collect(),
        n: [0; 3],
    };
    let mut held: Vec<Vec<usize>> = deck.held.iter().map(|set| deck.nodes_of(&set.0)).collect();
    let mut pulled: Vec<Vec<usize>> = deck.forces.iter().map(|set| deck.nodes_of(&set.0)).collect();
    for _ in 0..n_refinements {
        triangles = refined(&triangles, held.iter_mut().chain(&mut pulled))?;
    }
    let ids = |nodes: &[usize]| nodes.iter().map(|&n| FeNodeId::from_index(n)).collect::<Vec<_>>();
    let words = words(&triangles, n_refinements);
    let body = Body { h: 0.5_f64.powi(n_refinements as i32), words, ..triangles.body(thickness)? };
    let mut problem = Problem::new(element, body, elastic)?;
    for (nodes, (_, dof)) in held.iter().zip(&deck.held) {
        problem.fix(ids(nodes), *dof);
    }
    let mut load = Load::Pressure(deck.pressure).on(&problem)?;
    for (nodes, (name, dof, force)) in pulled.iter().zip(&deck.forces) {
        if n_refinements > 0 && nodes.len() > 1 {
            let total = force * deck.labels(name).len() as f64;
            load = load.plus(&problem.line_load(&ids(nodes), *dof, total));
        } else {
            ids(nodes).into_iter().for_each(|node| push(&mut load, node, *dof, *force));
        }
    }
    let solution = problem.solve(load)?;
    Ok(solution.measured(value(&solution, &deck)?))
}

/// Triangles split in four; a new node joins the sets that both ends of its edge belong to.
fn refined<'a>(
    triangles: &Triangles,
    sets: impl Iterator<Item = &'a mut Vec<usize>>,
) -> Result<Triangles, VerifyError> {
    let (fine, halved) = triangles.refined(&FaceCurve::Flat)?;
    for set in sets {
        let inside = |ends: &[usize; 2]| ends.iter().all(|end| set.contains(end));
        let new = halved.iter().enumerate().filter(|(_, ends)| inside(ends));
        let new: Vec<usize> = new.map(|(i, _)| triangles.nodes.len() + i).collect();
        set.extend(new);
    }
    Ok(fine)
}

fn words(triangles: &Triangles, n_refinements: usize) -> String {
    let n = triangles.corners.len();
    match n_refinements {
        0 => format!("the deck's {n} triangles"),
        _ => format!("split into {n} triangles"),
    }
}

const RADIUS: f64 = 300.0;

/// A quarter of the roof, radius 300, length 600, thickness 3, weight 0.20833 along −x; the axis is z.
const ROOF: Model = Model {
    mesh: Mesh::Other(roof),
    material: [3e6, 0.0],
    supports: &[
        (Mirror(1), Where(|p| p.y.abs() < 1e-3)),
        (Mirror(2), Where(|p| (p.z - 300.0).abs() < 1e-3)),
        (Only(&[0, 1]), Where(|p| p.z.abs() < 1e-3)),
    ],
    load: Load::Area([-0.20833 * 3.0, 0.0, 0.0]),
    probe: Probe::Value(|s| {
        let (sin, cos) = 40.0_f64.to_radians().sin_cos();
        let middle = s.problem.body.node_near([RADIUS * cos, RADIUS * sin, 300.0], 0.1)?;
        Ok(-s.motion.displacement[middle.index()].x)
    }),
};

/// The coarse deck at 0, else the fine one, split n − 1 times: new nodes lie on the cylinder.
fn roof([n, ..]: [usize; 3]) -> Result<Body, VerifyError> {
    let file = if n == 0 { "stri3_irreg" } else { "s3r_fineirreg" };
    let deck = shared(&format!("fe/shell-meshes/barrelvault_{file}.inp"))?;
    let mut triangles = merged(&InpDeck::read(&deck)?);
    let onto = |p: &Point3<f64>| {
        let out = RADIUS / p.x.hypot(p.y);
        Point3::new(p.x * out, p.y * out, p.z)
    };
    let n_refinements = n.saturating_sub(1);
    for _ in 0..n_refinements {
        triangles = triangles.refined(&FaceCurve::Onto(&onto))?.0;
    }
    let (words, h) =
        (words(&triangles, n_refinements), (triangles.corners.len() as f64).powf(-0.5));
    Ok(Body { words, h, ..triangles.body(3.0)? })
}

/// The deck's mesh, nodes that coincide merged and unused ones dropped: the decks tie coincident seams
/// with beams.
fn merged(deck: &InpDeck) -> Triangles {
    let mut nodes: Vec<Point3<f64>> = Vec::new();
    let mut place = |label: usize| {
        let p = deck.nodes.get(&label).copied().unwrap_or_default();
        let old = nodes.iter().position(|q| (q - p).norm() < 1e-3);
        old.unwrap_or_else(|| {
            nodes.push(p);
            nodes.len() - 1
        })
    };
    let corners = deck.elements.iter().map(|e| e.map(&mut place)).collect();
    Triangles { nodes, corners, n: [0; 3] }
}
