//! Abaqus and CalculiX decks: what is read and what is refused.

use std::fs;
use std::io::Write;

use crate::gltf_common::shared;
use hapdef_mesh::{
    DeckFault, DeckParams, DeckReading, FeNodeId, MeshError, SolidDeck, read_deck, read_deck_with,
};
use nalgebra::Vector3;
use proptest::prelude::*;

/// One element, numbered with gaps, every supported keyword once.
const DECK: &str = "** a comment
*Heading
one tetrahedron
*NODE, nset=All
10, 0., 0., 0.
20, 1.0, 0., 0.
30, 0., 1.D0,
40, 0., 0., 1.
50, .5
60, .5, .5
70, 0., .5
80, 0., 0., .5
90, .5, 0., .5
100, 0., .5, 5.0e-1
999, 7., 7., 7.
*Element, Type=c3d10,
 ELSET=solid
7, 10, 20, 30, 40, 50,
60, 70, 80, 90, 100
*NSET, NSET=Base, GENERATE
10, 30, 10
*nset, nset=base
50, 60,
70
*NSET, NSET=both
base, 40
*ELSET, ELSET=loaded
solid,
*MATERIAL, NAME=pa
*ELASTIC
1.7e9, 0.394
*DENSITY
930.
*SOLID SECTION, ELSET=solid, MATERIAL=PA
*BOUNDARY
Base, 1, 2
base, 3, 3
*STEP
*STATIC
*CLOAD
40, 1, 10.
40, 3, -15.
*DLOAD
loaded, P3, 12.
*NODE FILE
U
*END STEP
";

fn read_text(text: &str) -> Result<SolidDeck, MeshError> {
    read_for(DeckReading::Whole, text)
}

fn read_for(reading: DeckReading, text: &str) -> Result<SolidDeck, MeshError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.inp");
    fs::write(&path, text).unwrap();
    read_deck_with(&path, &DeckParams { reading, ..DeckParams::default() })
}

#[track_caller]
fn fault(text: &str) -> DeckFault {
    match read_text(text) {
        Err(MeshError::Deck { fault, .. }) => fault,
        other => panic!("expected a fault, got {other:?}"),
    }
}

fn ids(labels: &[usize]) -> Vec<FeNodeId> {
    labels.iter().map(|i| FeNodeId::from_index(*i)).collect()
}

#[test]
fn every_keyword_is_read() {
    let deck = read_text(DECK).unwrap();
    assert_eq!(deck.node_labels, [10, 20, 30, 40, 50, 60, 70, 80, 90, 100]);
    assert_eq!(
        (deck.element_labels.as_slice(), deck.unused_node_labels.as_slice()),
        (&[7][..], &[999][..])
    );
    assert_eq!(deck.mesh.position(FeNodeId(2)), nalgebra::Point3::new(0.0, 1.0, 0.0));
    assert_eq!(deck.node_sets["BASE"], ids(&[0, 1, 2, 4, 5, 6]));
    assert_eq!(deck.node_sets["BOTH"], ids(&[0, 1, 2, 3, 4, 5, 6]));
    assert_eq!(deck.node_sets["ALL"].len(), 10);
    assert_eq!(deck.fixed_nodes, deck.node_sets["BASE"]);
    let material = deck.material.unwrap();
    assert_eq!((material.youngs_modulus_pa, material.poissons_ratio), (1.7e9, 0.394));
    assert_eq!(material.density_kg_m3, Some(930.0));
    assert!(deck.face_tractions.is_empty());

    // 12 Pa push the slanted face of area √3/2 inwards: −(1, 1, 1) · 12 / 2 in all
    let total: Vector3<f64> = deck.nodal_forces.iter().map(|(_, force)| force).sum();
    let point = Vector3::new(10.0, 0.0, -15.0);
    assert!((total - point - Vector3::repeat(-6.0)).norm() < 1e-12, "{total}");
    // on a flat face corners carry nothing and each mid-side node a third
    for (node, force) in &deck.nodal_forces {
        let expected = match node.0 {
            3 => point,
            5 | 8 | 9 => Vector3::repeat(-2.0),
            _ => Vector3::zeros(),
        };
        assert!((force - expected).norm() < 1e-12, "{node:?}: {force}");
    }
}

