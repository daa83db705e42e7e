//! `hapdef mesh`, with programs that stand for gmsh.

use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output};

use hapdef_mesh::{SurfaceMesh, write_stl};
use nalgebra::Point3;

/// A box of 40 by 30 by 160 mm.
fn closed() -> SurfaceMesh {
    let corner = |i: u32| {
        let [x, y, z] = [0, 1, 2].map(|axis| f64::from(i >> axis & 1));
        Point3::new(0.04 * x, 0.03 * y, 0.16 * z)
    };
    let sides =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let halves = sides.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    SurfaceMesh::new((0..8).map(corner).collect(), halves.collect()).unwrap()
}

/// Runs `hapdef mesh` in a folder with `box.stl`, and a gmsh that does what `script` says.
fn mesh(folder: &Path, script: &str, words: &[&str]) -> Output {
    let gmsh = folder.join("gmsh");
    std::fs::write(&gmsh, format!("#!/bin/sh\n{script}\n")).unwrap();
    std::fs::set_permissions(&gmsh, std::fs::Permissions::from_mode(0o755)).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_hapdef"));
    command.args(["mesh", "--gmsh", "./gmsh", "-o", "limb.msh"]).args(words);
    command.current_dir(folder).output().unwrap()
}

#[track_caller]
fn refused(output: &Output, expected: &str) {
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(2) && error.contains(expected), "{output:?}");
}

#[test]
fn a_surface_is_handed_to_gmsh_in_millimetres() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    write_stl(&path("box.stl"), &closed()).unwrap();
    let script = "test \"$1\" = -3 && test \"$3\" = -o && cat \"$2\" surface.stl > \"$4\"";
    let output = mesh(folder.path(), script, &["box.stl", "--edge", "4"]);
    assert!(output.status.success(), "{output:?}");
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(said.contains("read in mm, edges up to 4.0 mm"), "{said}");
    assert!(said.contains("next:       hapdef new limb.msh"), "{said}");
    let given = std::fs::read(path("limb.msh")).unwrap();
    let recipe = String::from_utf8_lossy(&given);
    assert!(recipe.contains("Mesh.MeshSizeMax = 4;"), "{recipe}");
    let stl = std::fs::read(path("box.stl")).unwrap();
    assert_eq!(given[given.len() - stl.len() + 80..], stl[80..]);
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(Result::unwrap).collect();
    assert_eq!(left.len(), 3, "{left:?}");
    refused(&mesh(folder.path(), script, &["box.stl"]), "limb.msh: is there already");
    let output = mesh(folder.path(), script, &["box.stl", "--edge", "4", "--force", "--json"]);
    let made: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        (&made["unit"], &made["edge_m"], &made["out"]),
        (&"mm".into(), &0.004.into(), &"limb.msh".into())
    );
}

#[test]
fn what_keeps_gmsh_from_it_is_said() {
    let folder = tempfile::tempdir().unwrap();
    write_stl(&folder.path().join("box.stl"), &closed()).unwrap();
    let fails = "echo 'Info : Meshing'; echo 'Error   : Wrong topology' >&2; exit 1";
    let failed = mesh(folder.path(), fails, &["box.stl"]);
    refused(&failed, "did not mesh it: Error   : Wrong topology; exit status: 1");
    refused(&mesh(folder.path(), "", &["box.stl"]), "it wrote nothing");
    let none = ["mesh", "box.stl", "-o", "limb.msh", "--gmsh", "no-such-gmsh"];
    let none = Command::new(env!("CARGO_BIN_EXE_hapdef"))
        .args(none)
        .current_dir(folder.path())
        .output()
        .unwrap();
    refused(&none, "no-such-gmsh: no such program: install gmsh");
    let skin = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin/shin_skin.glb");
    let open = mesh(folder.path(), "", &[skin.to_str().unwrap()]);
    refused(&open, "open edges enclose no volume");
}
