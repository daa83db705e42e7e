//! Real limbs: the reader and the quality report against what trimesh 5 finds in the same files
//! (unwelded, `process=False`).

use crate::gltf_common;

use gltf_common::{files, shared};
use hapdef_mesh::{GltfParams, LengthUnit, QualityReport, read_gltf};

#[test]
fn every_limb_has_triangles_and_honest_bounds() {
    for folder in ["limbs", "hapdef-shin"].into_iter().filter_map(shared) {
        for path in files(&folder, &["glb"]) {
            let surface = read_gltf(&path, &GltfParams::default()).unwrap();
            assert!(!surface.mesh.triangles().is_empty(), "{}", path.display());
            assert_eq!(surface.info.n_outside_bounds, 0, "{}", path.display());
            assert_eq!(surface.parts.len(), 1, "{}", path.display());
        }
    }
}

/// What is expected of a closed limb of one body.
struct Closed {
    file: &'static str,
    n_vertices: usize,
    n_triangles: usize,
    genus: usize,
    volume: f64,
    area: f64,
    sliver_percent: f64,
}

#[track_caller]
fn check(expected: &Closed) {
    let Some(folder) = shared("") else { return };
    let surface = read_gltf(&folder.join(expected.file), &GltfParams::default()).unwrap();
    let report = QualityReport::of(&surface.mesh);
    assert!(report.is_closed(), "{report}");
    assert_eq!(report.n_vertices, expected.n_vertices);
    assert_eq!(report.n_triangles, expected.n_triangles);
    assert_eq!((report.n_bodies, report.genus), (1, Some(expected.genus)), "{report}");
    assert!((report.signed_volume_m3 / expected.volume - 1.0).abs() < 1e-9, "{report}");
    assert!((report.area_m2 / expected.area - 1.0).abs() < 1e-9, "{report}");
    let percent = 100.0 * report.n_sliver_triangles as f64 / report.n_triangles as f64;
    assert!((percent - expected.sliver_percent).abs() < 0.01, "{percent} {report}");
}

#[test]
fn authors_shin() {
    check(&Closed {
        file: "hapdef-shin/hapdef_shin_surface_tri3_m.glb",
        n_vertices: 3461,
        n_triangles: 7122,
        genus: 51,
        volume: 2.6844492151262075e-5,
        area: 0.0501114378799566,
        sliver_percent: 29.87,
    });
}

#[test]
fn alexander_shin() {
    check(&Closed {
        file: "limbs/alexander_left_shin.glb",
        n_vertices: 1281,
        n_triangles: 2558,
        genus: 0,
        volume: 0.005560255404513431,
        area: 0.2206781783488666,
        sliver_percent: 8.68,
    });
}

#[test]
fn hyq_lower_leg_has_one_through_hole() {
    check(&Closed {
        file: "limbs/hyq_lowerleg.glb",
        n_vertices: 207,
        n_triangles: 414,
        genus: 1,
        volume: 0.0003578841599433378,
        area: 0.062050791113598264,
        sliver_percent: 18.84,
    });
}

#[test]
fn kinova_forearm() {
    check(&Closed {
        file: "limbs/kinova_forearm.glb",
        n_vertices: 3493,
        n_triangles: 6982,
        genus: 0,
        volume: 0.0005344618858950315,
        area: 0.04974585515382969,
        sliver_percent: 32.73,
    });
}

fn report_of(file: &str) -> Option<QualityReport> {
    let path = shared("limbs")?.join(file);
    Some(QualityReport::of(&read_gltf(&path, &GltfParams::default()).unwrap().mesh))
}

#[test]
fn poppy_shin_part_is_a_lattice_with_seven_non_manifold_edges() {
    let Some(report) = report_of("poppy_r_shin_part.glb") else {
        return;
    };
    assert_eq!((report.n_non_manifold_edges, report.n_open_edges), (7, 0));
    assert_eq!((report.is_closed(), report.genus), (false, None));
    let percent = 100.0 * report.n_sliver_triangles as f64 / report.n_triangles as f64;
    assert!((percent - 37.44).abs() < 0.01, "{percent}");
}

/// Three bodies across edges. Tools that join triangles only across edges with exactly two of them
/// count 35, since 29 triangles repeat a corner and stand alone then.
#[test]
fn go2_calf_has_degenerate_triangles_and_is_open() {
    let Some(report) = report_of("go2_calf.glb") else {
        return;
    };
    assert_eq!((report.n_bodies, report.n_degenerate_triangles), (3, 30));
    assert!(!report.is_closed());
    assert!(report.n_open_edges > 0 && report.n_non_manifold_edges > 0, "{report}");
}

#[test]
fn the_human_leg_has_an_uncertain_unit() {
    let Some(report) = report_of("human_lowerleg_mm.glb") else {
        return;
    };
    assert_eq!(report.unit_guess.candidates, [LengthUnit::Millimetre, LengthUnit::Centimetre]);
    assert_eq!(report.unit_guess.only(), None);
    let Some(folder) = shared("limbs") else {
        return;
    };
    let params = GltfParams { unit: LengthUnit::Centimetre, ..GltfParams::default() };
    let surface = read_gltf(&folder.join("human_lowerleg_mm.glb"), &params).unwrap();
    assert!((surface.mesh.bounding_box().longest_m() - 0.67).abs() < 1e-6);
}
