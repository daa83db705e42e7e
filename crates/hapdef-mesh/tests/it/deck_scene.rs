//! What a scene reads of decks as people have them: the mesh and its sets, whatever else is there.

use std::fs;

use hapdef_mesh::{
    DeckFault, DeckParams, DeckReading, LengthUnit, MeshError, SolidDeck, deck_includes,
    read_deck_with, tet10,
};
use nalgebra::Point3;

const NODES: &str = "*NODE
1, 0., 0., 0.\n2, 2., 0., 0.\n3, 0., 2., 0.\n4, 0., 0., 2.
5, 1., 0., 0.\n6, 1., 1., 0.\n7, 0., 1., 0.\n8, 0., 0., 1.\n9, 1., 0., 1.\n10, 0., 1., 1.
";
const TET10: &str = "1, 2, 3, 4, 5, 6, 7, 8, 9, 10\n";

fn read(reading: DeckReading, name: &str, text: &str) -> Result<SolidDeck, MeshError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    read_deck_with(&path, &DeckParams { reading, ..DeckParams::default() })
}

fn inp(text: &str) -> SolidDeck {
    read(DeckReading::Mesh, "deck.inp", text).unwrap()
}

#[track_caller]
fn refused(reading: DeckReading, name: &str, text: &str) -> String {
    match read(reading, name, text) {
        Err(MeshError::Deck { fault, .. }) => fault.to_string(),
        other => panic!("expected a fault, got {other:?}"),
    }
}

fn numbers(deck: &SolidDeck, set: &str) -> Vec<u32> {
    deck.node_sets[set].iter().map(|node| deck.node_labels[node.index()]).collect()
}

fn volume(deck: &SolidDeck) -> f64 {
    let elements = 0..deck.mesh.elements().len();
    elements.map(|e| tet10::volume(&deck.mesh.element_positions(e))).sum()
}

#[test]
fn faces_and_lines_are_passed_over_and_a_group_of_faces_is_a_node_set() {
    let text = format!(
        "{NODES}*ELEMENT, type=T3D3, ELSET=Line1\n1, 1, 5, 2\n*ELEMENT, type=CPS6, ELSET=Surface7\n\
         2, 1, 3, 2, 7, 6, 5\n*ELEMENT, TYPE=C3D10, ELSET=Volume1\n3, {TET10}\
         *ELSET, ELSET=MOUNT\n2,\n*ELSET, ELSET=limb\n3,\n"
    );
    let deck = inp(&text);
    assert_eq!(numbers(&deck, "MOUNT"), [1, 2, 3, 5, 6, 7]);
    assert_eq!(deck.node_sets.keys().collect::<Vec<_>>(), ["MOUNT", "SURFACE7"]);
    assert_eq!(deck.notes, ["elements that are no solids are passed over: 1 CPS6, 1 T3D3"]);
    assert_eq!(read(DeckReading::Whole, "deck.inp", &text).unwrap(), deck);

    // a set of nodes of that name is what it says, and faces that bear load are no mesh's trimming
    let named = inp(&format!("{text}*NSET, NSET=MOUNT\n1, 2\n"));
    assert_eq!(numbers(&named, "MOUNT"), [1, 2]);
    let bearing = format!("{text}*SOLID SECTION, ELSET=Surface7, MATERIAL=M\n");
    assert!(refused(DeckReading::Whole, "deck.inp", &bearing).contains("no solids"));
    assert_eq!(inp(&bearing).mesh, deck.mesh);
    let only_faces = text.replace("C3D10", "S3").replace(TET10, "1, 2, 3\n");
    let found = refused(DeckReading::Mesh, "deck.inp", &only_faces);
    assert!(found.contains("1 CPS6, 1 S3, 1 T3D3 only"), "{found}");
    let bricks = text.replace("C3D10", "C3D20");
    assert!(refused(DeckReading::Mesh, "deck.inp", &bricks).contains("TYPE=C3D20"));
}

#[test]
fn other_formulations_are_read_for_their_geometry() {
    let text = format!("{NODES}*ELEMENT, TYPE=C3D10MH\n1, {TET10}");
    let deck = inp(&text);
    assert_eq!(deck.notes, ["C3D10MH is read as C3D10, for its geometry"]);
    assert!((volume(&deck) - 8.0 / 6.0).abs() < 1e-12);
    assert!(refused(DeckReading::Whole, "deck.inp", &text).contains("C3D10MH"));
}

