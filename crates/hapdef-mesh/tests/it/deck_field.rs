//! Volume meshes as people's programs wrote them (`HAPDEF_SHARED`, inputs/field): what a scene reads
//! of each, or why it is refused. None of them is in the repository.

use std::path::PathBuf;

use crate::gltf_common::shared;
use hapdef_mesh::{DeckParams, DeckReading, LengthUnit, MeshError, SolidDeck, read_deck_with};

fn field(file: &str) -> Option<PathBuf> {
    shared(&format!("field/{file}"))
}

fn read(file: &str) -> Option<Result<SolidDeck, MeshError>> {
    let params = DeckParams { reading: DeckReading::Mesh, ..DeckParams::default() };
    Some(read_deck_with(&field(file)?, &params))
}

/// Elements, bodies, and a part of the notes.
#[track_caller]
fn reads(file: &str, n_elements: usize, n_bodies: usize, note: &str) -> Option<SolidDeck> {
    let deck = read(file)?.unwrap_or_else(|error| panic!("{error}"));
    let found = (deck.mesh.elements().len(), deck.mesh.bodies().len());
    println!("{file}: {found:?} {:?}", deck.notes);
    assert_eq!(found, (n_elements, n_bodies), "{file}");
    assert!(deck.notes.join("\n").contains(note), "{file}: {:?}", deck.notes);
    Some(deck)
}

#[track_caller]
fn refused(file: &str, why: &str) {
    if let Some(read) = read(file) {
        let found = read.err().map_or_else(|| "it was read".to_owned(), |error| error.to_string());
        println!("{found}");
        assert!(found.contains(why), "{found}");
    }
}

#[test]
fn gmsh_and_meshio() {
    reads("gmsh/gmsh_default.inp.gz", 2475, 1, "CPS6");
    if let Some(deck) = reads("gmsh/gmsh_groups_nodes.inp.gz", 2475, 1, "50 CPS6") {
        assert!(deck.node_sets["MOUNT"].len() > 50, "{}", deck.node_sets["MOUNT"].len());
        assert!(!deck.node_sets.contains_key("VOLUME1"));
    }
    reads("gmsh/gmsh_volume_only.inp.gz", 2475, 1, "");
    reads("gmsh/meshio_tet10.inp.gz", 2475, 1, "C3D10MH is read as C3D10");
    reads("gmsh/two_tubes_one_floats.inp.gz", 4950, 2, "");
}

#[test]
fn abaqus_and_calculix() {
    reads("abaqus/abaquscae_PART_bracket.inp", 793, 1, "793 four-node tetrahedra");
    reads("abaqus/mecway_BOM_solid2.inp", 559, 1, "559 four-node tetrahedra");
    reads("calculix/hypermesh_two_bodies.inp", 269, 2, "");
}

#[test]
fn ansys() {
    let read = reads("ansys/wb18_structural_steel_MURX.dat.gz", 8168, 1, "passed over");
    if let Some(deck) = read {
        assert_eq!((deck.unit, deck.fixed_nodes.len()), (Some(LengthUnit::Metre), 145));
        assert_eq!(deck.material.unwrap().youngs_modulus_pa, 4e6);
    }
    refused("ansys/wb2021R2_units_MPA.dat.gz", "element type 186");
    refused("ansys/wb2024R2_nblock_without_end.dat", "no tetrahedron is left: the deck has");
    refused("ansys/cdwrite2025R1_ETBLOCK.cdb", "element type 186");
    refused("ansys/etblock.cdb", "1 of type 181 only");
    refused("ansys/TetBeam.cdb", "expected ten nodes, found `4 nodes`");
    refused("ansys/workbench_193.cdb", "no element");
    refused("ansys/primemesh_LOCAL.cdb", "element type 185");
    refused("ansys/hypermesh.cdb", "80 of type 181 only");
}
