//! Shell meshes that others wrote: CalculiX's three-node shells, and irregular roofs.

use std::f64::consts::PI;
use std::rc::Rc;

use hapdef_mesh::FaceCurve;
use hapdef_sim::ShellKind;
use nalgebra::{Point3, Vector3};

use super::benchmark::{Benchmark, ids};
use super::grid::{Grid, Pattern};
use super::inp::ShellDeck;
use super::problem::{Problem, Solution};
use crate::{Case, Measured, Reference, Target, VerifyError, shared};

/// Rows of the table.
pub(super) fn cases() -> Vec<Case> {
    let decks = [
        Benchmark {
            quantity: "largest deflection of a simply supported plate, 10 × 10, thickness 0.01, 100 Pa",
            unit: "m",
            ..deck(
                ids!("calculix.pressure"),
                "CalculiX deck, plate with pressure",
                "Navier's series, Timoshenko and Woinowsky-Krieger, Theory of Plates and Shells, 2nd ed., \
                    article 30. CalculiX's own three-node shell US3 gives 0.20822 on this mesh (its \
                    reference result), Abaqus 0.206",
                Reference::Exact(navier(100.0, 10.0, 0.01, 2.1e11, 0.3)),
                ("lin_stat_pres_load", deepest),
            )
        },
        Benchmark {
            quantity: "tip displacement along a unit force, L = 12, 1.1 × 0.05, twist 90°, E = 29e6, ν = 0.22",
            unit: "in",
            ..deck(
                ids!("calculix.twisted"),
                "CalculiX deck, twisted beam",
                "Rama, Marinkovic and Zehn, J. Braz. Soc. Mech. Sci. Eng. 40, 2018, as quoted in the deck. \
                    CalculiX's own three-node shell US3 gives 1.385756 on this mesh (its reference result)",
                Reference::Published(1.390),
                ("lin_stat_twisted_beam", |s, at| s.u(at(3), 0)),
            )
        },
        Benchmark {
            n: &[0, 1, 2, 3],
            quantity: "v at (48, 52), unit shear, on the deck's mesh in its nine equal forces, on finer ones \
                uniform, E = 1, ν = 1/3, thickness 1",
            unit: "1",
            ..deck(
                ids!("calculix.cook"),
                "CalculiX deck, Cook's membrane",
                "Cook, 1974, converged value for a uniform shear (from memory); the deck's end nodes carry twice \
                    theirs. CalculiX's own three-node shell US3 gives 22.3152 on the deck's mesh (its \
                    reference result)",
                Reference::Published(23.96),
                ("lin_stat_cooks_beam_128", |s, at| s.u(at(1), 1)),
            )
        },
    ];
    let [pressure, twisted, cook] = decks;
    let mut cases = pressure.both();
    cases.extend(twisted.both());
    cases.extend(cook.both());
    cases.extend(roofs().both());
    cases
}

/// The position of a label in the solution.
type Place<'a> = &'a dyn Fn(usize) -> usize;

fn deck(
    ids: [&'static str; 2],
    title: &'static str,
    source: &'static str,
    reference: Reference,
    (file, value): (&'static str, fn(&Solution, Place<'_>) -> f64),
) -> Benchmark {
    Benchmark {
        ids,
        title,
        quantity: "",
        unit: "1",
        reference,
        source,
        target: Target::within(0.01),
        n: &[0],
        patterns: &[Pattern::Up],
        solve: Rc::new(move |kind, mesh| {
            let deck = ShellDeck::read(&shared(&format!("fe/calculix/{file}.inp"))?)?;
            solve(&deck, mesh.n, kind, value)
        }),
    }
}

fn deepest(s: &Solution, _: Place<'_>) -> f64 {
    let nodes = s.motion.displacement.iter();
    nodes.map(|u| u.norm()).fold(0.0, f64::max)
}

