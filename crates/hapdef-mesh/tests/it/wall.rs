//! Skin, wall, gauge patches and gauge places on tubes of known measures.

use crate::solid_common;

use hapdef_mesh::{
    FeNodeId, MeshError, OuterSkinParams, RadialRegionParams, SkinRegion, Tet10Mesh, Tri6Face,
    clear_nodes, face_positions, farthest_nodes, gauge_patch, kuhn_block, outer_skin,
    radial_region, tri6, wall,
};
use nalgebra::{Point3, Vector3};
use solid_common::tube;

const HEIGHT_M: f64 = 0.06;

/// 36 mm outer radius, wall 1 mm.
fn limb() -> Tet10Mesh {
    tube([36, 10, 1], [0.035, 0.036], HEIGHT_M)
}

fn about_y() -> RadialRegionParams {
    RadialRegionParams {
        axis_point: Point3::origin(),
        axis_dir: Vector3::new(0.0, 3.0, 0.0),
        min_normal_dot_radial: 0.5,
        min_radius_m: 0.028,
        axial_range_m: (0.0, HEIGHT_M),
    }
}

fn skin(mesh: &Tet10Mesh) -> SkinRegion {
    radial_region(mesh, &mesh.boundary(), &about_y()).unwrap()
}

fn radius_m(p: Point3<f64>) -> f64 {
    p.x.hypot(p.z)
}

#[test]
fn the_radial_region_is_the_outside_of_a_tube() {
    let mesh = limb();
    let skin = skin(&mesh);
    assert_eq!(skin.faces.len(), 2 * 36 * 10);
    assert_eq!(skin.nodes.len(), 72 * 21);
    assert!(skin.nodes.is_sorted());
    for (node, normal) in skin.nodes.iter().zip(&skin.normals) {
        let p = mesh.position(*node);
        assert!((radius_m(p) - 0.036).abs() < 1e-12);
        let radial = Vector3::new(p.x, 0.0, p.z) / radius_m(p);
        assert!(normal.dot(&radial) > 0.9999, "{normal} {radial}");
        assert!((normal.norm() - 1.0).abs() < 1e-14);
    }
    let exact = std::f64::consts::TAU * 0.036 * HEIGHT_M;
    assert!((skin.area_m2(&mesh) / exact - 1.0).abs() < 1e-5);

    let half = RadialRegionParams { axial_range_m: (0.0, 0.5 * HEIGHT_M), ..about_y() };
    let half = radial_region(&mesh, &mesh.boundary(), &half).unwrap();
    assert_eq!(half.faces.len(), 36 * 10);
}

#[test]
fn the_skin_s_surface_has_a_vertex_per_surface_node() {
    let mesh = limb();
    let skin = skin(&mesh);
    let surface = skin.surface(&mesh).unwrap();
    assert_eq!((surface.vertices().len(), surface.triangles().len()), (72 * 21, 4 * 720));
    for (vertex, node) in surface.vertices().iter().zip(&skin.nodes) {
        assert_eq!(*vertex, mesh.position(*node));
    }
    for triangle in 0..surface.triangles().len() {
        let centre = nalgebra::center(&surface.corners(triangle)[0], &surface.corners(triangle)[1]);
        let outward = Vector3::new(centre.x, 0.0, centre.z);
        assert!(surface.area_normal_m2(triangle).dot(&outward) > 0.0);
    }
}

#[test]
fn limits_of_a_region_are_checked() {
    let mesh = limb();
    let try_with = |params| radial_region(&mesh, &mesh.boundary(), &params);
    let bad = [
        RadialRegionParams { axis_dir: Vector3::zeros(), ..about_y() },
        RadialRegionParams { axis_dir: Vector3::repeat(f64::NAN), ..about_y() },
        RadialRegionParams { min_radius_m: f64::NAN, ..about_y() },
        RadialRegionParams { min_normal_dot_radial: 1.0, ..about_y() },
        RadialRegionParams { axial_range_m: (0.1, 0.1), ..about_y() },
    ];
    for params in bad {
        let found = try_with(params.clone());
        assert!(matches!(found, Err(MeshError::RegionParams { .. })), "{params:?}");
    }
    let far = RadialRegionParams { min_radius_m: 1.0, ..about_y() };
    assert!(matches!(try_with(far), Err(MeshError::EmptySkin { .. })));
}

#[test]
fn the_outer_skin_is_outside_and_ends() {
    let mesh = limb();
    let boundary = mesh.boundary();
    let outer = outer_skin(&mesh, &boundary, &OuterSkinParams::default()).unwrap();
    let expected: Vec<Tri6Face> = boundary
        .faces
        .iter()
        .filter(|face| {
            let p = face_positions(&mesh, face);
            let normal = tri6::area_vector(&p, 0.3, 0.3).try_normalize(0.0).unwrap();
            let centre = tri6::position(&p, 0.3, 0.3);
            normal.y.abs() > 0.9 || radius_m(centre) > 0.0355
        })
        .copied()
        .collect();
    assert_eq!(outer.faces, expected);
    let none = OuterSkinParams { n_rays: 0, ..OuterSkinParams::default() };
    let found = outer_skin(&mesh, &boundary, &none);
    assert!(matches!(found, Err(MeshError::RegionParams { .. })));
}

