//! ANSYS decks: what is read, what is refused. The authors' own decks are in `authors_limb.rs`.

use std::fs;

use hapdef_mesh::{DeckFault, FeNodeId, MeshError, SolidDeck, read_deck};
use nalgebra::Vector3;
use proptest::prelude::*;

/// One tetrahedron in the manner of Workbench; a surface load in axes turned by 90° about z.
const DECK: &str = "/batch
/title,one = tetrahedron
/units,MKS
/wb,file,start              ! generated
/prep7
/com, nodes, with $ and = in a comment
nblock,3
(1i9,3e20.9e3)
        1    0.000000000E+000    0.000000000E+000    0.000000000E+000
        2    1.000000000E+000    0.000000000E+000    0.000000000E+000
        3    0.000000000E+000    1.000000000E+000    0.000000000E+000
        4    0.000000000E+000    0.000000000E+000    1.000000000E+000
        5    5.000000000E-001
        6    5.000000000E-001    5.000000000E-001
        7    0.000000000E+000    5.000000000E-001
        8    0.000000000E+000    0.000000000E+000    5.000000000E-001
        9    5.000000000E-001    0.000000000E+000    5.000000000E-001
       10    0.000000000E+000    5.000000000E-001    5.000000000E-001
-1
et,1,187
eblock,19,solid,,1
(19i9)
        1        1        1        1        0        0        0        0       10        0       21        1        2        3        4        5        6        7        8
        9       10
-1
MP,DENS,1,930,\t! kg m^-3
MP,EX,1,1700000000,
MP,NUXY,1,0.394,
MP,ALPX,1,1e-5
CMBLOCK,FOOT  ,NODE,        4
(8i10)
         1        -3         5        -7
cmsel,s,FOOT
d,all,all
nsel,all
local,12,0,0.,0.,0.,90.,0.,0.
csys,0
et,2,154
eblock,10,,,1
(15i9)
       22        2        1        1       12        1        2        4        4        5        9        4        8
-1
keyop,2,2,1
keyop,2,7,1
keyop,2,11,2
*DIM,_px,TABLE,2,1,1,TIME,
_px(1,0,1) = 0.
_px(2,0,1) = 2.
_px(1,1,1) = 0.
_px(2,1,1) = 6.
force=-15.
fini
/solu
antype,0
f,4,fz,%force%
f,4,fx,10
esel,s,type,,2
nsle
sfe,all,1,pres,1,%_px%
nsel,all
esel,all
time,1.
*if,ANSINTER_,ne,0,then
/eof
*if,x,eq,1,then
*endif
ce,1,0,1,ux,1
*endif
solve
fini
/post1
anything,goes,here
fini
/wb,file,end
";

fn read_text(text: &str) -> Result<SolidDeck, MeshError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.dat");
    fs::write(&path, text).unwrap();
    read_deck(&path)
}

#[track_caller]
fn fault(text: &str) -> DeckFault {
    match read_text(text) {
        Err(MeshError::Deck { fault, .. }) => fault,
        other => panic!("expected a fault, got {other:?}"),
    }
}

#[test]
fn a_workbench_deck_is_read() {
    let deck = read_text(DECK).unwrap();
    assert_eq!(deck.node_labels, (1..=10).collect::<Vec<_>>());
    assert_eq!(deck.element_labels, [21]);
    let foot: Vec<_> = [0, 1, 2, 4, 5, 6].map(FeNodeId::from_index).to_vec();
    assert_eq!((&deck.node_sets["FOOT"], &deck.fixed_nodes), (&foot, &foot));
    assert_eq!(deck.nodal_forces, [(FeNodeId(3), Vector3::new(10.0, 0.0, -15.0))]);
    let material = deck.material.unwrap();
    assert_eq!((material.youngs_modulus_pa, material.poissons_ratio), (1.7e9, 0.394));
    // 3 Pa half way through the table, along the local x axis, which is the global y axis
    let [load] = deck.face_tractions.as_slice() else { panic!("{:?}", deck.face_tractions) };
    assert!((load.traction_pa - Vector3::new(0.0, 3.0, 0.0)).norm() < 1e-15);
    assert_eq!(load.nodes.map(|node| node.0), [0, 1, 3, 4, 8, 7]);
}

/// The layout of CDWRITE: three integer columns, counts, Fortran exponents with D, MPDATA, plain
/// numbers as values, the old end mark of an nblock.
#[test]
fn a_cdb_archive_is_read() {
    let start = DECK.find("nblock").unwrap();
    let end = DECK.find("et,1,187").unwrap();
    let mut nodes = String::from("nblock,6,solid,        10,        10\n(3i8,6e16.9)\n");
    let corners = [[0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 2]];
    let mids = [[1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]];
    for (i, p) in corners.iter().chain(&mids).enumerate() {
        let [x, y, z] = p.map(|c| format!("{:.9}D+00", f64::from(c) / 2.0));
        nodes += &format!("{:8}{:8}{:8}{x:>16}{y:>16}{z:>16}\n", i + 1, 0, 0);
    }
    nodes += "N,R5.3,LOC,       -1,\n";
    let text = format!("{}{}{}", &DECK[..start], nodes, &DECK[end..])
        .replace(
            "MP,EX,1,1700000000,",
            "MPTEMP,R5.0, 1, 1,  0.0    ,\nMPDATA,R5.0, 1,EX  , 1, 1, 1700000000.    ,",
        )
        .replace("d,all,all", "D,FOOT,UX,0.0,0.0,,,UY,UZ");
    let (expected, found) = (read_text(DECK).unwrap(), read_text(&text).unwrap());
    assert_eq!(found, expected);
}