/// The centre deflection of a simply supported square plate under uniform pressure.
fn navier(pressure: f64, side: f64, thickness: f64, e: f64, nu: f64) -> f64 {
    let rigidity = e * thickness.powi(3) / (12.0 * (1.0 - nu * nu));
    let odd = || (0..100).map(|i| f64::from(2 * i + 1));
    let sign = |m: f64| if (m as i64 / 2) % 2 == 0 { 1.0 } else { -1.0 };
    let term = |m: f64, n: f64| sign(m) * sign(n) / (m * n * (m * m + n * n).powi(2));
    let sum: f64 = odd().flat_map(|m| odd().map(move |n| term(m, n))).sum();
    16.0 * pressure * side.powi(4) / (PI.powi(6) * rigidity) * sum
}

/// The deck, its triangles split in four `n_refinements` times; from the first on the forces on a
/// set of nodes become a uniform load along it.
fn solve(
    deck: &ShellDeck,
    n_refinements: usize,
    kind: ShellKind,
    value: fn(&Solution, Place<'_>) -> f64,
) -> Result<Measured, VerifyError> {
    let stated = deck.elastic.zip(deck.thickness);
    let ([e, nu], thickness) = stated.ok_or_else(|| VerifyError::Setup {
        what: "the shell deck",
        expected: "an elastic material and a section".to_owned(),
        found: "none".to_owned(),
    })?;
    let labels: Vec<usize> = deck.nodes.keys().copied().collect();
    let at = |label: usize| labels.partition_point(|&l| l < label);
    let triangles = deck.elements.iter().map(|e| e.map(at));
    let mut grid = Grid {
        nodes: deck.nodes.values().copied().collect(),
        triangles: triangles.collect(),
        nu: 0,
        nv: 0,
    };
    let nodes_of = |name: &str| -> Vec<usize> { deck.labels(name).into_iter().map(at).collect() };
    let mut held: Vec<Vec<usize>> = deck.held.iter().map(|(name, _)| nodes_of(name)).collect();
    let mut pulled: Vec<Vec<usize>> = deck.forces.iter().map(|set| nodes_of(&set.0)).collect();
    for _ in 0..n_refinements {
        grid = refined(&grid, held.iter_mut().chain(&mut pulled))?;
    }
    let mut p = Problem::new(&grid, thickness, e, nu)?;
    for (nodes, (_, dof)) in held.iter().zip(&deck.held) {
        p.fix(nodes, &[*dof]);
    }
    for (nodes, (name, dof, force)) in pulled.iter().zip(&deck.forces) {
        if n_refinements > 0 && nodes.len() > 1 {
            let total = force * deck.labels(name).len() as f64;
            p.line_load(&in_line(&grid, nodes), *dof, total);
        } else {
            nodes.iter().for_each(|&node| p.force(node, *dof, *force));
        }
    }
    p.pressure(deck.pressure);
    let s = p.solve(kind)?;
    let h = 0.5_f64.powi(n_refinements as i32);
    Ok(s.measured(value(&s, &at), triangles_in_words(&grid, n_refinements), h))
}

/// Triangles split in four; a new node joins the sets that both ends of its edge belong to.
fn refined<'a>(
    grid: &Grid,
    sets: impl Iterator<Item = &'a mut Vec<usize>>,
) -> Result<Grid, VerifyError> {
    let (fine, halved) = grid.refined(&FaceCurve::Flat)?;
    for set in sets {
        let inside = |ends: &[usize; 2]| ends.iter().all(|end| set.contains(end));
        let new = halved.iter().enumerate().filter(|(_, ends)| inside(ends));
        let new: Vec<usize> = new.map(|(i, _)| grid.nodes.len() + i).collect();
        set.extend(new);
    }
    Ok(fine)
}

fn triangles_in_words(grid: &Grid, n_refinements: usize) -> String {
    let n = grid.triangles.len();
    match n_refinements {
        0 => format!("the deck's {n} triangles"),
        _ => format!("split into {n} triangles"),
    }
}

/// Nodes of a straight line, from one end to the other.
fn in_line(grid: &Grid, nodes: &[usize]) -> Vec<usize> {
    let from = |a: usize| move |b: usize| (grid.nodes[b] - grid.nodes[a]).norm();
    let furthest = |a: usize| {
        let apart = from(a);
        let further = |b: &&usize, c: &&usize| apart(**b).total_cmp(&apart(**c));
        nodes.iter().max_by(further).copied().unwrap_or(a)
    };
    let end = furthest(nodes[0]);
    let apart = from(end);
    let mut line = nodes.to_vec();
    line.sort_by(|&a, &b| apart(a).total_cmp(&apart(b)));
    line
}

