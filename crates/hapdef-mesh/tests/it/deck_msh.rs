//! gmsh's `.msh`, formats 2.2 and 4.1, in words and in bytes.

use std::fs;

use hapdef_mesh::{DeckParams, DeckReading, MeshError, SolidDeck, read_deck_with, tet10};
use proptest::prelude::*;

const PLACES: [[f64; 3]; 10] = [
    [0.0, 0.0, 0.0],
    [2.0, 0.0, 0.0],
    [0.0, 2.0, 0.0],
    [0.0, 0.0, 2.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.0, 1.0, 1.0],
    [1.0, 0.0, 1.0],
];

fn read(bytes: &[u8]) -> Result<SolidDeck, MeshError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("limb.msh");
    fs::write(&path, bytes).unwrap();
    read_deck_with(&path, &DeckParams { reading: DeckReading::Mesh, ..DeckParams::default() })
}

/// A file as it is written, number by number: words with spaces between or bytes.
struct Writer {
    bytes: Vec<u8>,
    is_binary: bool,
}

impl Writer {
    fn new(version: &str, is_binary: bool) -> Self {
        let mut writer = Self { bytes: Vec::new(), is_binary };
        writer.line(&format!("$MeshFormat\n{version} {} 8", u8::from(is_binary)));
        if is_binary {
            writer.ints(&[1]);
            writer.line("");
        }
        let names = "$PhysicalNames\n2\n2 5 \"mount\"\n3 6 \"limb\"\n$EndPhysicalNames";
        writer.line(&format!("$EndMeshFormat\n{names}"));
        writer
    }

    fn line(&mut self, text: &str) {
        self.bytes.extend(format!("{text}\n").as_bytes());
    }

    fn ints(&mut self, values: &[i32]) {
        self.put(values, |value| value.to_le_bytes().to_vec());
    }

    fn sizes(&mut self, values: &[u64]) {
        self.put(values, |value| value.to_le_bytes().to_vec());
    }

    fn reals(&mut self, values: &[f64]) {
        self.put(values, |value| value.to_le_bytes().to_vec());
    }

    fn put<T: ToString>(&mut self, values: &[T], bytes: impl Fn(&T) -> Vec<u8>) {
        for value in values {
            if self.is_binary {
                self.bytes.extend(bytes(value));
            } else {
                self.bytes.extend(format!("{} ", value.to_string()).as_bytes());
            }
        }
    }
}

fn version_2(is_binary: bool) -> Vec<u8> {
    let mut file = Writer::new("2.2", is_binary);
    file.line("$Nodes\n10");
    for (i, place) in PLACES.iter().enumerate() {
        file.ints(&[i as i32 + 1]);
        file.reals(place);
    }
    file.line("\n$EndNodes\n$Elements\n2");
    let head = |tag, kind| if is_binary { [kind, 1, 2, tag] } else { [tag, kind, 2, i32::MIN] };
    let mut element = |tag, kind, group, nodes: &[i32]| {
        let words = head(tag, kind);
        file.ints(if is_binary { &words } else { &words[..3] });
        file.ints(&[group, 1]);
        file.ints(nodes);
    };
    element(1, 9, 5, &[1, 3, 2, 7, 6, 5]);
    element(2, 11, 6, &[1, 2, 3, 4, 5, 6, 7, 8, 9, 10]);
    file.line("\n$EndElements");
    file.bytes
}

