//! Real limbs on the way to a shell: what they are, what is refused and why, and the remeshed skin
//! of those that only have one. Run with `--nocapture` for the table.

use crate::gltf_common;

use gltf_common::shared;
use hapdef_mesh::{
    CleanParams, GltfParams, LengthUnit, MeshError, QualityReport, RemeshParams, ShellSurface,
    SkinSide, SolidShellParams, SurfaceFault, SurfaceMesh, VertexField, clean_surface,
    measure_solid, read_gltf, remesh, shell_from_solid, write_glb,
};

fn limb(file: &str, unit: LengthUnit) -> Option<SurfaceMesh> {
    let params = GltfParams { unit, ..GltfParams::default() };
    Some(read_gltf(&shared("")?.join(file), &params).unwrap().mesh)
}

fn fault(limb: &SurfaceMesh) -> SurfaceFault {
    match shell_from_solid(limb, &SolidShellParams::default()) {
        Err(MeshError::Surface(fault)) => fault,
        other => panic!("{other:?}"),
    }
}

/// A visual mesh: one closed skin, no wall. Its wall is what the caller says.
struct Skin {
    file: &'static str,
    target_edge_m: f64,
    genus: usize,
    volume_m3: f64,
}

#[track_caller]
fn check_skin(expected: &Skin) {
    let Some(skin) = limb(expected.file, LengthUnit::Metre) else {
        return;
    };
    let cause = fault(&skin);
    println!("{}: as a solid: {cause}", expected.file);
    assert!(
        matches!(cause, SurfaceFault::NotAShell { volume_m3, .. }
            if (volume_m3 / expected.volume_m3 - 1.0).abs() < 1e-9),
        "{cause}"
    );
    let (fine, info) = remesh(&skin, &RemeshParams::new(expected.target_edge_m)).unwrap();
    let report = QualityReport::of(&fine);
    println!("{report}\n{info:?}");
    assert!(report.is_closed());
    assert_eq!((report.n_bodies, report.genus), (1, Some(expected.genus)));
    assert!(info.volume_change().abs() < 0.005, "{info:?}");
    assert!(info.on_target_share > 0.9, "{info:?}");
    assert!(100 * report.n_sliver_triangles < report.n_triangles, "{report}");
    let shell = ShellSurface::with_constant_thickness(&fine, 0.002, SkinSide::Middle).unwrap();
    assert!((shell.volume_m3() / (0.002 * info.area_m2[0]) - 1.0).abs() < 0.01);
    let inward = ShellSurface::with_constant_thickness(&fine, 0.002, SkinSide::Outer).unwrap();
    println!("2 mm inward: {:.3} cm3", inward.volume_m3() * 1e6);
    assert!(inward.volume_m3() < shell.volume_m3());
}

#[test]
fn kinova_forearm() {
    check_skin(&Skin {
        file: "limbs/kinova_forearm.glb",
        target_edge_m: 0.004,
        genus: 0,
        volume_m3: 0.0005344618858950315,
    });
}

#[test]
fn alexander_shin() {
    check_skin(&Skin {
        file: "limbs/alexander_left_shin.glb",
        target_edge_m: 0.006,
        genus: 0,
        volume_m3: 0.005560255404513431,
    });
}

#[test]
fn hyq_lower_leg() {
    check_skin(&Skin {
        file: "limbs/hyq_lowerleg.glb",
        target_edge_m: 0.004,
        genus: 1,
        volume_m3: 0.0003578841599433378,
    });
}

#[test]
fn bolt_lower_leg_is_a_solid_bar() {
    let Some(bar) = limb("limbs/bolt_lower_leg.glb", LengthUnit::Metre) else {
        return;
    };
    let cause = fault(&bar);
    println!("bolt: {cause}");
    assert!(matches!(cause, SurfaceFault::NotAShell { share, .. } if share > 0.9), "{cause}");
}

/// Nothing that a caller may ask for makes it a solid: the holes and the crossing sheets stay.
#[test]
fn go2_calf_is_refused_with_its_holes_and_volume() {
    let Some(calf) = limb("limbs/go2_calf.glb", LengthUnit::Metre) else {
        return;
    };
    for params in [
        CleanParams::default(),
        CleanParams {
            weld_tolerance_m: Some(1e-6),
            drop_degenerate: true,
            drop_doubled: true,
            ..CleanParams::default()
        },
    ] {
        let (cleaned, info) = clean_surface(&calf, &params).unwrap();
        let cause = fault(&cleaned);
        println!("go2: {cause}");
        println!("bodies, m3: {:?}; before: {}", info.body_volumes_m3, info.before);
        let SurfaceFault::Defects { defects, .. } = cause else {
            panic!("{cause}");
        };
        assert!(defects.open_edges.n > 0 && defects.non_manifold_edges.n > 0);
        assert!((defects.volume_m3 * 1e6 - 166.102).abs() < 1e-3, "{defects}");
        let remeshed = remesh(&cleaned, &RemeshParams::new(0.004));
        assert!(matches!(remeshed, Err(MeshError::Surface(SurfaceFault::Defects { .. }))));
    }
}

#[test]
fn poppy_part_is_refused_with_its_edges_and_volume() {
    let Some(part) = limb("limbs/poppy_r_shin_part.glb", LengthUnit::Metre) else {
        return;
    };
    let cause = fault(&part);
    println!("poppy: {cause}");
    let SurfaceFault::Defects { defects, .. } = cause else {
        panic!("{cause}");
    };
    assert_eq!((defects.non_manifold_edges.n, defects.non_manifold_vertices.n), (7, 2));
    assert_eq!((defects.open_edges.n, defects.doubled_triangles.n), (0, 0));
    assert!((defects.volume_m3 * 1e6 - 38.874).abs() < 1e-3, "{defects}");
}

#[test]
fn human_leg_needs_its_unit() {
    let Some(leg) = limb("limbs/human_lowerleg_mm.glb", LengthUnit::Metre) else {
        return;
    };
    let cause = fault(&leg);
    println!("human: {cause}");
    assert!(
        matches!(&cause, SurfaceFault::UnitUnknown { candidates, .. } if candidates == "mm or cm")
    );
    let in_cm = limb("limbs/human_lowerleg_mm.glb", LengthUnit::Centimetre).unwrap();
    let cause = fault(&in_cm);
    println!("human, cm: {cause}");
    assert!(matches!(cause, SurfaceFault::NotAShell { .. }));
}

/// A shell with ribs, rings and holes: a quarter of its skin is cut off by them, and the skin's
/// wall is far from all of its volume, so it is refused; the picture shows where.
#[test]
fn authors_shin_is_more_than_its_wall() {
    let Some(shin) = limb("hapdef-shin/hapdef_shin_surface_tri3_m.glb", LengthUnit::Metre) else {
        return;
    };
    let cause = fault(&shin);
    println!("authors: {cause}");
    let found = measure_solid(&shin, &SolidShellParams::default()).unwrap();
    println!("{:?}", found.info);
    let info = &found.info;
    assert!((info.solid_volume_m3 / 2.6844492151262075e-5 - 1.0).abs() < 1e-9);
    assert!(info.shell_volume_m3 < 0.75 * info.solid_volume_m3, "{info:?}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("thickness.glb");
    let field = VertexField {
        name: "wall_thickness_m",
        values: &found.thickness_m,
        range: Some((0.0, 0.002)),
    };
    write_glb(&path, &found.skin, Some(&field)).unwrap();
    let back = read_gltf(&path, &GltfParams::default()).unwrap().mesh;
    assert_eq!(back.triangles().len(), found.skin.triangles().len());
}
