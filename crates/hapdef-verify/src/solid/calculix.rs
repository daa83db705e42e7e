//! CalculiX's own test decks against their reference results.

use std::collections::BTreeMap;
use std::path::Path;

use hapdef_mesh::{FeNodeId, read_deck};

use super::problem::Problem;
use crate::deck::{largest, own_load};
use crate::{Case, Measured, Reference, Target, VerifyError, read_displacements, shared};

const SOURCE: &str = "CalculiX test suite, reference result beside the deck";

/// Rows of the table.
pub(super) fn cases() -> Vec<Case> {
    vec![case("solid.calculix.beam10p", "CalculiX beam10p", "beam10p")]
}

fn case(id: &'static str, title: &'static str, file: &'static str) -> Case {
    Case {
        id,
        title,
        element: "C3D10",
        quantity: "largest difference / largest displacement over all nodes",
        unit: "1",
        reference: Reference::Zero,
        source: SOURCE,
        // the reference prints seven digits
        target: Target::within(1e-6),
        n_levels: 1,
        known_miss: None,
        run: Box::new(move |_| {
            let deck = shared(&format!("fe/calculix/{file}.inp"))?;
            let reference = shared(&format!("fe/calculix/{file}.dat.ref"))?;
            compare(&deck, &reference)
        }),
    }
}

fn compare(path: &Path, reference: &Path) -> Result<Measured, VerifyError> {
    let io = |action, cause| VerifyError::Io { action, path: path.to_owned(), cause };
    let text = std::fs::read_to_string(path).map_err(|cause| io("reading", cause))?;
    // the deck reader wants whole nodes held; single directions are read here
    let (rest, held) = split_boundary(&text);
    let folder = tempfile::tempdir().map_err(|cause| io("making a folder beside", cause))?;
    let copy = folder.path().join("deck.inp");
    std::fs::write(&copy, rest).map_err(|cause| io("copying", cause))?;
    let deck = read_deck(&copy)?;
    let material = deck.material.ok_or_else(|| VerifyError::not_run("no material"))?;
    let load = own_load(&deck)?;
    let node_of =
        |label: u32| deck.node_labels.binary_search(&label).ok().map(FeNodeId::from_index);
    let mut problem =
        Problem::new(deck.mesh.clone(), material.youngs_modulus_pa, material.poissons_ratio)?;
    for (name, axis) in held {
        let nodes = match name.parse() {
            Ok(label) => node_of(label).into_iter().collect(),
            Err(_) => deck.node_sets.get(&name).cloned().unwrap_or_default(),
        };
        problem = problem.hold_nodes(axis, nodes);
    }
    let solution = problem.solve(&load)?;
    let expected: BTreeMap<u32, _> = read_displacements(reference)?.into_iter().collect();
    let apart = deck
        .node_labels
        .iter()
        .zip(&solution.u)
        .filter_map(|(label, u)| Some((u - expected.get(label)?).norm()));
    let value = apart.fold(0.0, f64::max) / largest(&solution.u);
    let n_elements = deck.mesh.elements().len();
    Ok(solution.measured(value, format!("the deck's {n_elements} elements"), 1.0))
}

/// The deck without its `*BOUNDARY` block, and what that holds: node or set name, and axis.
fn split_boundary(text: &str) -> (String, Vec<(String, usize)>) {
    let (mut rest, mut held, mut inside) = (String::new(), Vec::new(), false);
    for line in text.lines() {
        if line.starts_with('*') && !line.starts_with("**") {
            inside = line.to_uppercase().starts_with("*BOUNDARY");
        }
        if !inside {
            rest.push_str(line);
            rest.push('\n');
            continue;
        }
        let words: Vec<&str> = line.split(',').map(str::trim).collect();
        let axis = |word: Option<&&str>| word.and_then(|word| word.parse::<usize>().ok());
        if let (Some(name), Some(first)) = (words.first(), axis(words.get(1))) {
            let last = axis(words.get(2)).unwrap_or(first);
            held.extend((first..=last.min(3)).map(|axis| (name.to_uppercase(), axis - 1)));
        }
    }
    (rest, held)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_directions_are_read() {
        let (rest, held) = split_boundary("*NODE\n1, 0, 0\n*BOUNDARY\n1,1,2\nfix,3\n*STEP\n");
        assert_eq!(rest, "*NODE\n1, 0, 0\n*STEP\n");
        let names: Vec<_> = held.iter().map(|(name, axis)| (name.as_str(), *axis)).collect();
        assert_eq!(names, [("1", 0), ("1", 1), ("FIX", 2)]);
    }
}