#[test]
fn a_tube_s_wall_is_as_thick_as_it_is() {
    let mesh = limb();
    let boundary = mesh.boundary();
    let skin = skin(&mesh);
    let wall = wall(&mesh, &boundary, &skin, 1.5e-3).unwrap();
    assert_eq!(wall.inner_faces.len(), 2 * 36 * 10);
    for face in &wall.inner_faces {
        assert!(
            face.nodes.iter().all(|node| (radius_m(mesh.position(*node)) - 0.035).abs() < 1e-12)
        );
    }
    // flat pieces of the inner face cut the arc by at most 35 mm · (1 − cos 2.5°) = 33 µm
    for thickness_m in &wall.skin_thickness_m {
        assert!((1.0e-3..1.04e-3).contains(thickness_m), "{thickness_m}");
    }
    let quartiles = [0.25, 0.5, 0.75].map(|q| wall.thickness_quantile_m(q).unwrap());
    assert!(quartiles.is_sorted() && wall.thickness_quantile_m(1.1).is_none());

    let thin = hapdef_mesh::wall(&mesh, &boundary, &skin, 0.5e-3).unwrap();
    assert!(thin.inner_faces.is_empty());
    let found = hapdef_mesh::wall(&mesh, &boundary, &skin, f64::NAN);
    assert!(matches!(found, Err(MeshError::WallThickness { .. })));
    let other = tube([36, 3, 1], [0.035, 0.036], HEIGHT_M);
    let found = hapdef_mesh::wall(&other, &other.boundary(), &skin, 1e-3);
    assert!(matches!(found, Err(MeshError::OpenWall { .. })));
}

#[test]
fn a_patch_stays_on_its_side_of_a_thin_wall() {
    let mesh = limb();
    let boundary = mesh.boundary();
    for (glued_m, wall_m) in [(0.0351, 0.035), (0.0358, 0.036)] {
        let centre = Point3::new(0.0, 0.03, glued_m);
        let patch = gauge_patch(&mesh, &boundary.faces, &centre, 24, 0.5e-3).unwrap();
        assert_eq!(patch.nodes.len(), 24);
        for node in &patch.nodes {
            let r = radius_m(mesh.position(*node));
            assert!((r - wall_m).abs() < 1e-12, "a node of the other side: {r}");
        }
        assert!((patch.distance_to_wall_m - (glued_m - wall_m).abs()).abs() < 5e-5);
        assert!(patch.normal.z.abs() > 0.997);
        // ascending by distance, and no node of that side nearer than the last is left out
        let distance = |node: &FeNodeId| (mesh.position(*node) - centre).norm();
        assert!(patch.nodes.is_sorted_by(|a, b| distance(a) <= distance(b)));
        let farthest = distance(&patch.nodes[23]);
        let nearer = boundary
            .nodes()
            .into_iter()
            .filter(|n| {
                (radius_m(mesh.position(*n)) - wall_m).abs() < 1e-9 && distance(n) < farthest
            })
            .count();
        assert!(nearer <= 23, "{nearer}");
    }
}

#[test]
fn a_gauge_off_the_wall_is_refused_with_its_distance() {
    let mesh = limb();
    let faces = mesh.boundary().faces;
    let try_at = |centre, n| gauge_patch(&mesh, &faces, &centre, n, 1e-3);
    match try_at(Point3::new(0.0, 0.03, 0.030), 24) {
        Err(MeshError::GaugeOffWall { distance_m, max_distance_m, .. }) => {
            assert!((distance_m - 5e-3).abs() < 4e-5, "{distance_m}");
            assert_eq!(max_distance_m, 1e-3);
        }
        other => panic!("{other:?}"),
    }
    let nowhere = try_at(Point3::new(f64::NAN, 0.0, 0.0), 24);
    assert!(matches!(nowhere, Err(MeshError::GaugeOffWall { .. })));
    let no_wall = gauge_patch(&mesh, &[], &Point3::origin(), 24, f64::INFINITY);
    assert!(matches!(no_wall, Err(MeshError::GaugeOffWall { .. })));
    match try_at(Point3::new(0.0, 0.03, 0.035), 100_000) {
        Err(MeshError::GaugePatchTooSmall { expected: 100_000, found, .. }) => {
            // the wall within 60° of the gauge, not the whole inside
            assert!((300..1512).contains(&found), "{found}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn places_keep_clear_of_the_wall_s_edges_and_spread() {
    let mesh = kuhn_block([8, 8, 1], |p| Point3::new(0.08 * p.x, 0.08 * p.y, 1e-3 * p.z)).unwrap();
    let top: Vec<Tri6Face> = mesh
        .boundary()
        .faces
        .into_iter()
        .filter(|face| face.nodes.iter().all(|node| mesh.position(*node).z > 0.9e-3))
        .collect();
    let clear = clear_nodes(&mesh, &top, 15e-3 - 1e-9);
    // 5 mm between nodes: 11 × 11 of the 17 × 17 lie at least 15 mm inside
    assert_eq!(clear.len(), 11 * 11);
    let chosen = farthest_nodes(&mesh, &clear, 5);
    let corner = |node: &FeNodeId| {
        let p = mesh.position(*node);
        let at = |c: f64| (c - 0.015).abs() < 1e-9 || (c - 0.065).abs() < 1e-9;
        at(p.x) && at(p.y)
    };
    assert!(chosen[..4].iter().all(corner));
    assert!((mesh.position(chosen[4]) - Point3::new(0.04, 0.04, 1e-3)).norm() < 1e-9);
    assert_eq!(farthest_nodes(&mesh, &clear[..3], 9).len(), 3);
    assert!(farthest_nodes(&mesh, &[], 9).is_empty());
}