/// Two tetrahedra that share a face get nine edges between five corners; the set's edges get its
/// nodes, and where a ten-node neighbour has a mid-side node, curved or not, that is taken.
#[test]
fn four_node_tetrahedra_get_mid_edge_nodes() {
    let corners =
        "*NODE\n1, 0., 0., 0.\n2, 2., 0., 0.\n3, 0., 2., 0.\n4, 0., 0., 2.\n11, 2., 2., 2.\n";
    let text = format!(
        "\u{feff}{corners}*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 4\n2, 2, 3, 4, 11\n*NSET, NSET=base\n1, 2, 3\n\
         *BOUNDARY\nbase, 1, 3\n"
    );
    let deck = inp(&text);
    assert_eq!((deck.mesh.nodes().len(), deck.mesh.elements().len()), (5 + 9, 2));
    assert_eq!(numbers(&deck, "BASE").len(), 6);
    assert_eq!(deck.fixed_nodes, deck.node_sets["BASE"]);
    assert!(deck.node_labels[5..].iter().all(|label| *label > 11));
    for nodes in deck.mesh.elements() {
        for (mid, [a, b]) in nodes[4..].iter().zip(tet10::TET10_EDGES) {
            let [a, b] = [nodes[a], nodes[b]].map(|node| deck.mesh.position(node));
            assert_eq!(deck.mesh.position(*mid), nalgebra::center(&a, &b));
        }
    }
    assert_eq!(
        deck.notes,
        ["2 four-node tetrahedra became ten-node ones by 9 straight mid-edge nodes"]
    );
    assert!(refused(DeckReading::Whole, "deck.inp", &text).contains("C3D4"));

    let curved = NODES.replace("6, 1., 1., 0.", "6, 1.1, 1.1, 0.");
    let mixed = format!(
        "{curved}11, 2., 2., 2.\n*ELEMENT, TYPE=C3D10\n1, {TET10}*ELEMENT, TYPE=C3D4\n2, 2, 3, 4, 11\n"
    );
    let deck = inp(&mixed);
    assert_eq!(deck.mesh.nodes().len(), 11 + 3);
    let shared = deck.mesh.elements()[1][4];
    assert_eq!(deck.mesh.position(shared), Point3::new(1.1, 1.1, 0.0));
}

#[test]
fn a_part_and_its_instance_are_one_mesh() {
    let text = format!(
        "*PART, NAME=cat\n{NODES}*ELEMENT, TYPE=C3D10\n1, {TET10}*NSET, NSET=foot, INTERNAL\n1, 2\n*END PART\n\
         *ASSEMBLY, NAME=a\n*INSTANCE, NAME=cat-1, PART=cat\n1., 0., 0.\n1., 0., 0., 1., 0., 1., 90.\n\
         *END INSTANCE\n*NSET, NSET=tip, INSTANCE=cat-1\n4,\n*NODE\n1, 9., 9., 9.\n*NSET, NSET=point\n1,\n\
         *END ASSEMBLY\n*BOUNDARY\ncat-1.foot, ENCASTRE\n"
    );
    let deck = inp(&text);
    assert_eq!((numbers(&deck, "FOOT"), numbers(&deck, "TIP")), (vec![1, 2], vec![4]));
    assert_eq!(deck.fixed_nodes, deck.node_sets["FOOT"]);
    // node 2, at (3, 0, 0) after the shift, turned by 90° about the line x = 1, y = 0
    assert!(
        (deck.mesh.position(deck.node_sets["FOOT"][1]) - Point3::new(1.0, 2.0, 0.0)).norm() < 1e-12
    );
    assert!(
        deck.notes[0].contains("*NODE of the assembly, *NSET of the assembly"),
        "{:?}",
        deck.notes
    );
    let whole = refused(DeckReading::Whole, "deck.inp", &text);
    assert!(whole.contains("*NODE of the assembly"), "{whole}");
    let twice = text.replace("*END ASSEMBLY", "*INSTANCE, NAME=cat-2, PART=cat\n*END ASSEMBLY");
    let twice = refused(DeckReading::Mesh, "deck.inp", &twice);
    assert!(twice.contains("a second *INSTANCE"), "{twice}");
}

