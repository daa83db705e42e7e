//! Surfaces as STL, OBJ and DAE, and as programs and robots have them.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::gltf_common::shared;
use hapdef_mesh::{
    CleanParams, GltfParams, LengthUnit, MeshError, QualityReport, SurfaceMesh, clean_surface,
    read_surface,
};
use proptest::prelude::*;

/// A tetrahedron that faces outward.
const CORNERS: [[f32; 3]; 4] =
    [[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0], [0.0, 0.0, 10.0]];
const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn stl_words() -> String {
    let mut text = String::from("solid tip\n");
    for face in FACES {
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in face.map(|corner| CORNERS[corner]) {
            text += &format!("vertex {x} {y} {z}\n");
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid tip\n"
}

fn stl_bytes() -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend(4_u32.to_le_bytes());
    for face in FACES {
        bytes.extend([0; 12]);
        let numbers = face.iter().flat_map(|corner| CORNERS[*corner]);
        bytes.extend(numbers.flat_map(f32::to_le_bytes));
        bytes.extend([0; 2]);
    }
    bytes
}

fn obj() -> String {
    let corners = CORNERS.map(|[x, y, z]| format!("v {x} {y} {z}\n")).concat();
    let faces = FACES.map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1)).concat();
    format!("mtllib elsewhere.mtl\no tip\n{corners}{faces}")
}

fn read(name: &str, bytes: &[u8]) -> Result<SurfaceMesh, MeshError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    let params = GltfParams { unit: LengthUnit::Millimetre, ..GltfParams::default() };
    read_surface(&path, &params).map(|surface| surface.mesh)
}

#[test]
fn one_body_in_every_format() {
    let files = [
        ("a.stl", stl_words().into_bytes()),
        ("A.STL", stl_bytes()),
        ("a.obj", obj().into_bytes()),
    ];
    for (name, bytes) in files {
        let mesh = read(name, &bytes).unwrap();
        assert_eq!((mesh.vertices().len(), mesh.triangles().len()), (4, 4), "{name}");
        assert!((mesh.signed_volume_m3() - 1e-6 / 6.0).abs() < 1e-18, "{name}");
    }
}

#[test]
fn what_is_cut_short_or_too_large_is_refused() {
    let bytes = stl_bytes();
    let found = read("a.stl", &bytes[..bytes.len() - 20]).unwrap_err();
    assert!(matches!(found, MeshError::SurfaceFile { .. }), "{found}");
    assert!(read("a.obj", b"f 1 2 3\n").is_err());
    assert!(read("a.dae", b"<COLLADA>").is_err());
    assert!(read("a.ply", &bytes).unwrap_err().to_string().contains(".stl"));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.stl");
    fs::write(&path, &bytes).unwrap();
    for params in [
        GltfParams { max_bytes: 100, ..GltfParams::default() },
        GltfParams { max_vertices: 3, ..GltfParams::default() },
        GltfParams { max_triangles: 3, ..GltfParams::default() },
    ] {
        let found = read_surface(&path, &params).unwrap_err().to_string();
        assert!(found.contains("allowed"), "{found}");
    }
}

fn field(file: &str) -> Option<PathBuf> {
    shared(&format!("field/{file}"))
}

/// The surface welded at 1 µm, as every command does, and cleaned as asked.
fn cleaned(path: &Path, unit: LengthUnit, orient: bool) -> (QualityReport, usize) {
    let params = CleanParams { weld_tolerance_m: Some(1e-6), orient, ..CleanParams::default() };
    let surface = read_surface(path, &GltfParams { unit, ..GltfParams::default() }).unwrap();
    let (mesh, info) = clean_surface(&surface.mesh, &params).unwrap();
    let report = QualityReport::of(&mesh);
    println!("{}: {} turned\n{report}", path.display(), info.n_turned);
    (report, info.n_turned)
}

/// A binary STL says how many triangles it has; welding may drop a few without area.
#[test]
fn stl_of_robots_and_solidworks() {
    for file in ["cassie_shin.stl", "finger_edu_lower_link.stl", "solidworks_featuretype.STL"] {
        let Some(path) = field(&format!("surface/{file}")) else { continue };
        let count = fs::read(&path).unwrap()[80..84].try_into().unwrap();
        let stated = u32::from_le_bytes(count) as usize;
        let (report, _) = cleaned(&path, LengthUnit::Metre, false);
        assert!((stated * 95 / 100..=stated).contains(&report.n_triangles), "{file}: {stated}");
        assert!(
            !report.unit_guess.candidates.is_empty() || file.starts_with("solidworks"),
            "{file}"
        );
    }
}

#[test]
fn surfaces_of_opencascade_and_gmsh() {
    if let Some(path) = field("surface/opencascade_mm_tube.glb") {
        assert!(cleaned(&path, LengthUnit::Metre, false).0.is_closed());
    }
    if let Some(path) = field("surface/gmsh_stl_misoriented.glb") {
        let (before, _) = cleaned(&path, LengthUnit::Metre, false);
        assert_eq!(before.n_misoriented_edges, 48);
        let (after, n_turned) = cleaned(&path, LengthUnit::Metre, true);
        assert!(after.n_misoriented_edges == 0 && after.signed_volume_m3 > 0.0 && n_turned > 0);
    }
    if let Some(path) = field("gmsh/gmsh_stl.stl.gz") {
        let mut text = Vec::new();
        let file = fs::File::open(path).unwrap();
        flate2::read::GzDecoder::new(file).read_to_end(&mut text).unwrap();
        let stated = String::from_utf8_lossy(&text).matches("endfacet").count();
        assert_eq!(read("gmsh.stl", &text).unwrap().triangles().len(), stated);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// A damaged file gives a surface or an error, never a panic.
    #[test]
    fn damage_never_panics(
        place in 0.0..1.0_f64, byte in any::<u8>(), cut in any::<bool>(), which in 0..3_usize,
    ) {
        let files = [stl_words().into_bytes(), stl_bytes(), obj().into_bytes()];
        let mut bytes = files[which].clone();
        let place = (place * bytes.len() as f64) as usize;
        bytes[place] = byte;
        if cut {
            bytes.truncate(place);
        }
        let _ = read(["a.stl", "a.stl", "a.obj"][which], &bytes);
    }
}
