//! CalculiX's own test deck against its reference result, and a tube through the `ccx` program.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::rc::Rc;
use std::time::Instant;

use hapdef_mesh::{DeckMaterial, FeNodeId, SolidDeck, read_deck, read_displacements};
use hapdef_report::ReportError;
use hapdef_sim::NodalLoad;
use nalgebra::{Point3, Vector3};

use super::inp::InpDeck;
use super::prelude::*;
use crate::ccx::ccx;
use crate::deck::{largest_difference, no_material};
use crate::memo::Memo;
use crate::shared;

/// Rows of the table.
pub(super) fn cases() -> Vec<Case> {
    let beam = Case {
        name: "calculix.beam10p",
        element: Element::C3d10,
        title: "CalculiX beam10p",
        quantity: "largest difference / largest displacement over all nodes",
        source: "CalculiX test suite, reference result beside the deck",
        // the reference prints seven digits
        target: Target::within(1e-6),
        solve: Solve::by(|element, _| own_deck(element, "beam10p")),
        ..Case::default()
    };
    let tubes = Rc::new(Memo::default());
    let tube = |of: fn(&BothTubes) -> f64| {
        let tubes = Rc::clone(&tubes);
        Solve::by(move |element, n| {
            let both = tubes.get(n, || both_tubes(element, n))?;
            Ok(Measured { value: of(&both), ..both.sizes.clone() })
        })
    };
    let displacement = Case {
        name: "ccx.displacement",
        element: Element::C3d10,
        title: "Side by side with ccx, a bent tube",
        quantity: "largest difference / largest displacement",
        source: "the program ccx on the deck that hapdef_mesh::write_inp writes",
        // ccx prints seven digits
        target: Target::within(1e-5),
        meshes: &[[24, 4, 4], [48, 8, 6]],
        solve: tube(|both| both.difference),
        ..Case::default()
    };
    let time = Case {
        name: "ccx.time",
        title: "Side by side with ccx, time",
        quantity: "wall time of ccx / wall time of hapdef (assemble, factor, solve), two threads each",
        reference: Reference::Reported,
        target: Target::within(0.0),
        solve: tube(|both| both.time_ratio),
        ..displacement.clone()
    };
    vec![beam, displacement, time]
}

/// CalculiX's deck of this name beside its reference result.
fn own_deck(element: Element, name: &str) -> Result<Measured, VerifyError> {
    let path = shared(&format!("fe/calculix/{name}.inp"))?;
    let reference = shared(&format!("fe/calculix/{name}.dat.ref"))?;
    let text = std::fs::read_to_string(&path).map_err(ReportError::io("reading", &path))?;
    let deck = parse(&without_boundary(&text))?;
    let material = deck.material.ok_or_else(|| no_material("none"))?;
    let words = format!("the deck's {} elements", deck.mesh.elements().len());
    let body = Body::solid(deck.mesh.clone(), [1; 3]).named(words);
    let elastic = [material.youngs_modulus_pa, material.poissons_ratio];
    let mut problem = Problem::new(element, body, elastic)?;
    for (name, axis) in InpDeck::parse(&text).held.into_iter().filter(|held| held.1 < 3) {
        let node = |label: u32| deck.node_labels.binary_search(&label).ok();
        let nodes = match name.parse() {
            Ok(label) => node(label).map(FeNodeId::from_index).into_iter().collect(),
            Err(_) => deck.node_sets.get(&name).cloned().unwrap_or_default(),
        };
        problem.fix(nodes, axis);
    }
    let solution = problem.solve(NodalLoad::of_deck(&deck)?)?;
    let difference = difference(deck.node_labels, &solution, &read_displacements(&reference)?)?;
    Ok(solution.measured(difference))
}

/// The deck of a text.
fn parse(text: &str) -> Result<SolidDeck, VerifyError> {
    let io = ReportError::io("making a folder in", ".".as_ref());
    let folder = tempfile::tempdir().map_err(io)?;
    let copy = folder.path().join("deck.inp");
    std::fs::write(&copy, text).map_err(ReportError::io("writing", &copy))?;
    Ok(read_deck(&copy)?)
}

