//! Writes a deck that Abaqus, CalculiX and [`crate::read_deck`] read.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use flate2::{Compression, GzBuilder};
use nalgebra::Vector3;

use super::SolidDeck;
use crate::{FeNodeId, MeshError, Tri6Face, atomic_write, face_positions, tri6};

/// Writes `deck` as an `.inp`, through a temporary file in the same folder; compressed if `path`
/// ends in `.gz`. The same deck gives the same bytes.
///
/// Numbers keep at least 13 significant digits, and all that twenty characters hold: CalculiX
/// reads no more. Tractions become their consistent nodal forces, for which the format has no
/// shorter word; `unused_node_labels` are left out.
///
/// # Errors
/// [`MeshError::Io`] if the file can't be written.
pub fn write_inp(path: &Path, deck: &SolidDeck) -> Result<(), MeshError> {
    let text = inp_text(deck);
    let compressed = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("gz"));
    atomic_write(path, |file| {
        if compressed {
            // no name and no time in the header, so that equal decks give equal files
            let mut encoder = GzBuilder::new().mtime(0).write(file, Compression::best());
            encoder.write_all(text.as_bytes())?;
            encoder.finish().map(|_| ())
        } else {
            file.write_all(text.as_bytes())
        }
    })
    .map_err(|cause| MeshError::Io { action: "write", path: path.to_owned(), cause })
}

/// The deck's text.
fn inp_text(deck: &SolidDeck) -> String {
    let mut text = String::from("*HEADING\nsolid limb, SI units (m, N, Pa, kg)\n");
    mesh(&mut text, deck);
    for (name, nodes) in &deck.node_sets {
        let _ = writeln!(text, "*NSET, NSET={name}");
        set(&mut text, deck, nodes);
    }
    material(&mut text, deck);
    if !deck.fixed_nodes.is_empty() {
        text.push_str("*BOUNDARY\n");
        for node in &deck.fixed_nodes {
            let _ = writeln!(text, "{}, 1, 3", deck.node_labels[node.index()]);
        }
    }
    text.push_str("*STEP\n*STATIC\n");
    loads(&mut text, deck);
    text.push_str("*NODE FILE\nU\n*END STEP\n");
    text
}

fn mesh(text: &mut String, deck: &SolidDeck) {
    text.push_str("*NODE\n");
    for (label, p) in deck.node_labels.iter().zip(deck.mesh.nodes()) {
        let _ = writeln!(text, "{label}, {}, {}, {}", real(p.x), real(p.y), real(p.z));
    }
    text.push_str("*ELEMENT, TYPE=C3D10, ELSET=ALL_ELEMENTS\n");
    for (label, nodes) in deck.element_labels.iter().zip(deck.mesh.elements()) {
        let _ = write!(text, "{label}");
        for node in nodes {
            let _ = write!(text, ", {}", deck.node_labels[node.index()]);
        }
        text.push('\n');
    }
}

fn set(text: &mut String, deck: &SolidDeck, nodes: &[FeNodeId]) {
    for line in nodes.chunks(12) {
        let labels: Vec<_> =
            line.iter().map(|node| deck.node_labels[node.index()].to_string()).collect();
        let _ = writeln!(text, "{},", labels.join(", "));
    }
}

fn material(text: &mut String, deck: &SolidDeck) {
    let Some(material) = &deck.material else {
        return;
    };
    let (e, nu) = (real(material.youngs_modulus_pa), real(material.poissons_ratio));
    let _ = writeln!(text, "*MATERIAL, NAME=LIMB\n*ELASTIC\n{e}, {nu}");
    if let Some(density) = material.density_kg_m3 {
        let _ = writeln!(text, "*DENSITY\n{}", real(density));
    }
    text.push_str("*SOLID SECTION, ELSET=ALL_ELEMENTS, MATERIAL=LIMB\n");
}

fn loads(text: &mut String, deck: &SolidDeck) {
    let forces = all_forces(deck);
    if forces.is_empty() {
        return;
    }
    text.push_str("*CLOAD\n");
    for (node, force) in forces {
        for (axis, component) in force.iter().enumerate().filter(|(_, c)| **c != 0.0) {
            let label = deck.node_labels[node.index()];
            let _ = writeln!(text, "{label}, {}, {}", axis + 1, real(*component));
        }
    }
}

/// Point forces and the consistent forces fᵢ = ∫ Nᵢ t dA of the tractions.
fn all_forces(deck: &SolidDeck) -> BTreeMap<FeNodeId, Vector3<f64>> {
    let mut forces: BTreeMap<_, _> = deck.nodal_forces.iter().copied().collect();
    for load in &deck.face_tractions {
        let face = Tri6Face { nodes: load.nodes, element: 0 };
        let positions = face_positions(&deck.mesh, &face);
        for q in tri6::QUADRATURE {
            let area = q.weight * tri6::area_vector(&positions, q.xi, q.eta).norm();
            for (node, n) in load.nodes.iter().zip(tri6::shape(q.xi, q.eta)) {
                let force = forces.entry(*node).or_insert_with(Vector3::zeros);
                *force += load.traction_pa * (n * area);
            }
        }
    }
    forces
}

/// A number in at most twenty characters: the shortest that reads back exactly if that fits.
fn real(value: f64) -> String {
    let shortest = format!("{value:e}");
    if shortest.len() <= 20 { shortest } else { format!("{value:.12e}") }
}
