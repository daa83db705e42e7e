//! Shells found in solids of known wall thickness, and what is refused.

use crate::surface_common;

use std::f64::consts::PI;

use hapdef_mesh::{
    BodyChoice, CleanParams, MeshError, ShellSurface, SkinSide, SolidShell, SolidShellParams,
    SurfaceFault, SurfaceMesh, WallKind, clean_surface, measure_solid, shell_from_solid,
};
use nalgebra::{Matrix4, Vector3};
use surface_common::{ball_m3, cube, joined, shifted, sphere, torus, tube, turned, with_triangles};

fn found(solid: &SurfaceMesh) -> SolidShell {
    shell_from_solid(solid, &SolidShellParams::default()).unwrap()
}

#[track_caller]
fn refused(solid: &SurfaceMesh) -> SurfaceFault {
    match shell_from_solid(solid, &SolidShellParams::default()) {
        Err(MeshError::Surface(fault)) => fault,
        other => panic!("{other:?}"),
    }
}

/// Both spheres have the same facets, so the facets' distance is the thickness times cos of less
/// than 6°.
#[test]
fn a_hollow_sphere_has_its_wall() {
    let (outer_m, wall_m) = (0.1, 0.005);
    let solid = joined(&sphere(outer_m, 4), &turned(&sphere(outer_m - wall_m, 4)));
    let shell = found(&solid);
    let info = &shell.info;
    assert_eq!((info.n_cavities, info.n_outer_triangles), (1, 2048), "{info:?}");
    assert!(info.not_shell_share == 0.0, "{info:?}");
    for thickness_m in info.thickness_quantiles_m.iter().chain(&shell.thickness_m) {
        assert!((thickness_m / wall_m - 1.0).abs() < 0.02, "{thickness_m}");
    }
    let exact = ball_m3(outer_m, outer_m - wall_m);
    assert!((info.solid_volume_m3 / exact - 1.0).abs() < 0.01, "{info:?}");
    assert!((info.shell_volume_m3 / info.solid_volume_m3 - 1.0).abs() < 0.01, "{info:?}");
    let shell = shell.shell().unwrap();
    assert!((shell.volume_m3() / exact - 1.0).abs() < 0.02, "{}", shell.volume_m3());
    for (node, director) in shell.nodes().iter().zip(shell.directors()) {
        let radius_m = node.coords.norm();
        assert!((radius_m - (outer_m - 0.5 * wall_m)).abs() < 0.02 * wall_m, "{radius_m}");
        assert!(director.dot(&node.coords) > 0.999 * radius_m);
    }
}

/// The ends of the wall are no shell; the rest of what sees the outside is.
#[test]
fn a_tube_has_its_wall_and_two_rims() {
    let (outer_m, wall_m, height_m) = (0.036, 0.001, 0.12);
    let shell = found(&tube([outer_m - wall_m, outer_m], height_m, 24, 72));
    let info = &shell.info;
    let (side, rims) = (
        2.0 * PI * outer_m * height_m,
        2.0 * PI * (outer_m * outer_m - (outer_m - wall_m).powi(2)),
    );
    let share = rims / (side + rims);
    assert!((info.no_wall_share / share - 1.0).abs() < 0.01, "{share} {info:?}");
    assert!((info.not_shell_share - info.no_wall_share).abs() < 1e-12, "{info:?}");
    assert!((shell.skin.area_m2() / side - 1.0).abs() < 0.01);
    for thickness_m in &shell.thickness_m {
        assert!((thickness_m / wall_m - 1.0).abs() < 0.01, "{thickness_m}");
    }
    assert!((info.shell_volume_m3 / info.solid_volume_m3 - 1.0).abs() < 0.01, "{info:?}");
}

/// The inner side of the bend sees the other side of the ring, and is outer skin all the same.
#[test]
fn a_hollow_torus_has_its_wall() {
    let [outer, inner] = [0.03, 0.028].map(|tube_m| torus(0.1, tube_m, 32, 96));
    let shell = found(&joined(&outer, &turned(&inner)));
    let info = &shell.info;
    assert_eq!((info.n_outer_triangles, info.n_cavities), (2 * 32 * 96, 1), "{info:?}");
    for thickness_m in &shell.thickness_m {
        assert!((thickness_m / 0.002 - 1.0).abs() < 0.03, "{thickness_m}");
    }
    let exact = 2.0 * PI * PI * 0.1 * (0.03_f64.powi(2) - 0.028_f64.powi(2));
    assert!((info.shell_volume_m3 / exact - 1.0).abs() < 0.02, "{info:?} {exact}");
}