/// The text but for its `*BOUNDARY` block: the deck reader wants whole nodes held.
fn without_boundary(text: &str) -> String {
    let mut inside = false;
    let rest = text.lines().filter(|line| {
        if line.starts_with('*') && !line.starts_with("**") {
            inside = line.to_uppercase().starts_with("*BOUNDARY");
        }
        !inside
    });
    rest.flat_map(|line| [line, "\n"]).collect()
}

fn difference(
    labels: Vec<u32>,
    solution: &Solution,
    reference: &[(u32, Vector3<f64>)],
) -> Result<f64, VerifyError> {
    largest_difference(
        labels.into_iter().zip(solution.motion.displacement.iter().copied()),
        reference,
    )
}

/// What both programs gave for the tube.
struct BothTubes {
    difference: f64,
    time_ratio: f64,
    sizes: Measured,
}

/// Half a tube of radius 20 to 23 mm, 200 mm long, with a waist, in both programs.
fn both_tubes(element: Element, n: [usize; 3]) -> Result<BothTubes, VerifyError> {
    let tube = |p: Point3<f64>| {
        let (r, phi) = (0.020 + 0.003 * p.x, PI * p.y);
        let r = r * (1.0 - 0.2 * (PI * p.z).sin());
        Point3::new(r * phi.cos(), r * phi.sin(), 0.2 * p.z)
    };
    let mesh = Blocks::default().block([n[2] / 2, n[1] * 2, n[0]], tube).finish()?;
    let mut problem = Problem::new(element, Body::solid(mesh, n), [2e9, 0.3])?;
    problem.hold(Held::All, |p| same(p.z, 0.0));
    let load = problem.traction(|p| same(p.z, 0.2), |_, _| Vector3::new(1e5, 2e5, 0.0))?;
    let deck = deck(&problem, &load)?;
    let (other_s, other) = ccx(&deck, 2)?;
    if other.len() != deck.node_labels.len() {
        let expected = format!("displacements of {} nodes", deck.node_labels.len());
        return Err(VerifyError::setup("ccx", expected, other.len().to_string()));
    }
    let started = Instant::now();
    let solution = problem.solve(load)?;
    let own_s = started.elapsed().as_secs_f64();
    Ok(BothTubes {
        difference: difference(deck.node_labels, &solution, &other)?,
        time_ratio: other_s / own_s,
        sizes: solution.measured(f64::NAN),
    })
}

fn deck(problem: &Problem, load: &NodalLoad) -> Result<SolidDeck, VerifyError> {
    let mesh = problem.body.tets()?.clone();
    let (n_nodes, n_elements) = (mesh.nodes().len() as u32, mesh.elements().len() as u32);
    let mut forces: BTreeMap<FeNodeId, Vector3<f64>> = BTreeMap::new();
    for (node, force) in &load.forces_n {
        *forces.entry(*node).or_insert_with(Vector3::zeros) += force;
    }
    Ok(SolidDeck {
        fixed_nodes: problem.body.nodes_where(|p| same(p.z, 0.0)),
        mesh,
        node_labels: (1..=n_nodes).collect(),
        element_labels: (1..=n_elements).collect(),
        node_sets: BTreeMap::from([("EVERY".to_owned(), (0..n_nodes).map(FeNodeId).collect())]),
        material: Some(DeckMaterial {
            youngs_modulus_pa: problem.material.youngs_modulus_pa(),
            poissons_ratio: problem.material.poissons_ratio(),
            density_kg_m3: None,
        }),
        nodal_forces: forces.into_iter().collect(),
        face_tractions: Vec::new(),
        unused_node_labels: Vec::new(),
        unit: None,
        notes: Vec::new(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_directions_are_read() {
        let text = "*NODE\n1, 0, 0\n*BOUNDARY\n1,1,2\nfix,3\n*STEP\n";
        assert_eq!(without_boundary(text), "*NODE\n1, 0, 0\n*STEP\n");
        let held = InpDeck::parse(text).held;
        let names: Vec<_> = held.iter().map(|(name, axis)| (name.as_str(), *axis)).collect();
        assert_eq!(names, [("1", 0), ("1", 1), ("FIX", 2)]);
    }
}
