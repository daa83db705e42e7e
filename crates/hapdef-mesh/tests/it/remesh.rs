//! Remeshing: edge lengths, volume, distance, features, and that the surface stays a manifold.

use crate::surface_common;

use hapdef_mesh::{
    FaceCurve, MeshError, QualityReport, RemeshInfo, RemeshParams, SurfaceDefects, SurfaceFault,
    SurfaceMesh, remesh, surface_distance,
};
use nalgebra::Point3;
use proptest::prelude::*;
use surface_common::{cube, sphere, torus, tube, with_triangles};

fn remeshed(mesh: &SurfaceMesh, target_edge_m: f64) -> (SurfaceMesh, RemeshInfo) {
    remesh(mesh, &RemeshParams::new(target_edge_m)).unwrap()
}

#[track_caller]
fn check_same_kind(before: &SurfaceMesh, after: &SurfaceMesh) {
    let [a, b] = [before, after].map(QualityReport::of);
    assert_eq!((a.n_bodies, a.genus), (b.n_bodies, b.genus), "{b}");
    assert_eq!(a.is_closed(), b.is_closed(), "{b}");
    let defects = SurfaceDefects::of(after);
    assert!(defects.is_manifold(), "{defects}");
}

#[test]
fn a_sphere_gets_even_triangles() {
    for (n, target_edge_m) in [(4, 0.02), (2, 0.01), (4, 0.008)] {
        let ball = sphere(0.1, n);
        let (fine, info) = remeshed(&ball, target_edge_m);
        check_same_kind(&ball, &fine);
        assert!(info.on_target_share > 0.98, "{info:?}");
        assert!((info.edge_quantiles_m[2] / target_edge_m - 1.0).abs() < 0.1, "{info:?}");
        assert!(info.volume_change().abs() < 0.02, "{info:?}");
        let report = QualityReport::of(&fine);
        assert_eq!(report.n_sliver_triangles, 0, "{report}");
        for triangle in 0..fine.triangles().len() {
            let [a, b, c] = fine.corners(triangle).map(|p| p.coords);
            let outward = (a + b + c).dot(&fine.area_normal_m2(triangle));
            assert!(outward > 0.9 * (a + b + c).norm() * fine.area_normal_m2(triangle).norm());
        }
    }
}

/// Flat faces, straight edges: nothing may be lost at all.
#[test]
fn a_cube_keeps_its_edges_corners_and_volume() {
    let block = cube(0.1);
    let (fine, info) = remeshed(&block, 0.01);
    check_same_kind(&block, &fine);
    assert_eq!(info.n_features, [12, 8]);
    assert!((fine.signed_volume_m3() / 1e-3 - 1.0).abs() < 1e-12, "{info:?}");
    assert!((fine.area_m2() / 0.06 - 1.0).abs() < 1e-12, "{info:?}");
    assert!(info.distance.largest_m() < 1e-12, "{info:?}");
    assert!(info.on_target_share > 0.95, "{info:?}");
    for corner in block.vertices() {
        assert!(fine.vertices().contains(corner), "{corner}");
    }
    let on_edge =
        |p: &&Point3<f64>| p.iter().filter(|x| **x < 1e-12 || **x > 0.1 - 1e-12).count() > 1;
    let n_on_edges = fine.vertices().iter().filter(on_edge).count();
    assert!((8 + 12 * 7..=8 + 12 * 11).contains(&n_on_edges), "{n_on_edges}");
}

/// Slivers from end to end of the tube become even triangles; sharp rims stay circles.
#[test]
fn a_tube_of_slivers_keeps_its_rims() {
    let long = tube([0.03, 0.036], 0.12, 1, 90);
    assert!(QualityReport::of(&long).n_sliver_triangles > 300);
    let (fine, info) = remeshed(&long, 0.004);
    check_same_kind(&long, &fine);
    let report = QualityReport::of(&fine);
    assert_eq!((report.n_sliver_triangles, report.genus), (0, Some(1)), "{report}");
    assert!(info.volume_change().abs() < 0.005, "{info:?}");
    assert!((report.bounding_box.size_m().z - 0.12).abs() < 1e-12);
    assert!(info.distance.largest_m() < 2e-4, "{info:?}");
}