fn roofs() -> Benchmark {
    Benchmark {
        ids: ids!("scordelis_lo_irregular"),
        title: "Scordelis–Lo roof on irregular meshes",
        quantity: "deflection at the middle of the free edge, the roof in inches; cells of very different size \
            and shape in two decks, then the second's split on the cylinder",
        unit: "in",
        reference: Reference::Published(12.0 * 0.3024),
        source: "as the regular roof, 12 · 0.3024; meshes by Abaqus/CAE from FinEtoolsFlexStructures",
        target: Target::within(0.01),
        n: &[0, 1, 2, 3],
        patterns: &[Pattern::Up],
        solve: Rc::new(|kind, mesh| {
            let coarse = mesh.n == 0;
            let file = if coarse { "stri3_irreg" } else { "s3r_fineirreg" };
            let deck = shared(&format!("fe/shell-meshes/barrelvault_{file}.inp"))?;
            roof(&ShellDeck::read(&deck)?, mesh.n.saturating_sub(1), kind)
        }),
    }
}

/// The deck's mesh, nodes that coincide merged and unused ones dropped: the decks tie coincident seams
/// with beams.
fn merged(deck: &ShellDeck) -> Grid {
    let mut nodes: Vec<Point3<f64>> = Vec::new();
    let mut place = |label: usize| {
        let p = deck.nodes.get(&label).copied().unwrap_or_default();
        let old = nodes.iter().position(|q| (q - p).norm() < 1e-3);
        old.unwrap_or_else(|| {
            nodes.push(p);
            nodes.len() - 1
        })
    };
    let triangles = deck.elements.iter().map(|e| e.map(&mut place)).collect();
    Grid { nodes, triangles, nu: 0, nv: 0 }
}

const ROOF_RADIUS: f64 = 300.0;

/// Radius 300, length 600, thickness 3, E = 3e6, ν = 0, weight 0.20833 along −x; the axis is z. New
/// nodes of refinements lie on the cylinder.
fn roof(deck: &ShellDeck, n_refinements: usize, kind: ShellKind) -> Result<Measured, VerifyError> {
    let mut grid = merged(deck);
    let onto = |p: &Point3<f64>| {
        let out = ROOF_RADIUS / p.x.hypot(p.y);
        Point3::new(p.x * out, p.y * out, p.z)
    };
    for _ in 0..n_refinements {
        grid = grid.refined(&FaceCurve::Onto(&onto))?.0;
    }
    let find = |take: &dyn Fn(&Point3<f64>) -> bool| -> Vec<usize> {
        (0..grid.nodes.len()).filter(|&i| take(&grid.nodes[i])).collect()
    };
    let mut p = Problem::new(&grid, 3.0, 3e6, 0.0)?;
    p.mirror(&find(&|q| q.y.abs() < 1e-3), 1);
    p.mirror(&find(&|q| (q.z - 300.0).abs() < 1e-3), 2);
    p.fix(&find(&|q| q.z.abs() < 1e-3), &[0, 1]);
    p.area_force(Vector3::new(-0.20833 * 3.0, 0.0, 0.0));
    let free = ROOF_RADIUS * 40.0_f64.to_radians().sin();
    let middle = find(&|q| (q.z - 300.0).abs() < 1e-3 && (q.y - free).abs() < 0.1);
    let [middle] = middle.as_slice() else {
        return Err(VerifyError::Setup {
            what: "the middle of the roof's free edge",
            expected: "one node".to_owned(),
            found: format!("{}", middle.len()),
        });
    };
    let s = p.solve(kind)?;
    let mesh = triangles_in_words(&grid, n_refinements);
    let h = 1.0 / (grid.triangles.len() as f64).sqrt();
    Ok(s.measured(-s.u(*middle, 0), mesh, h))
}
