//! Walks on small skins.

use super::*;
use crate::skin::{SkinFaces, SkinParams};
use nalgebra::Point3;

/// A strip of 2 × n unit squares, each of two triangles, bent by `fold_rad` at x = 1.
fn strip(n: u32, fold_rad: f64) -> Skin {
    let mut nodes = Vec::new();
    for i in 0..=n {
        for j in 0..3 {
            let x = f64::from(i);
            let beyond = (x - 1.0).max(0.0);
            let (s, c) = fold_rad.sin_cos();
            nodes.push(Point3::new(x.min(1.0) + beyond * c, f64::from(j), -beyond * s));
        }
    }
    let mut faces = Vec::new();
    for i in 0..n {
        for j in 0..2 {
            let at = |i: u32, j: u32| 3 * i + j;
            faces.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            faces.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    Skin::new(nodes, SkinFaces::Linear(&faces), None, &SkinParams::default()).unwrap()
}

fn start(skin: &Skin) -> SkinPoint {
    SkinPoint::new(skin, 0, [0.5, 0.3, 0.2]).unwrap()
}

#[test]
fn a_straight_line_unfolds() {
    let flat = strip(4, 0.0);
    let bent = strip(4, 0.6);
    let step = Vector3::new(2.3, 0.7, 0.0);
    let from = start(&flat);
    let on_flat = flat.walk(&from, &step, AtWall::Stop);
    let on_bent = bent.walk(&from, &step, AtWall::Stop);
    assert_eq!((on_flat.end, on_bent.end), (WalkEnd::Done, WalkEnd::Done));
    let reached = flat.position(&on_flat.point);
    let wanted = flat.position(&from) + step;
    assert!((reached - wanted).norm() < 1e-12, "{reached} {wanted}");
    assert_eq!(on_flat.point.face(), on_bent.point.face());
    for i in 0..3 {
        let miss = on_flat.point.bary()[i] - on_bent.point.bary()[i];
        assert!(miss.abs() < 1e-12);
    }
}

#[test]
fn walls_stop_or_deflect() {
    let skin = strip(4, 0.0);
    let step = Vector3::new(1.0, 9.0, 0.0);
    let stopped = skin.walk(&start(&skin), &step, AtWall::Stop);
    assert_eq!(stopped.end, WalkEnd::Rim);
    assert!((skin.position(&stopped.point).y - 2.0).abs() < 1e-12);
    let slid = skin.walk(&start(&skin), &step, AtWall::Slide);
    let (from, to) = (skin.position(&start(&skin)), skin.position(&slid.point));
    assert!((to.y - 2.0).abs() < 1e-12 && (to.x - from.x - 1.0).abs() < 1e-12, "{to}");
}

#[test]
fn a_walk_into_a_corner_ends_there() {
    let flat = strip(4, 0.0);
    let barred = flat.clone().forbid(&[1, 5]).unwrap();
    for (skin, step, corner) in [
        (&flat, [9.0, 7.0], [4.0, 2.0]),
        (&flat, [-3.0, 9.0], [0.0, 2.0]),
        // an angle of 45° between two faces that are barred
        (&barred, [0.6, 3.0], [1.0, 1.0]),
    ] {
        let step = Vector3::new(step[0], step[1], 0.0);
        let (walk, n_met) = skin.walk_counting(&start(skin), &step, AtWall::Slide, 99);
        let miss = skin.position(&walk.point) - Point3::new(corner[0], corner[1], 0.0);
        assert!(miss.norm() < 1e-12 && n_met < 20, "{n_met} edges: {walk:?}");
    }
}

#[test]
fn folds_and_forbidden_faces_are_walls() {
    let step = Vector3::new(1.5, 0.0, 0.0);
    let folded = strip(3, 1.2);
    assert_eq!(folded.walk(&start(&folded), &step, AtWall::Stop).end, WalkEnd::Fold);
    let barred = strip(3, 0.0).forbid(&[4, 5]).unwrap();
    let walk = barred.walk(&start(&barred), &step, AtWall::Stop);
    assert_eq!(walk.end, WalkEnd::Forbidden);
    assert!((barred.position(&walk.point).x - 1.0).abs() < 1e-12);
}

#[test]
fn there_and_back() {
    let skin = strip(5, 0.7);
    let from = start(&skin);
    let there = skin.walk(&from, &Vector3::new(1.9, 0.9, 0.0), AtWall::Stop);
    assert_eq!(there.end, WalkEnd::Done);
    let (s, c) = 0.7_f64.sin_cos();
    let back = Vector3::new(-1.9 * c, -0.9, 1.9 * s);
    let again = skin.walk(&there.point, &back, AtWall::Stop);
    let miss = skin.position(&again.point) - skin.position(&from);
    assert!(miss.norm() < 1e-12, "{miss}");
}

/// The regular icosahedron of edges of about 1.05: 42° from face to face.
fn icosahedron() -> Skin {
    let (x, z) = (0.525_731_112_119_133_6, 0.850_650_808_352_04);
    let nodes = [
        [-x, 0.0, z],
        [x, 0.0, z],
        [-x, 0.0, -z],
        [x, 0.0, -z],
        [0.0, z, x],
        [0.0, z, -x],
        [0.0, -z, x],
        [0.0, -z, -x],
        [z, x, 0.0],
        [-z, x, 0.0],
        [z, -x, 0.0],
        [-z, -x, 0.0],
    ];
    let faces = [
        [0, 1, 4],
        [0, 4, 9],
        [9, 4, 5],
        [4, 8, 5],
        [4, 1, 8],
        [8, 1, 10],
        [8, 10, 3],
        [5, 8, 3],
        [5, 3, 2],
        [2, 3, 7],
        [7, 3, 10],
        [7, 10, 6],
        [7, 6, 11],
        [11, 6, 0],
        [0, 6, 1],
        [6, 10, 1],
        [9, 11, 0],
        [9, 2, 11],
        [9, 5, 2],
        [7, 11, 2],
    ];
    Skin::new(
        nodes.map(Point3::from).to_vec(),
        SkinFaces::Linear(&faces),
        None,
        &SkinParams::default(),
    )
    .unwrap()
}

#[test]
fn a_walk_from_a_corner_gets_on_whatever_its_direction() {
    let skin = icosahedron();
    let corners = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for face in 0..20 {
        for bary in corners.into_iter().chain([[0.5, 0.5, 0.0], [0.0, 0.4, 0.6]]) {
            let from = SkinPoint::new(&skin, face, bary).unwrap();
            let [t1, t2] = skin.tangents(&from);
            let frame = skin.frame(&from);
            let turned = (0..24).map(|i| {
                let (sin, cos) = (f64::from(i) * std::f64::consts::PI / 12.0).sin_cos();
                t1 * cos + t2 * sin
            });
            let along_edges = (0..3).flat_map(|edge| {
                let along = frame.edge_direction(edge);
                [along, -along]
            });
            for step in turned.chain(along_edges) {
                let walk = skin.walk_at_most(&from, &(step * 0.7), AtWall::Stop, 8);
                assert_eq!(walk.end, WalkEnd::Done);
                assert!(
                    (walk.walked_m - 0.7).abs() < 1e-12,
                    "face {face}, {bary:?}, {step:?}: {walk:?}"
                );
            }
        }
    }
}