#[test]
fn pressure_faces_have_calculix_numbers() {
    // P1 1-2-3, P2 1-4-2, P3 2-4-3, P4 3-4-1: outward normals −z, −y, (1, 1, 1)/√3, −x
    let pushes = [
        ("P1", Vector3::new(0.0, 0.0, 6.0)),
        ("P2", Vector3::new(0.0, 6.0, 0.0)),
        ("P3", Vector3::repeat(-6.0)),
        ("P4", Vector3::new(6.0, 0.0, 0.0)),
    ];
    for (face, expected) in pushes {
        let text = DECK.replace("40, 1, 10.\n40, 3, -15.\n", "").replace("P3", face);
        let deck = read_text(&text).unwrap();
        let total: Vector3<f64> = deck.nodal_forces.iter().map(|(_, force)| force).sum();
        assert!((total - expected).norm() < 1e-12, "{face}: {total}");
    }
}

#[test]
fn what_would_change_the_model_is_refused() {
    let with = |extra: &str| DECK.replace("*STEP", &format!("{extra}\n*STEP"));
    for extra in [
        "*INCLUDE, INPUT=more.inp",
        "*EQUATION\n2\n10,1,1.,20,1,-1.",
        "*TIE, NAME=t\na, b",
        "*INITIAL CONDITIONS, TYPE=TEMPERATURE\nall, 20.",
        "*TRANSFORM, NSET=all\n0,1,0,1,0,0",
        "*ELEMENT, TYPE=C3D4\n8, 10, 20, 30, 40",
        "*BOUNDARY, AMPLITUDE=ramp\n40, 1, 3",
        "*BOUNDARY\n40, 1, 3, 0.001",
        "*MATERIAL, NAME=x\n*ELASTIC, TYPE=ENGINEERING CONSTANTS\n1.,1.,1.,0.,0.,0.,1.,1.",
    ] {
        let found = fault(&with(extra));
        assert!(matches!(found, DeckFault::Unsupported { .. }), "{extra}: {found}");
        assert!(found.to_string().starts_with("line 3"), "{extra}: {found}");
    }
    for (from, to) in [
        ("*STEP\n", "*STEP, NLGEOM\n"),
        ("*DLOAD\nloaded, P3, 12.", "*DLOAD\nloaded, GRAV, 9.81, 0., -1., 0."),
        ("*CLOAD\n", "*CLOAD, FOLLOWER\n"),
        ("*END STEP\n", "*END STEP\n*STEP\n*END STEP\n"),
    ] {
        let found = fault(&DECK.replace(from, to));
        assert!(matches!(found, DeckFault::Unsupported { .. }), "{to}: {found}");
    }
}

#[test]
fn faults_name_line_and_cause() {
    let found = fault(&DECK.replace("base, 3, 3\n", ""));
    let expected = DeckFault::PartialSupport { n_nodes: 6, first_node: 10, held: "x, y".into() };
    assert_eq!(found, expected);

    let found = fault(&DECK.replace("20, 1.0, 0.", "20, 1.0x, 0."));
    assert_eq!(found.to_string(), "line 6: expected a number in field 2, found `1.0x`");
    let found = fault(&DECK.replace("20, 1.0, 0.", "20, inf, 0."));
    assert_eq!(found.to_string(), "line 6: expected a finite number, found `inf`");
    let found = fault(&DECK.replace("20, 1.0", "10, 1.0"));
    assert_eq!(found, DeckFault::Duplicate { line: 6, kind: "node", name: "10".into() });
    let found = fault(&DECK.replace("7, 10, 20", "7, 11, 20"));
    assert_eq!(found, DeckFault::Undefined { line: 18, kind: "node", name: "11".into() });
    let found = fault(&DECK.replace("Base, 1, 2", "Foot, 1, 2"));
    assert_eq!(found, DeckFault::Undefined { line: 36, kind: "node set", name: "FOOT".into() });
    let found = fault(&DECK.replace("40, 3, -15.", "40, 1, -15."));
    assert!(
        matches!(found, DeckFault::Duplicate { line: 42, kind: "force on node", .. }),
        "{found}"
    );
    let found = fault(&DECK.replace("40, 1, 10.", "999, 1, 10."));
    assert_eq!(found, DeckFault::ForceOnUnusedNode { line: 41, node: 999 });
    let found = fault(&DECK.replace("7, 10, 20, 30", "7, 10, 30, 20"));
    assert!(found.to_string().contains("element number 7 in the deck"), "{found}");
    let found = fault(&DECK.replace(
        "*SOLID SECTION",
        "*MATERIAL, NAME=other\n*SOLID SECTION, ELSET=solid, MATERIAL=OTHER\n*SOLID SECTION",
    ));
    assert_eq!(found, DeckFault::SeveralMaterials { found: 2 });
}

