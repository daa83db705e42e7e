//! Walls extruded from skins: volumes, layers, folds; refined surfaces.

use crate::surface_common;

use hapdef_mesh::{
    ExtrudeParams, Extrusion, FaceCurve, MeshError, ShellSurface, SkinSide, SurfaceFault,
    SurfaceMesh, extrude,
};
use nalgebra::Point3;
use proptest::prelude::*;
use surface_common::{ball_m3, cube, sphere};

const RADIUS_M: f64 = 0.1;
const WALL_M: f64 = 0.01;

fn onto_sphere(p: &Point3<f64>) -> Point3<f64> {
    Point3::from(p.coords * (RADIUS_M / p.coords.norm()))
}

fn wall(
    skin: &SurfaceMesh,
    wall_m: f64,
    params: &ExtrudeParams<'_>,
) -> Result<Extrusion, MeshError> {
    extrude(skin, &vec![wall_m; skin.vertices().len()], params)
}

fn outer(n_layers: usize, curve: FaceCurve<'_>) -> ExtrudeParams<'_> {
    ExtrudeParams { side: SkinSide::Outer, n_layers, curve }
}

fn ball_error(n: usize, curve: FaceCurve<'_>) -> f64 {
    let wall = wall(&sphere(RADIUS_M, n), WALL_M, &outer(1, curve)).unwrap();
    (wall.volume_m3 / ball_m3(RADIUS_M, RADIUS_M - WALL_M) - 1.0).abs()
}

#[test]
fn a_cube_s_wall_has_its_volume() {
    let skin = cube(0.1);
    for (side, exact) in [
        (SkinSide::Outer, 0.1_f64.powi(3) - 0.08_f64.powi(3)),
        (SkinSide::Middle, 0.11_f64.powi(3) - 0.09_f64.powi(3)),
        (SkinSide::Inner, 0.12_f64.powi(3) - 0.1_f64.powi(3)),
    ] {
        for n_layers in 1..4 {
            let params = ExtrudeParams { side, ..outer(n_layers, FaceCurve::Flat) };
            let wall = wall(&skin, WALL_M, &params).unwrap();
            assert!((wall.volume_m3 / exact - 1.0).abs() < 1e-12, "{} {exact}", wall.volume_m3);
            assert_eq!(wall.mesh.elements().len(), 12 * 3 * n_layers);
            assert_eq!(wall.mesh.boundary().faces.len(), 24);
        }
    }
}

/// Quadratic faces with mid-side nodes on the sphere: the volume converges with order 4, flat ones
/// with order 2.
#[test]
fn a_sphere_s_wall_converges() {
    let order = |curve| (ball_error(2, curve) / ball_error(3, curve)).log2();
    let (curved, flat) = (order(FaceCurve::Onto(&onto_sphere)), order(FaceCurve::Flat));
    assert!((curved - 4.0).abs() < 0.3, "observed order {curved}");
    assert!((flat - 2.0).abs() < 0.2, "observed order {flat}");
    let error = ball_error(3, FaceCurve::Onto(&onto_sphere));
    assert!(error < 1e-4, "{error:e}");
    let normals = ball_error(3, FaceCurve::PointNormal { feature_angle_rad: 0.7 });
    assert!(normals < 0.05 * ball_error(3, FaceCurve::Flat), "{normals:e}");
}

#[test]
fn corner_nodes_are_where_they_should_be() {
    let skin = sphere(RADIUS_M, 2);
    let wall = wall(&skin, WALL_M, &outer(2, FaceCurve::Onto(&onto_sphere))).unwrap();
    for vertex in 0..skin.vertices().len() as u32 {
        for level in 0..3 {
            let radius_m = wall.mesh.position(wall.node(vertex, level)).coords.norm();
            let exact = RADIUS_M - 0.5 * WALL_M * level as f64;
            assert!((radius_m - exact).abs() < 1e-4 * WALL_M, "{radius_m} {exact}");
        }
    }
    assert!(wall.least_jacobian_m3 > 0.0);
}

/// Point-normal faces leave what is flat between sharp edges flat.
#[test]
fn a_cube_stays_a_cube_with_point_normal_faces() {
    let curve = FaceCurve::PointNormal { feature_angle_rad: 0.7 };
    let fine = cube(0.1).refined(&curve).unwrap().mesh.refined(&curve).unwrap().mesh;
    assert!((fine.signed_volume_m3() / 1e-3 - 1.0).abs() < 1e-13);
    let wall = wall(&fine, WALL_M, &outer(1, curve)).unwrap();
    let exact = 0.1_f64.powi(3) - 0.08_f64.powi(3);
    assert!((wall.volume_m3 / exact - 1.0).abs() < 1e-12, "{}", wall.volume_m3);
}

#[test]
fn a_wall_thicker_than_its_skin_allows_folds() {
    let skin = sphere(RADIUS_M, 1);
    let fault = |wall_m, n_layers| match wall(&skin, wall_m, &outer(n_layers, FaceCurve::Flat)) {
        Err(MeshError::Surface(fault)) => fault,
        other => panic!("{other:?}"),
    };
    assert!(matches!(fault(0.15, 1), SurfaceFault::ExtrusionFolds { triangle: 0, layer: 0, .. }));
    assert!(matches!(fault(0.15, 3), SurfaceFault::ExtrusionFolds { layer: 1 | 2, .. }));
    assert!(matches!(fault(0.01, 0), SurfaceFault::Parameter { name: "n_layers", .. }));
    assert!(matches!(fault(f64::NAN, 1), SurfaceFault::Thickness { node: 0, .. }));
    let short = extrude(&skin, &[0.01], &outer(1, FaceCurve::Flat));
    assert!(matches!(short, Err(MeshError::Surface(SurfaceFault::ThicknessCount { .. }))));
}

#[test]
fn refined_surfaces_keep_what_they_stand_for() {
    let block = cube(0.1).refined(&FaceCurve::Flat).unwrap();
    assert_eq!((block.mesh.triangles().len(), block.halved_edges.len()), (48, 18));
    assert!((block.mesh.signed_volume_m3() / 1e-3 - 1.0).abs() < 1e-14);
    let ball = sphere(RADIUS_M, 2);
    let off = |curve: FaceCurve<'_>| {
        let fine = ball.refined(&curve).unwrap().mesh;
        let radii = fine.vertices().iter().map(|p| (p.coords.norm() / RADIUS_M - 1.0).abs());
        radii.fold(0.0, f64::max)
    };
    let normals = off(FaceCurve::PointNormal { feature_angle_rad: 0.7 });
    assert!(off(FaceCurve::Onto(&onto_sphere)) < 1e-14);
    assert!(normals < 0.1 * off(FaceCurve::Flat), "{normals}");
    let thickness: Vec<f64> = ball.vertices().iter().map(|p| 0.005 + 0.01 * p.x).collect();
    let shell = ShellSurface::from_skin(&ball, &thickness, SkinSide::Middle).unwrap();
    let fine = shell.refined(&FaceCurve::Flat).unwrap();
    for (p, t) in fine.nodes().iter().zip(fine.thickness_m()) {
        assert!((t - 0.005 - 0.01 * p.x).abs() < 1e-15);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    /// Steiner's formula for a convex body: the layer outside has volume A t + M t² + O(t³), M > 0,
    /// the layer inside A t − M t² + O(t³), and half outside and half inside lies between them.
    /// Against A t itself a thin layer on facets is off by their own error, whatever the side.
    #[test]
    fn layers_of_ellipsoids_grow_outward_and_shrink_inward(
        axes in [0.5..1.5, 0.5..1.5, 0.5..1.5],
        wall_m in 1e-4..3e-3,
        n_layers in 1_usize..3,
    ) {
        let ball = sphere(RADIUS_M, 2);
        let stretched = ball.vertices().iter().map(|p| Point3::new(p.x * axes[0], p.y * axes[1], p.z * axes[2]));
        let skin = SurfaceMesh::new(stretched.collect(), ball.triangles().to_vec()).unwrap();
        let volume = |side| {
            let params = ExtrudeParams { side, ..outer(n_layers, FaceCurve::Flat) };
            wall(&skin, wall_m, &params).unwrap().volume_m3
        };
        let plain = skin.area_m2() * wall_m;
        let [inner, middle, outer] = [SkinSide::Inner, SkinSide::Middle, SkinSide::Outer].map(volume);
        prop_assert!(inner > middle && middle > outer, "{inner:e} {middle:e} {outer:e}");
        prop_assert!((middle / plain - 1.0).abs() < 0.01, "{middle:e} of {plain:e}; {inner:e} {outer:e}");
    }
}
