//! `hapdef deck` on a bar of one element that is pulled at its tip.

use std::fs;
use std::process::Command;

pub(crate) const BAR: &str = "\
*NODE
1, 0, 0, 0
2, 1, 0, 0
3, 0, 1, 0
4, 0, 0, 1
5, 0.5, 0, 0
6, 0.5, 0.5, 0
7, 0, 0.5, 0
8, 0, 0, 0.5
9, 0.5, 0, 0.5
10, 0, 0.5, 0.5
*ELEMENT, TYPE=C3D10, ELSET=ALL
1, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10
*NSET, NSET=FIXED
1, 2, 3, 5, 6, 7
*MATERIAL, NAME=M
*ELASTIC
2e9, 0.3
*DENSITY
1100
*SOLID SECTION, ELSET=ALL, MATERIAL=M
*BOUNDARY
FIXED, 1, 3
*STEP
*STATIC
*CLOAD
4, 3, 1000
*END STEP
";

#[test]
fn the_displacement_is_written_for_paraview() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("bar.inp"), BAR).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_hapdef"))
        .args(["deck", "bar.inp", "--vtu", "bar.vtu"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{error}");
    let vtu = fs::read_to_string(folder.path().join("bar.vtu")).unwrap();
    let document = roxmltree::Document::parse(&vtu).unwrap();
    let piece = document.descendants().find(|n| n.has_tag_name("Piece"));
    assert_eq!(piece.unwrap().attribute("NumberOfPoints"), Some("10"));
    let field =
        document.descendants().find(|n| n.attribute("Name") == Some("displacement_m")).unwrap();
    assert_eq!(field.attribute("NumberOfComponents"), Some("3"));
}