/// A deck with a step that is cut anywhere is refused, whatever line it ends on; before the first
/// element is complete there is no mesh either.
#[test]
fn a_deck_cut_short_is_refused() {
    let lines: Vec<_> = DECK.lines().collect();
    let step = lines.iter().position(|line| *line == "*STEP").unwrap();
    for n in (0..19).chain(step + 1..lines.len() - 1) {
        let found = fault(&(lines[..n].join("\n") + "\n"));
        println!("{n}: {found}");
    }
    let found = fault(&lines[..18].join("\n"));
    let expected = "line 18: the deck ends where an element number and ten nodes is expected, \
                    6 numbers: it is cut short";
    assert_eq!(found.to_string(), expected);
}

#[test]
fn the_decompressed_size_is_bounded() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.inp.gz");
    let mut encoder = flate2::write::GzEncoder::new(
        fs::File::create(&path).unwrap(),
        flate2::Compression::best(),
    );
    encoder.write_all(DECK.as_bytes()).unwrap();
    encoder.write_all(&b"** padding\n".repeat(100_000)).unwrap();
    encoder.finish().unwrap();
    assert!(read_deck(&path).is_ok());
    let found = read_deck_with(&path, &DeckParams { max_bytes: 1000, ..DeckParams::default() });
    let Err(MeshError::Deck { fault, .. }) = found else { panic!("{found:?}") };
    assert_eq!(fault, DeckFault::TooLong { max_bytes: 1000 });

    let whole = fs::read(&path).unwrap();
    fs::write(&path, &whole[..whole.len() - 9]).unwrap();
    assert!(matches!(read_deck(&path), Err(MeshError::Io { .. })));
    let named = read_deck(&folder.path().join("deck.stl"));
    assert!(matches!(named, Err(MeshError::Deck { fault: DeckFault::FileName { .. }, .. })));
}

/// CalculiX's own test beam: C3D10, held in some directions only, which is said and not dropped.
#[test]
fn calculix_beam_s_partial_supports_are_refused() {
    let Some(path) = shared("fe/calculix/beam10p.inp") else { return };
    let text = fs::read_to_string(&path).unwrap();
    let expected = DeckFault::PartialSupport { n_nodes: 8, first_node: 2, held: "z".into() };
    let found = fault(&text);
    println!("{found}");
    assert!(matches!(found, DeckFault::PartialSupport { .. }), "{found} {expected}");
    let held = text.replace("1,1,2\n3,1,1\nFIX,3,3", "FIX,1,3");
    let deck = read_text(&held).unwrap();
    assert_eq!(deck.fixed_nodes.len(), 9);
    assert_eq!(deck.nodal_forces.len(), 9);
    let volume: f64 = (0..deck.mesh.elements().len())
        .map(|e| hapdef_mesh::tet10::volume(&deck.mesh.element_positions(e)))
        .sum();
    assert!((volume - 8.0).abs() < 1e-12, "{volume}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// A damaged deck gives a deck or an error, never a panic.
    #[test]
    fn damage_never_panics(place in 0..DECK.len(), byte in any::<u8>(), cut in any::<bool>()) {
        let mut bytes = DECK.as_bytes().to_vec();
        bytes[place] = byte;
        if cut {
            bytes.truncate(place);
        }
        for reading in [DeckReading::Whole, DeckReading::Supports, DeckReading::Mesh] {
            let _ = read_for(reading, &String::from_utf8_lossy(&bytes));
        }
    }
}
