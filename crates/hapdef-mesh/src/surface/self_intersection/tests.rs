//! Known crossings, and brute force by another method.

use nalgebra::{Matrix4, Point3, Vector3};
use proptest::prelude::*;

use super::*;
use crate::surface::crossing::number;
use crate::surface::triangles::tests::{cuboid, sphere};

fn tetrahedron(shift: [f64; 3]) -> SurfaceMesh {
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let place = |c: [f64; 3]| Point3::from(c) + Vector3::from(shift);
    let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    SurfaceMesh::new(corners.map(place).to_vec(), triangles).unwrap()
}

/// Both surfaces in one, welded.
fn together(a: &SurfaceMesh, b: &SurfaceMesh) -> SurfaceMesh {
    let n = a.vertices().len() as u32;
    let shifted = b.triangles().iter().map(|t| t.map(|v| v + n));
    let triangles = a.triangles().iter().copied().chain(shifted).collect();
    let both = SurfaceMesh::new([a.vertices(), b.vertices()].concat(), triangles).unwrap();
    both.weld(0.0).unwrap().0
}

#[track_caller]
fn check(mesh: &SurfaceMesh, expected: &[[usize; 2]]) -> Vec<Crossing> {
    let found = self_intersections(mesh);
    let pairs: Vec<[usize; 2]> = found.iter().map(|c| c.triangles).collect();
    assert_eq!(pairs, expected);
    found
}

#[test]
fn closed_surfaces_have_none() {
    check(&sphere(4), &[]);
    check(&cuboid(1.0, 2.0, 3.0), &[]);
}

/// The corner at (0.2, 0.2, 0.2) of the second looks out of the first's slanted face, and its three
/// faces go through that.
#[test]
fn crossing_tetrahedra() {
    let mesh = together(&tetrahedron([0.0; 3]), &tetrahedron([0.2; 3]));
    for crossing in check(&mesh, &[[3, 4], [3, 5], [3, 6]]) {
        let place = crossing.place;
        assert!((place.x + place.y + place.z - 1.0).abs() < 1e-12, "{place}");
        let least = place.x.min(place.y).min(place.z);
        assert!((least - 0.2).abs() < 1e-12, "{place}");
        // From one edge of the second to the next: (0.2, 0.2, 0.6) to (0.2, 0.6, 0.2).
        assert!((crossing.length_m - 0.4 * 2.0_f64.sqrt()).abs() < 1e-12);
    }
}

/// Along a common edge, at a common corner, corner on face, edge on edge, face on face outside.
#[test]
fn touching_is_no_crossing() {
    let first = tetrahedron([0.0; 3]);
    let turned = |map: Matrix4<f64>| first.transformed(&map).unwrap();
    let about_x = turned(Matrix4::new_nonuniform_scaling(&Vector3::new(1.0, -1.0, -1.0)));
    check(&together(&first, &about_x), &[]);
    let about_corner = turned(Matrix4::new_scaling(-1.0));
    check(&together(&first, &about_corner), &[]);
    let on_face = hanging(0.0);
    check(&together(&first, &on_face), &[]);
    let along_edge =
        about_x.transformed(&Matrix4::new_translation(&Vector3::new(0.5, 0.0, 0.0))).unwrap();
    check(&together(&first, &along_edge), &[]);
}

/// Coplanar faces that overlap count, also where nothing goes through anything else.
#[test]
fn overlapping_in_one_plane() {
    let below = tetrahedron([0.0; 3])
        .transformed(&Matrix4::new_nonuniform_scaling(&Vector3::new(1.0, 1.0, -1.0)))
        .unwrap();
    let aside = tetrahedron([0.25, 0.25, 0.0]);
    check(&together(&below, &aside), &[[0, 4]]);
    check(&together(&below, &tetrahedron([1.0, 0.25, 0.0])), &[]);
}

/// A strip along x that is folded back through itself.
#[test]
fn a_folded_strip() {
    let profile = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, -1.0]];
    let vertices =
        profile.iter().flat_map(|[x, z]| [Point3::new(*x, 0.0, *z), Point3::new(*x, 1.0, *z)]);
    let squares = (0..3_u32).flat_map(|i| {
        let a = 2 * i;
        [[a, a + 2, a + 1], [a + 1, a + 2, a + 3]]
    });
    let mesh = SurfaceMesh::new(vertices.collect(), squares.collect()).unwrap();
    for crossing in check(&mesh, &[[0, 4], [1, 4], [1, 5]]) {
        let place = crossing.place;
        assert!((place.x - 2.0).abs() < 1e-12 && place.z.abs() < 1e-12, "{place}");
    }
}