#[test]
fn solid_bodies_are_no_shells() {
    let bar = cube(0.1).transformed(&Matrix4::new_nonuniform_scaling(&Vector3::new(5.0, 0.3, 0.4)));
    for solid in [sphere(0.1, 3), cube(0.1), bar.unwrap()] {
        match refused(&solid) {
            SurfaceFault::NotAShell { share, solid_core_share, volume_m3, .. } => {
                assert!(share > 0.99 && solid_core_share > 0.8, "{share} {solid_core_share}");
                assert!((volume_m3 - solid.signed_volume_m3()).abs() < 1e-15);
            }
            other => panic!("{other}"),
        }
    }
}

#[test]
fn a_solid_ring_is_no_shell() {
    let fault = refused(&torus(0.1, 0.03, 24, 72));
    assert!(matches!(fault, SurfaceFault::NotAShell { .. }), "{fault}");
}

/// A wall of nearly half the radius is a quarter of the diameter.
#[test]
fn a_thick_wall_is_no_shell_but_can_be_measured() {
    let solid = joined(&sphere(0.1, 3), &turned(&sphere(0.04, 3)));
    match refused(&solid) {
        SurfaceFault::NotAShell { too_thick_share, .. } => {
            assert!(too_thick_share > 0.99, "{too_thick_share}");
        }
        other => panic!("{other}"),
    }
    let params = SolidShellParams { max_thickness_ratio: 0.4, ..SolidShellParams::default() };
    let shell = measure_solid(&solid, &params).unwrap();
    assert!((shell.info.thickness_quantiles_m[2] / 0.06 - 1.0).abs() < 0.05, "{:?}", shell.info);
    assert!(shell.kinds[..512].iter().all(|kind| *kind == WallKind::Shell));
    assert!(shell.kinds[512..].iter().all(|kind| *kind == WallKind::Inside));
}

#[test]
fn what_is_no_solid_is_refused_with_its_cause() {
    let ball = sphere(0.1, 2);
    let without_one = with_triangles(&ball, ball.triangles()[1..].to_vec());
    match refused(&without_one) {
        SurfaceFault::Defects { defects, .. } => {
            assert_eq!((defects.open_edges.n, defects.non_manifold_edges.n), (3, 0));
            assert!(defects.to_string().contains("as if it were closed"), "{defects}");
        }
        other => panic!("{other}"),
    }
    let mut doubled = ball.triangles().to_vec();
    doubled.push(doubled[7]);
    match refused(&with_triangles(&ball, doubled)) {
        SurfaceFault::Defects { defects, .. } => {
            assert_eq!((defects.doubled_triangles.n, defects.non_manifold_edges.n), (1, 3));
            assert_eq!(defects.doubled_triangles.first, Some(128));
        }
        other => panic!("{other}"),
    }
    let two = joined(&ball, &shifted(&ball, Vector3::new(0.3, 0.0, 0.0)));
    assert!(matches!(refused(&two), SurfaceFault::Bodies { volumes_m3 } if volumes_m3.len() == 2));
    assert!(matches!(refused(&turned(&ball)), SurfaceFault::Volume { .. }));
    let small = turned(&sphere(0.02, 2));
    let aside = joined(&ball, &shifted(&small, Vector3::new(0.3, 0.0, 0.0)));
    assert!(matches!(refused(&aside), SurfaceFault::CavityOutside { body: 1, .. }));
    let in_mm = ball.scaled(1e3).unwrap();
    let fault = refused(&in_mm);
    assert!(matches!(fault, SurfaceFault::UnitUnknown { .. }));
    assert!(fault.to_string().contains("(mm)"), "{fault}");
}