#[test]
fn loads_are_passed_over_for_a_scene_and_judged_for_the_deck() {
    let text = format!(
        "{NODES}*ELEMENT, TYPE=C3D10\n1, {TET10}*AMPLITUDE, NAME=ramp\n0., 0., 1., 1.\n*TIE, NAME=t\na, b\n\
         *MATERIAL, NAME=rubber\n*HYPERELASTIC, MOONEY-RIVLIN\n1., 1., 1.\n*BOUNDARY\n1, 1, 3\n2, 3, 3\n\
         *STEP, NLGEOM\n*CLOAD, AMPLITUDE=ramp\n4, 1, 1.\n*BOUNDARY\n3, 1, 1, 0.1\n*END STEP\n"
    );
    let deck = inp(&text);
    assert_eq!(
        deck.notes,
        [
            "what a scene has of its own is passed over: *AMPLITUDE, *BOUNDARY, *CLOAD, \
             *HYPERELASTIC, *TIE",
            "supports in some directions only, at 1 nodes, are passed over",
        ]
    );
    assert_eq!((deck.fixed_nodes.len(), deck.nodal_forces.len(), deck.material), (1, 0, None));
    assert!(refused(DeckReading::Whole, "deck.inp", &text).contains("*AMPLITUDE"));
    // a scene that is mounted where the deck is wants its supports
    let found = refused(DeckReading::Supports, "deck.inp", &text);
    assert!(found.contains("displacement 0.1"), "{found}");
    // what makes the mesh is never passed over
    let made = format!("*NGEN\n1, 2, 1\n{text}");
    assert!(refused(DeckReading::Mesh, "deck.inp", &made).contains("*NGEN"));
}

#[test]
fn included_files_lie_beside_the_deck() {
    let folder = tempfile::tempdir().unwrap();
    let deck = folder.path().join("deck.inp");
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("Mesh.inp", &format!("{NODES}*ELEMENT, TYPE=C3D10\n1, {TET10}"));
    write("deck.inp", "*HEADING\nwhole\n*INCLUDE, INPUT=Mesh.inp\n*BOUNDARY\n1, 1, 3\n");
    let read = |reading| read_deck_with(&deck, &DeckParams { reading, ..DeckParams::default() });
    assert_eq!(read(DeckReading::Whole).unwrap().mesh.nodes().len(), 10);
    let included = deck_includes(&deck, 1 << 20).unwrap();
    assert_eq!(included, [folder.path().join("Mesh.inp").canonicalize().unwrap()]);
    assert!(
        read_deck_with(&deck, &DeckParams { max_bytes: 200, ..DeckParams::default() }).is_err()
    );

    write("Mesh.inp", "*NODE\n1, x\n");
    let found = read(DeckReading::Mesh).unwrap_err().to_string();
    assert!(
        found.ends_with(
            "in the included file Mesh.inp: line 2: expected a number in field 2, found `x`"
        ),
        "{found}"
    );
    write("Mesh.inp", "*INCLUDE, INPUT=deck.inp\n");
    let found = read(DeckReading::Mesh).unwrap_err().to_string();
    assert!(found.contains("more than eight deep"), "{found}");
    assert!(deck_includes(&deck, 1 << 20).unwrap().len() <= 8);
    for file in ["../Mesh.inp", "/etc/passwd", "absent.inp", "."] {
        write("deck.inp", &format!("*INCLUDE, INPUT={file}\n"));
        let found = read(DeckReading::Mesh).unwrap_err().to_string();
        assert!(found.contains("*INCLUDE, INPUT="), "{file}: {found}");
    }
}

/// CDWRITE's archive of one tetrahedron in millimetres, with a shell element on it.
const CDB: &str = "/PREP7
ANTYPE,2,NEW
/units,MPA
ETBLOCK,        2,        2
(2i9,19a9)
        1      187        0        0        0        0        0        0        0        0        0        0        0        0        0        0        0        0        0        0        0
        2      181        0        0        2        0        0        0        0        0        0        0        0        0        0        0        0        0        0        0        0
       -1
NBLOCK,6,SOLID,        10,        12
(1i7,2i9,3e16.9)
      1        0        0
      2        0        0 2.000000000E+00
      3        0        0 0.000000000E+00 2.000000000E+00
      4        0        0 0.000000000E+00 0.000000000E+00 2.000000000E+00
      5        0        0 1.000000000E+00
      6        0        0 1.000000000E+00 1.000000000E+00
      7        0        0 0.000000000E+00 1.000000000E+00
      8        0        0 0.000000000E+00 0.000000000E+00 1.000000000E+00
      9        0        0 1.000000000E+00 0.000000000E+00 1.000000000E+00
     10        0        0 0.000000000E+00 1.000000000E+00 1.000000000E+00
N,R5.3,LOC,       -1,
N,R5.1,LOC,       -1,
LOCAL,R5.0,LOC,395,1,0.004,0.0005,0.004
LOCAL,R5.0,ANG,395,1,-0,0,-0
LOCAL,R5.0,PRM,395,1,1.0,1.0
RLBLOCK,1,1,12,7
(2i8,6g16.9)
       1       6           0.375
EBLOCK,19,SOLID,,2
(19i7)
      1      1      1      1      0      0      0      0     10      0      1      1      2      3      4      5      6      7      8
      9     10
      1      2      1      1      0      0      0      0      4      0      2      1      2      3      3