/// One part in 10⁸ of the extent is a rounding.
#[test]
fn roundings_only_touch() {
    let at = |height| together(&tetrahedron([0.0; 3]), &hanging(height));
    check(&at(1e-8), &[]);
    check(&at(1e-3), &[[0, 4], [0, 5], [0, 6]]);
}

/// A tetrahedron whose corner is `height` above the others' bottom face, the rest below.
fn hanging(height: f64) -> SurfaceMesh {
    let corners = [[0.25, 0.25, height], [0.3, 0.2, -1.0], [0.3, 0.3, -1.0], [0.2, 0.25, -1.0]];
    let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    SurfaceMesh::new(corners.map(Point3::from).to_vec(), triangles).unwrap()
}

/// 1500 plates upright on a line, each through 1500 lying ones.
#[test]
fn a_tangle_ends_at_a_million_pairs() {
    let n = 1500;
    let plate = |i: usize| {
        let at = i as f64 / n as f64;
        let (low, high) = (-1.0, 2.0);
        match i % 2 {
            0 => [[at, low, low], [at, high, low], [at, 0.5, high]],
            _ => [[low, low, at], [high, low, at], [0.5, high, at]],
        }
    };
    let vertices = (0..2 * n).flat_map(plate).map(Point3::from).collect();
    let triangles = (0..2 * n as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
    let mesh = SurfaceMesh::new(vertices, triangles.collect()).unwrap();
    let found = self_intersections(&mesh);
    assert_eq!(number(&found), "at least 1000000");
}

/// An edge of one goes through the inside of the other, by plain rounded arithmetic (Möller and
/// Trumbore, J. Graphics Tools 2(1), 1997).
fn pierces(one: &[Point3<f64>; 3], two: &[Point3<f64>; 3]) -> bool {
    let [a, b, c] = two;
    let (ab, ac) = (b - a, c - a);
    (0..3).any(|i| {
        let (from, way) = (one[i], one[(i + 1) % 3] - one[i]);
        let p = way.cross(&ac);
        let determinant = ab.dot(&p);
        let t = from - a;
        let u = t.dot(&p) / determinant;
        let q = t.cross(&ab);
        let v = way.dot(&q) / determinant;
        let s = ac.dot(&q) / determinant;
        u > 0.0 && v > 0.0 && u + v < 1.0 && s > 0.0 && s < 1.0
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn brute_force_finds_the_same_pairs(
        coordinates in prop::collection::vec([-1.0..1.0, -1.0..1.0, -1.0..1.0], 60),
        indices in prop::collection::vec([0..60_u32, 0..60_u32, 0..60_u32], 40),
    ) {
        let vertices = coordinates.into_iter().map(Point3::from).collect();
        let mesh = SurfaceMesh::new(vertices, indices).unwrap();
        let mut expected = Vec::new();
        for a in 0..40 {
            for b in a + 1..40 {
                let [p, q] = [a, b].map(|t| mesh.corners(t));
                if is_partner(&mesh, a, b) && (pierces(&p, &q) || pierces(&q, &p)) {
                    expected.push([a, b]);
                }
            }
        }
        let found: Vec<_> = self_intersections(&mesh).iter().map(|c| c.triangles).collect();
        prop_assert_eq!(found, expected);
    }

    /// On a coarse lattice nearly everything is degenerate: turned axes, a mirror, other first
    /// corners and the pair's order change nothing.
    #[test]
    fn degenerate_soups_are_judged_alike_in_any_frame(
        coordinates in prop::collection::vec([0..4_i8, 0..4_i8, 0..4_i8], 30),
        indices in prop::collection::vec([0..30_u32, 0..30_u32, 0..30_u32], 30),
    ) {
        let at = |c: &[i8; 3]| Point3::from(c.map(f64::from));
        let vertices: Vec<_> = coordinates.iter().map(at).collect();
        let mesh = SurfaceMesh::new(vertices.clone(), indices.clone()).unwrap();
        let found = self_intersections(&mesh);
        let turned = vertices.iter().map(|p| Point3::new(-p.z, p.x, p.y)).collect();
        let cycled = indices.iter().map(|[a, b, c]| [*b, *a, *c]).collect();
        let other = self_intersections(&SurfaceMesh::new(turned, cycled).unwrap());
        let pairs = |list: &[Crossing]| list.iter().map(|c| c.triangles).collect::<Vec<_>>();
        prop_assert_eq!(pairs(&found), pairs(&other));
        for crossing in &found {
            let [p, q] = crossing.triangles.map(|t| mesh.corners(t));
            prop_assert!(pair::overlap([p, q]).is_some() && pair::overlap([q, p]).is_some());
        }
    }
}
