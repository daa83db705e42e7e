//! Surfaces that go through themselves: what is found, what is refused, and real limbs. Run with
//! `--nocapture` for counts and times.

use crate::gltf_common;
use crate::surface_common;

use std::path::Path;
use std::time::Instant;

use gltf_common::shared;
use hapdef_mesh::{
    ExtrudeParams, FaceCurve, GltfParams, MeshError, QualityReport, SkinSide, SolidShellParams,
    SurfaceFault, SurfaceMesh, extrude, measure_solid, read_gltf, self_intersections,
};
use nalgebra::Point3;
use surface_common::{revolved, sphere};

/// A ring whose profile is a bow-tie, crossing itself at radius 40 mm and height 40 mm.
#[test]
fn a_bow_tie_ring_is_refused_as_a_solid() {
    let profile = [[0.02, 0.0], [0.06, 0.0], [0.03, 0.06], [0.05, 0.06]];
    let mesh = revolved(&profile, 48);
    let report = QualityReport::of(&mesh);
    assert!(report.is_closed() && report.crossings.len() >= 48, "{report}");
    for crossing in &report.crossings {
        let place = crossing.place;
        let radius_m = place.x.hypot(place.y);
        assert!((place.z - 0.04).abs() < 1e-12, "{place}");
        assert!((0.0399..0.040_000_1).contains(&radius_m), "{place}");
    }
    let printed = format!("crossing pairs      {}, at (", report.crossings.len());
    assert!(report.to_string().contains(&printed), "{report}");
    let fault = measure_solid(&mesh, &SolidShellParams::default()).unwrap_err();
    let MeshError::Surface(SurfaceFault::Crosses { crossings, .. }) = &fault else {
        panic!("{fault}");
    };
    assert_eq!(crossings, &report.crossings);
    let text = fault.to_string();
    let pairs = format!("{} pairs of triangles cross, at (", crossings.len());
    let advice = "unite the parts";
    assert!(text.contains(&pairs) && text.contains(advice), "{text}");
}

/// Two plates that lean towards each other, outsides apart.
fn leaning_plates(gap_m: f64) -> SurfaceMesh {
    let p = |x: f64, z: f64| [0.0, 0.05].map(|y| Point3::new(x, y, z));
    let rows = [p(0.0, 0.0), p(0.0, 0.04), p(gap_m, 0.0), p(gap_m + 0.005, 0.04)];
    let triangles = vec![[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6]];
    SurfaceMesh::new(rows.concat(), triangles).unwrap()
}

#[test]
fn a_wall_without_room_is_not_extruded() {
    let params = ExtrudeParams { side: SkinSide::Outer, n_layers: 1, curve: FaceCurve::Flat };
    let extruded = |gap_m| extrude(&leaning_plates(gap_m), &[2e-3; 8], &params);
    assert!(extruded(5e-3).is_ok());
    let fault = extruded(1e-3).unwrap_err();
    let MeshError::Surface(SurfaceFault::Crosses { what, crossings, .. }) = &fault else {
        panic!("{fault}");
    };
    assert_eq!(*what, "the extruded wall");
    assert!(crossings.len() > 3, "{crossings:?}");
    let text = fault.to_string();
    assert!(text.contains("… mm; there is no room for the wall"), "{text}");
}

#[test]
fn a_fine_sphere_has_none() {
    let mesh = sphere(0.1, 7);
    let start = Instant::now();
    let found = self_intersections(&mesh);
    let elapsed_s = start.elapsed().as_secs_f64();
    println!("{} triangles: {elapsed_s:.2} s", mesh.triangles().len());
    assert!(mesh.triangles().len() > 100_000 && found.is_empty());
}

fn n_crossings(path: &Path) -> usize {
    let read = read_gltf(path, &GltfParams::default()).unwrap().mesh;
    let (mesh, _) = read.weld(1e-6).unwrap();
    let start = Instant::now();
    let report = QualityReport::of(&mesh);
    let elapsed_s = start.elapsed().as_secs_f64();
    println!("{}: {elapsed_s:.2} s\n{report}", path.display());
    report.crossings.len()
}

#[test]
fn the_bundled_skin_has_none() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/shin/shin_skin.glb");
    assert_eq!(n_crossings(Path::new(path)), 0);
}

/// The two that are refused as no manifold go through themselves, too; the human leg's millimetres
/// are read as metres.
#[test]
fn real_limbs() {
    let Some(folder) = shared("limbs") else {
        return;
    };
    for (file, expected) in [
        ("kinova_forearm.glb", 0),
        ("hyq_lowerleg.glb", 0),
        ("alexander_left_shin.glb", 0),
        ("bolt_lower_leg.glb", 0),
        ("go2_calf.glb", 215),
        ("human_lowerleg_mm.glb", 0),
        ("poppy_r_shin_part.glb", 211),
    ] {
        assert_eq!(n_crossings(&folder.join(file)), expected, "{file}");
    }
}