/// Two cubes that share a corner vertex.
#[test]
fn touching_fans_and_flat_triangles_are_found() {
    let one = cube(0.1);
    let two = joined(&one, &shifted(&one, Vector3::repeat(0.1))).weld(1e-9).unwrap().0;
    match refused(&two) {
        SurfaceFault::Defects { defects, .. } => assert_eq!(defects.non_manifold_vertices.n, 1),
        other => panic!("{other}"),
    }
    let mut triangles = one.triangles().to_vec();
    triangles.push([0, 0, 1]);
    match refused(&with_triangles(&one, triangles)) {
        SurfaceFault::Defects { defects, .. } => {
            assert_eq!(defects.degenerate_triangles.first, Some(12));
        }
        other => panic!("{other}"),
    }
}

#[test]
fn parameters_out_of_range_are_refused() {
    let ball = sphere(0.1, 1);
    let default = SolidShellParams::default();
    let bad = [
        SolidShellParams { n_wall_rays: 0, ..default },
        SolidShellParams { wall_cone_half_angle_rad: 2.0, ..default },
        SolidShellParams { max_thickness_ratio: f64::NAN, ..default },
        SolidShellParams { max_volume_difference: -1.0, ..default },
    ];
    for params in bad {
        let found = shell_from_solid(&ball, &params);
        assert!(
            matches!(found, Err(MeshError::Surface(SurfaceFault::Parameter { .. }))),
            "{params:?}"
        );
    }
}

#[test]
fn a_skin_of_one_thickness() {
    let wall_m = 0.01;
    let shell = ShellSurface::with_constant_thickness(&cube(0.1), wall_m, SkinSide::Outer).unwrap();
    let size = shell.middle().bounding_box().size_m();
    assert!((size - Vector3::repeat(0.09)).norm() < 1e-14, "{size}");
    assert!((shell.volume_m3() - 6.0 * 0.09 * 0.09 * wall_m).abs() < 1e-15);
    let inner = ShellSurface::with_constant_thickness(&cube(0.1), wall_m, SkinSide::Inner).unwrap();
    assert!((inner.middle().bounding_box().longest_m() - 0.11).abs() < 1e-14);
    let ball = sphere(0.1, 2);
    let middle = ShellSurface::with_constant_thickness(&ball, 0.3, SkinSide::Middle).unwrap();
    assert_eq!(middle.middle(), &ball);
    let folded = ShellSurface::with_constant_thickness(&ball, 0.3, SkinSide::Outer);
    assert!(matches!(folded, Err(MeshError::Surface(SurfaceFault::OffsetFolds { .. }))));
    let no_wall = ShellSurface::with_constant_thickness(&ball, 0.0, SkinSide::Middle);
    assert!(matches!(no_wall, Err(MeshError::Surface(SurfaceFault::Thickness { node: 0, .. }))));
}

#[test]
fn cleaning_does_what_is_asked_and_counts_it() {
    let (ball, small) = (sphere(0.1, 2), sphere(0.02, 1));
    let mesh = joined(&small, &shifted(&ball, Vector3::new(0.3, 0.0, 0.0)));
    let mut triangles = mesh.triangles().to_vec();
    triangles.extend([[3, 3, 4], triangles[40]]);
    let dirty = with_triangles(&mesh, triangles);
    let (same, info) = clean_surface(&dirty, &CleanParams::default()).unwrap();
    assert_eq!(same, dirty);
    assert_eq!(info.before, info.after);
    let params = CleanParams {
        weld_tolerance_m: Some(0.0),
        drop_degenerate: true,
        drop_doubled: true,
        orient: false,
        body: BodyChoice::LargestArea,
    };
    let (clean, info) = clean_surface(&dirty, &params).unwrap();
    assert_eq!(clean.triangles().len(), ball.triangles().len());
    assert_eq!((info.n_collapsed_triangles, info.n_doubled_dropped), (1, 1));
    assert_eq!((info.n_other_body_triangles, info.body_volumes_m3.len()), (32, 2));
    assert!(!info.before.is_closed() && info.after.is_closed());
    assert!((info.after.volume_m3 - ball.signed_volume_m3()).abs() < 1e-15);
    let none = CleanParams { body: BodyChoice::Number(2), ..params };
    let missing = clean_surface(&dirty, &none);
    assert!(matches!(
        missing,
        Err(MeshError::Surface(SurfaceFault::NoSuchBody { body: 2, n_bodies: 2 }))
    ));
}