CMBLOCK,FOOT    ,NODE,       2
(8i10)
         1        -3
MP,EX,1,72000
MP,NUXY,1,0.33
MP,DENS,1,2.57e-9
MP,RSVX,1,1.7e-4
MP,UVID,1,6a302e30-541f
MODOPT,LANB,20
/SOLU
SOLVE
FINISH
";

#[test]
fn an_ansys_archive_is_read_for_a_scene() {
    let deck = read(DeckReading::Mesh, "deck.cdb", CDB).unwrap();
    assert_eq!(deck.unit, Some(LengthUnit::Millimetre));
    assert!((volume(&deck) - 8e-9 / 6.0).abs() < 1e-20, "{}", volume(&deck));
    let material = deck.material.unwrap();
    assert_eq!((material.youngs_modulus_pa, material.poissons_ratio), (7.2e10, 0.33));
    assert!((material.density_kg_m3.unwrap() - 2570.0).abs() < 1e-9);
    assert_eq!(numbers(&deck, "FOOT"), [1, 2, 3]);
    assert_eq!(
        deck.notes,
        [
            "the block of nodes that ends in line 21 announces 12 and has 10",
            "elements that are no solids are passed over: 1 of type 181",
            "what a scene has of its own is passed over: ANTY, MODO, RLBL",
        ]
    );
    let whole = refused(DeckReading::Whole, "deck.cdb", CDB);
    assert!(whole.contains("ANTYPE,2,NEW"), "{whole}");
}

#[test]
fn what_an_ansys_mesh_needs_is_never_passed_over() {
    for (from, to, expected) in [
        ("/units,MPA", "/units,BIN", "/units"),
        ("MODOPT,LANB,20", "NUMMRG,NODE", "NUMMRG"),
        ("MODOPT,LANB,20", "/INPUT,more,dat", "/INPUT"),
        ("MODOPT,LANB,20", "N,11,0,0,0", "N,11"),
        ("        1      187", "        1      185", "185"),
        ("EBLOCK,19,SOLID,,2", "EBLOCK,19,SOLID,,3", "3 elements, as the block announces"),
        ("(1i7,2i9,3e16.9)", "(1i7,3e16.9,2i9)", "a format"),
        ("(1i7,2i9,3e16.9)", "(1i7,99i9,3e16.9)", "a format"),
    ] {
        let text = CDB.replacen(from, to, 1);
        assert_ne!(text, CDB);
        let found = refused(DeckReading::Mesh, "deck.cdb", &text);
        assert!(found.contains(expected), "{to}: {found}");
    }
}

/// With Workbench's marks and no end of blocks but their announced count.
#[test]
fn a_block_ends_at_its_announced_count() {
    let text = CDB
        .replace("N,R5.3,LOC,       -1,\nN,R5.1,LOC,       -1,\n", "")
        .replace(",        12\n", ",        10\n")
        .replace("LOCAL,R5.0,LOC", "/wb,elem,start\nLOCAL,R5.0,LOC");
    let deck = read(DeckReading::Mesh, "deck.dat", &text).unwrap();
    assert_eq!(deck.mesh, read(DeckReading::Mesh, "deck.cdb", CDB).unwrap().mesh);
    let cut = &CDB[..CDB.find("      7        0        0 0.0").unwrap()];
    assert!(refused(DeckReading::Mesh, "deck.cdb", cut).contains("cut short"));
}

#[test]
fn a_body_of_its_own_is_counted() {
    let far = "*NODE\n21, 9., 0., 0.\n22, 11., 0., 0.\n23, 9., 2., 0.\n24, 9., 0., 2.\n";
    let text = format!(
        "{NODES}{far}*ELEMENT, TYPE=C3D10\n1, {TET10}*ELEMENT, TYPE=C3D4\n2, 21, 22, 23, 24\n"
    );
    let bodies = inp(&text).mesh.bodies();
    assert_eq!(bodies.iter().map(|b| b.elements.as_slice()).collect::<Vec<_>>(), [[0], [1]]);
    assert_eq!(bodies[1].bounding_box.centre(), Point3::new(10.0, 1.0, 1.0));
    assert_eq!(inp(&format!("{NODES}*ELEMENT, TYPE=C3D10\n1, {TET10}")).mesh.bodies().len(), 1);
}

#[test]
fn faults_of_included_files_have_their_own_variant() {
    let fault = DeckFault::Included {
        file: "a.inp".into(),
        fault: Box::new(DeckFault::SeveralMaterials { found: 2 }),
    };
    assert!(fault.to_string().starts_with("in the included file a.inp: "));
}