fn version_4(is_binary: bool) -> Vec<u8> {
    let mut file = Writer::new("4.1", is_binary);
    file.line("$Entities");
    file.sizes(&[1, 0, 1, 1]);
    file.ints(&[1]);
    file.reals(&[0.0; 3]);
    file.sizes(&[0]);
    for (tag, group, bounds) in [(7, 5, &[][..]), (1, 6, &[7])] {
        file.ints(&[tag]);
        file.reals(&[0.0; 6]);
        file.sizes(&[1]);
        file.ints(&[group]);
        file.sizes(&[bounds.len() as u64]);
        file.ints(bounds);
    }
    file.line("\n$EndEntities\n$Nodes");
    file.sizes(&[2, 10, 1, 10]);
    for (block, parametric) in [(0..4, 1), (4..10, 0)] {
        file.ints(&[2, 7, parametric]);
        file.sizes(&[block.len() as u64]);
        file.sizes(&block.clone().map(|i| i as u64 + 1).collect::<Vec<_>>());
        for i in block {
            file.reals(&PLACES[i]);
            file.reals(&[0.5; 2][..2 * parametric as usize]);
        }
    }
    file.line("\n$EndNodes\n$Elements");
    file.sizes(&[2, 2, 1, 2]);
    file.ints(&[2, 7, 9]);
    file.sizes(&[1, 1, 1, 3, 2, 7, 6, 5]);
    file.ints(&[3, 1, 11]);
    file.sizes(&[1, 2, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10]);
    file.line("\n$EndElements");
    file.bytes
}

#[test]
fn both_formats_are_read_in_words_and_in_bytes() {
    for bytes in [version_2(false), version_2(true), version_4(false), version_4(true)] {
        let deck = read(&bytes).unwrap();
        let volume = tet10::volume(&deck.mesh.element_positions(0));
        assert!((volume - 8.0 / 6.0).abs() < 1e-12, "{volume}");
        let mount: Vec<u32> = deck.node_sets["MOUNT"].iter().map(|node| node.0 + 1).collect();
        assert_eq!(mount, [1, 2, 3, 5, 6, 7]);
        assert_eq!(deck.node_sets["LIMB"].len(), 10);
        assert_eq!(deck.notes, ["elements that are no solids are passed over: 1 triangles"]);
    }
}

#[test]
fn order_1_gets_mid_edge_nodes_and_other_solids_are_refused() {
    let text = String::from_utf8(version_2(false)).unwrap();
    let linear = text.replace("2 11 2 6 1 1 2 3 4 5 6 7 8 9 10", "2 4 2 0 1 1 2 3 4");
    assert_ne!(linear, text);
    let deck = read(linear.as_bytes()).unwrap();
    assert_eq!((deck.mesh.nodes().len(), deck.node_sets.len()), (10, 1));
    // the six mid-side nodes of before belong to no element now; the mount got those of its edges
    assert_eq!((deck.unused_node_labels.len(), deck.node_sets["MOUNT"].len()), (6, 6));
    for (to, expected) in [
        ("2 5 2 6 1 1 2 3 4 5 6 7 8", "element 2: hexahedra"),
        ("2 77 2 6 1 1 2 3 4", "an element type of gmsh"),
        ("2 4 2 6 1 1 2 3 44", "node `44` is not defined"),
        ("2 4 2 6 1 1 2 3", "a whole number, found `$EndElements`"),
    ] {
        let text = text.replace("2 11 2 6 1 1 2 3 4 5 6 7 8 9 10", to);
        let found = read(text.as_bytes()).unwrap_err().to_string();
        assert!(found.contains(expected) && found.contains(": line 1"), "{to}: {found}");
    }
    for (from, to, expected) in [
        ("2.2 0 8", "4.0 0 8", "format 2.2 or 4.1"),
        ("$MeshFormat", "$Comments", "$EndComments"),
        ("2 5 \"mount\"", "two", "of a physical group"),
        ("$Nodes\n10", "$Nodes\nten", "how many follow"),
    ] {
        let found = read(text.replacen(from, to, 1).as_bytes()).unwrap_err().to_string();
        assert!(found.contains(expected), "{to}: {found}");
    }
    assert!(read(b"").unwrap_err().to_string().contains("$MeshFormat"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// A damaged file gives a mesh or an error, never a panic, and soon.
    #[test]
    fn damage_never_panics(
        place in 0.0..1.0_f64, byte in any::<u8>(), cut in any::<bool>(), which in 0..4,
    ) {
        let mut bytes = if which < 2 { version_2(which == 1) } else { version_4(which == 3) };
        let place = (place * bytes.len() as f64) as usize;
        bytes[place] = byte;
        if cut {
            bytes.truncate(place);
        }
        let _ = read(&bytes);
    }
}
