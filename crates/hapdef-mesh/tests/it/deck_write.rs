//! Writing a deck and reading it back.

use std::fs;

use hapdef_mesh::{FaceTraction, ShinParams, face_positions, read_deck, shin, tri6, write_inp};
use nalgebra::Vector3;

#[test]
fn what_is_written_reads_back() {
    let mut deck =
        shin(&ShinParams { n_bands: 1, holes: vec![], ..ShinParams::default() }).unwrap().deck;
    let third = 1.0 / 3.0;
    deck.nodal_forces = vec![(deck.node_sets["SKIN"][5], Vector3::new(third, 0.0, -1e-300))];
    let folder = tempfile::tempdir().unwrap();
    for name in ["limb.inp", "limb.inp.gz"] {
        let path = folder.path().join(name);
        write_inp(&path, &deck).unwrap();
        assert_eq!(read_deck(&path).unwrap(), deck, "{name}");
        let first = fs::read(&path).unwrap();
        write_inp(&path, &deck).unwrap();
        assert_eq!(fs::read(&path).unwrap(), first, "{name}");
    }
    let plain = fs::read_to_string(folder.path().join("limb.inp")).unwrap();
    for line in
        plain.lines().filter(|line| !line.starts_with('*') && !line.starts_with("solid limb"))
    {
        assert!(line.split(',').all(|field| field.trim().len() <= 20), "{line}");
    }
}

#[test]
fn tractions_are_written_as_their_consistent_forces() {
    let mut deck =
        shin(&ShinParams { n_bands: 1, holes: vec![], ..ShinParams::default() }).unwrap().deck;
    let face = deck.mesh.boundary().faces[17];
    let traction_pa = Vector3::new(0.0, -2e5, 1e5);
    deck.face_tractions = vec![FaceTraction { nodes: face.nodes, traction_pa }];
    let path = tempfile::tempdir().unwrap().keep().join("limb.inp");
    write_inp(&path, &deck).unwrap();
    let read = read_deck(&path).unwrap();
    fs::remove_dir_all(path.parent().unwrap()).unwrap();
    let total: Vector3<f64> = read.nodal_forces.iter().map(|(_, force)| force).sum();
    let exact = traction_pa * tri6::area(&face_positions(&deck.mesh, &face));
    assert!((total - exact).norm() < 1e-11 * exact.norm(), "{total} {exact}");
}