/// An open surface: the rims of a cylinder stay in their planes and the surface stays open.
#[test]
fn open_edges_stay() {
    let solid = tube([0.03, 0.036], 0.12, 6, 60);
    let outside = |t: &[u32; 3]| {
        t.iter().all(|&v| {
            let p = solid.vertices()[v as usize];
            p.x.hypot(p.y) > 0.035
        })
    };
    let triangles = solid.triangles().iter().filter(|t| outside(t)).copied().collect();
    let skin = with_triangles(&solid, triangles).weld(0.0).unwrap().0;
    let (fine, info) = remeshed(&skin, 0.006);
    let defects = SurfaceDefects::of(&fine);
    assert!(defects.is_manifold() && defects.open_edges.n > 60, "{defects}");
    assert_eq!(info.volume_m3, None);
    assert!((info.area_m2[1] / info.area_m2[0] - 1.0).abs() < 0.01, "{info:?}");
    assert!(info.on_target_share > 0.97, "{info:?}");
}

#[test]
fn the_same_bits_every_time() {
    let ring = torus(0.1, 0.03, 20, 50);
    let (a, info_a) = remeshed(&ring, 0.01);
    let (b, info_b) = remeshed(&ring, 0.01);
    assert_eq!(a, b);
    assert_eq!(info_a, info_b);
    check_same_kind(&ring, &a);
    assert_eq!(QualityReport::of(&a).genus, Some(1));
}

#[test]
fn what_cannot_be_remeshed_is_refused() {
    let ball = sphere(0.1, 2);
    let fault = |mesh: &SurfaceMesh, params: &RemeshParams| match remesh(mesh, params) {
        Err(MeshError::Surface(fault)) => fault,
        other => panic!("{other:?}"),
    };
    let mut doubled = ball.triangles().to_vec();
    doubled.push(doubled[3]);
    let doubled = with_triangles(&ball, doubled);
    assert!(matches!(fault(&doubled, &RemeshParams::new(0.01)), SurfaceFault::Defects { .. }));
    assert!(matches!(fault(&ball, &RemeshParams::new(0.0)), SurfaceFault::Parameter { .. }));
    assert!(matches!(
        fault(&ball, &RemeshParams::new(1e-6)),
        SurfaceFault::TooManyTriangles { .. }
    ));
    let strict = RemeshParams { max_distance_m: 1e-6, ..RemeshParams::new(0.05) };
    assert!(matches!(fault(&ball, &strict), SurfaceFault::RemeshStrays { .. }));
}

#[test]
fn the_distance_of_two_spheres() {
    let distance = surface_distance(&sphere(0.1, 4), &sphere(0.09, 4), 0.005);
    assert!((distance.largest_m() - 0.01).abs() < 1e-4, "{distance:?}");
    let moved = surface_distance(&cube(0.1), &cube(0.2), 0.01);
    assert!((moved.from_first_m - 0.1).abs() < 1e-12, "{moved:?}");
    assert!((moved.from_second_m - 0.1 * 3.0_f64.sqrt()).abs() < 1e-12, "{moved:?}");
}

/// A sphere with waves on it, and no feature: every vertex of the octahedron and of its refinements
/// lies on the waves.
fn bumpy(n: usize, height: f64, waves: [f64; 3]) -> SurfaceMesh {
    let onto = |p: &Point3<f64>| {
        let unit = p.coords / p.coords.norm();
        let bump =
            (waves[0] * unit.x).sin() + (waves[1] * unit.y).cos() * (waves[2] * unit.z).sin();
        Point3::from(unit * (0.1 * (1.0 + height * bump)))
    };
    let round = sphere(0.1, 0);
    let vertices = round.vertices().iter().map(onto).collect();
    let mut mesh = SurfaceMesh::new(vertices, round.triangles().to_vec()).unwrap();
    for _ in 0..n {
        mesh = mesh.refined(&FaceCurve::Onto(&onto)).unwrap().mesh;
    }
    mesh
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn bumpy_spheres_stay_what_they_are(
        height in 0.0..0.12,
        waves in [1.0..5.0, 1.0..5.0, 1.0..5.0],
        target_edge_m in 0.008..0.02,
    ) {
        let ball = bumpy(4, height, waves);
        let params = RemeshParams { max_volume_change: 0.05, ..RemeshParams::new(target_edge_m) };
        let (fine, info) = remesh(&ball, &params).unwrap();
        let defects = SurfaceDefects::of(&fine);
        prop_assert!(defects.is_closed(), "{defects}");
        prop_assert_eq!(QualityReport::of(&fine).genus, Some(0));
        prop_assert!(info.on_target_share > 0.9, "{:?}", info);
        prop_assert!(info.volume_change().abs() < 0.03, "{:?}", info);
        prop_assert_eq!(info.n_features, [0, 0]);
    }
}