#[test]
fn what_would_change_the_model_is_refused() {
    for (from, to) in [
        ("fini\n/solu", "ce,1,0,1,ux,1,2,ux,-1\nfini\n/solu"),
        ("fini\n/solu", "cp,1,ux,1,2\nfini\n/solu"),
        ("fini\n/solu", "nrotat,all\nfini\n/solu"),
        ("fini\n/solu", "nlgeom,on\nfini\n/solu"),
        ("fini\n/solu", "acel,0,9.81,0\nfini\n/solu"),
        ("fini\n/solu", "numoff,node,100\nfini\n/solu"),
        ("fini\n/solu", "/input,more,dat\nfini\n/solu"),
        ("*if,ANSINTER_,ne,0,then", "*if,x,eq,0,then"),
        ("antype,0", "antype,modal"),
        ("/units,MKS", "/units,BIN"),
        ("et,1,187", "et,1,186"),
        ("et,1,187", "et,1,187\nkeyopt,1,6,1"),
        ("MP,ALPX,1,1e-5", "MP,EY,1,1e9"),
        ("MP,EX,1,1700000000,", "MP,EX,1,1700000000,1e6"),
        ("keyop,2,2,1\n", ""),
        ("keyop,2,11,2\n", ""),
        ("sfe,all,1,pres", "sfe,all,4,pres"),
        ("sfe,all,1,pres,1,%_px%", "sfe,21,1,pres,1,3."),
        ("d,all,all", "d,all,all,0.001"),
        ("nsel,all\nlocal", "nsel,s,loc,x,0\nd,all,all\nlocal"),
        ("local,12,0,", "local,12,1,"),
        ("\nsolve\n", "\nsolve\nf,4,fx,20\nsolve\n"),
        ("        4        4        5", "        4        3        5"),
        (
            "    1.000000000E+000\n        5",
            "    1.000000000E+000    0.000000000E+000    0.000000000E+000    3.000000000E+001\n        5",
        ),
    ] {
        let mut text = DECK.replace(from, to);
        assert_ne!(text, DECK, "{from}");
        if to.contains("3.000000000E+001") {
            text = text.replace("3e20.9e3", "6e20.9e3");
        }
        let found = fault(&text);
        println!("{found}");
        assert!(matches!(found, DeckFault::Unsupported { .. }), "{to}: {found}");
        assert!(!found.to_string().starts_with("line 0"), "{to}: {found}");
    }
}

#[test]
fn faults_name_line_and_cause() {
    let found = fault(&DECK.replace("d,all,all", "d,all,ux"));
    let expected = DeckFault::PartialSupport { n_nodes: 6, first_node: 1, held: "x".into() };
    assert_eq!(found, expected);
    let found = fault(&DECK.replace("f,4,fx,10", "f,4,fx,%wind%"));
    assert!(matches!(&found, DeckFault::Undefined { name, .. } if name == "wind"), "{found}");
    let found = fault(&DECK.replace("_px(2,1,1) = 6.\n", ""));
    assert!(found.to_string().contains("table _px filled"), "{found}");
    let found = fault(&DECK.replace("f,4,fx", "f,HEAD,fx"));
    assert!(matches!(&found, DeckFault::Undefined { name, .. } if name == "HEAD"), "{found}");
    let found = fault(&DECK.replace("eblock,19,solid,,1", "eblock,19,solid,,2"));
    assert_eq!(found.to_string(), "line 25: expected 2 elements, as the block announces, found 1");
    let found = fault(&DECK.replace("(1i9,3e20.9e3)", "(free)"));
    assert!(matches!(found, DeckFault::Unexpected { line: 8, .. }), "{found}");
    let found = fault(&DECK.replace(
        "        1        2        4        4        5",
        "        1        2        6        6        5",
    ));
    assert_eq!(found, DeckFault::NotABoundaryFace { line: 41, corners: [1, 2, 6] });
    let found = fault(&DECK.replace("5.000000000E-001\n        6", "5.00000000xE-001\n        6"));
    assert!(matches!(found, DeckFault::Unexpected { line: 13, .. }), "{found}");
}

/// Workbench frames its decks, so that every cut is noticed.
#[test]
fn a_deck_cut_short_is_refused() {
    let lines: Vec<_> = DECK.lines().collect();
    for n in 0..lines.len() - 1 {
        let found = fault(&lines[..n].join("\n"));
        println!("{n}: {found}");
    }
    let found = fault(&lines[..12].join("\n"));
    let expected = "line 12: the deck ends where -1 at the end of the block is expected, \
                    after 4 lines of nodes: it is cut short";
    assert_eq!(found.to_string(), expected);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// A damaged deck gives a deck or an error, never a panic.
    #[test]
    fn damage_never_panics(place in 0..DECK.len(), byte in any::<u8>(), cut in any::<bool>()) {
        let mut bytes = DECK.as_bytes().to_vec();
        bytes[place] = byte;
        if cut {
            bytes.remove(place);
        }
        let _ = read_text(&String::from_utf8_lossy(&bytes));
    }
}
