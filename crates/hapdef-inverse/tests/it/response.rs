//! The response map: smooth, right at second and third order, its gradient the derivative.

use crate::world;

use hapdef_inverse::{AtWall, InverseError, ResponseMap, ResponseParams, Skin, TipMeans};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use world::{World, barrel};

/// Largest difference of the map from the gauges' formulas, over points drawn.
fn worst(is_quadratic: bool, n: u32) -> f64 {
    let world = World::on(barrel(n, n, is_quadratic), 10, 50, 3);
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let skin = world.map.skin();
    let mut worst = 0.0_f64;
    for _ in 0..2000 {
        let point = world::draw_point(skin, &mut rng);
        let x = skin.position(&point);
        let out = world::RADIUS_M / x.x.hypot(x.z);
        let on_barrel = nalgebra::Point3::new(x.x * out, x.y, x.z * out);
        for (g, gauge) in world.map.normal(&point).iter().zip(&world.gauges) {
            worst = worst.max((g - gauge.normal(&on_barrel)).abs());
        }
    }
    worst
}

#[test]
fn six_node_faces_converge_with_third_order_and_three_node_faces_with_second_or_better() {
    for (is_quadratic, coarse, least) in [(true, 20, 2.5), (false, 40, 1.8)] {
        let (a, b) = (worst(is_quadratic, coarse), worst(is_quadratic, 2 * coarse));
        let order = (a / b).log2();
        assert!(order > least, "quadratic {is_quadratic}: {a:.4} then {b:.4}, order {order:.2}");
    }
}

/// The cubic scheme reproduces a quadratic field on a flat skin, where fitted gradients are exact.
#[test]
fn cubics_are_exact_for_quadratics_on_a_plane() {
    let (n, h) = (8_u32, 0.01);
    let mut nodes = Vec::new();
    let mut faces = Vec::new();
    for j in 0..=n {
        for i in 0..=n {
            let shift = 0.2 * h * f64::from((i * 7 + j * 3) % 5) / 5.0;
            nodes.push(nalgebra::Point3::new(
                h * f64::from(i) + shift,
                h * f64::from(j) - shift,
                0.0,
            ));
            if i < n && j < n {
                let at = j * (n + 1) + i;
                faces.push([at, at + 1, at + n + 2]);
                faces.push([at, at + n + 2, at + n + 1]);
            }
        }
    }
    let field = |x: f64, y: f64| 1.0 + 30.0 * x - 20.0 * y + 900.0 * x * y + 400.0 * x * x;
    let adjoint: Vec<_> = nodes.iter().map(|p| Vector3::new(0.0, 0.0, -field(p.x, p.y))).collect();
    let faces = hapdef_inverse::SkinFaces::Linear(&faces);
    let skin = Skin::new(nodes, faces, None, &Default::default()).unwrap();
    let map = ResponseMap::from_nodal(skin, 1, &adjoint, &ResponseParams::default()).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for _ in 0..500 {
        let point = world::draw_point(map.skin(), &mut rng);
        let x = map.skin().position(&point);
        let miss = map.normal(&point)[0] - field(x.x, x.y);
        assert!(miss.abs() < 1e-9, "{miss:e} at {x}");
    }
}

/// Half the spacing of the values with faces of the same size: an error that falls with its third power
/// falls to an eighth, and both maps are the same at the nodes.
#[test]
fn subdivided_faces_have_an_eighth_of_the_error() {
    let world = World::on(barrel(28, 22, true), 10, 20, 3);
    let fine = world.subdivided();
    let skin = world.map.skin();
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let (mut coarse_2, mut fine_2) = (0.0, 0.0);
    for _ in 0..2000 {
        let point = world::draw_point(skin, &mut rng);
        let x = skin.position(&point);
        let gauges = world.gauges.iter().map(|gauge| -gauge.response(&x).dot(&skin.normal(&point)));
        for (gauge, truth) in gauges.enumerate() {
            coarse_2 += (world.map.normal(&point)[gauge] - truth).powi(2);
            fine_2 += (fine.normal(&point)[gauge] - truth).powi(2);
        }
    }
    let ratio = f64::sqrt(coarse_2 / fine_2);
    assert!((6.0..12.0).contains(&ratio), "{ratio}");
    for node in skin.node_points().into_iter().flatten() {
        for (a, b) in world.map.vector(&node).iter().zip(fine.vector(&node)) {
            assert!((a - b).norm() <= 1e-12 * a.norm(), "{a} and {b}");
        }
    }
}

#[test]
fn a_map_on_subdivided_faces_is_made_again_of_its_values_and_refused_with_fewer() {
    let world = World::on(barrel(8, 6, true), 4, 20, 3);
    let map = world.subdivided();
    let (skin, values) = (map.skin().clone(), map.nodal());
    let again = ResponseMap::from_values(skin.clone(), 4, &values).unwrap();
    assert_eq!(again.nodal(), values);
    assert_eq!(again.n_values(), skin.subdivided_points().len());
    let refused = ResponseMap::from_values(skin, 4, &values[4..]);
    assert!(matches!(refused, Err(InverseError::Length { .. })));
    let linear = World::on(barrel(8, 6, false), 4, 20, 3);
    let skin = linear.map.skin().clone();
    assert!(skin.subdivided_points().is_empty());
    assert!(ResponseMap::from_subdivided(skin, 4, &values).is_err());
}

#[test]
fn the_gradient_is_the_derivative_along_the_skin() {
    for (is_quadratic, is_fine) in [(true, false), (true, true), (false, false)] {
        let mut world = World::on(barrel(20, 16, is_quadratic), 10, 50, 3);
        if is_fine {
            world.map = std::sync::Arc::new(world.subdivided());
        }
        let skin = world.map.skin();
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let h = 1e-7;
        for _ in 0..200 {
            let point = world::draw_point(skin, &mut rng);
            let is_near = |line: f64| point.bary().iter().any(|b| (b - line).abs() < 0.01);
            if is_near(0.0) || is_near(0.5) {
                continue;
            }
            let normal = world.map.normal_gradient(&point);
            let vector = world.map.vector_gradient(&point);
            for (axis, t) in skin.tangents(&point).into_iter().enumerate() {
                let up = skin.walk(&point, &(t * h), AtWall::Stop).point;
                let down = skin.walk(&point, &(-t * h), AtWall::Stop).point;
                for gauge in 0..10 {
                    let difference = world.map.normal(&up)[gauge] - world.map.normal(&down)[gauge];
                    let (found, expected) = (normal[axis][gauge], difference / (2.0 * h));
                    assert!(
                        (found - expected).abs() < 1e-4 * (1.0 + expected.abs()),
                        "∂{axis} of gauge {gauge}: {found} and {expected}"
                    );
                    let difference = world.map.vector(&up)[gauge] - world.map.vector(&down)[gauge];
                    let miss = vector[axis][gauge] - difference / (2.0 * h);
                    assert!(miss.norm() < 1e-4 * (1.0 + difference.norm() / h));
                }
            }
        }
    }
}

/// A tip of radius r averages a field with curvature κ to f + κ r² / 16 on a plane: the mean square
/// distance under (1 − (d/r)²)² is r²/4.
#[test]
fn a_tip_averages_over_its_pressure() {
    let world = World::new(1, 20, 3);
    let skin = world.map.skin().clone();
    let radius_m = 0.004;
    let field = |y: f64| 3.0 + 1e4 * (y - 0.05).powi(2);
    let adjoint: Vec<_> =
        skin.nodes().iter().zip(skin.normals()).map(|(x, n)| -n * field(x.y)).collect();
    let params = ResponseParams { tip_radius_m: radius_m };
    let nodes = skin.node_points();
    let map = ResponseMap::from_nodal(skin, 1, &adjoint, &params).unwrap();
    let mut n_checked = 0;
    for point in nodes.into_iter().flatten() {
        let y = map.skin().position(&point).y;
        if (0.01..0.1).contains(&y) {
            // the direction turns by d/R under the tip: the mean of its cosine is 1 − r²/(16 R²)
            let turn = 1.0 - (radius_m / world::RADIUS_M).powi(2) / 16.0;
            let expected = field(y) * turn + 1e4 * radius_m.powi(2) / 8.0;
            let found = map.normal(&point)[0];
            assert!((found - expected).abs() < 3e-3, "{found} and {expected}");
            n_checked += 1;
        }
    }
    assert!(n_checked > 100);
}

/// A map made under a tip is made again of its own nodal values, both kinds of faces.
#[test]
fn nodal_values_make_the_same_map() {
    for is_quadratic in [true, false] {
        let world = World::on(barrel(28, 22, is_quadratic), 10, 20, 3);
        let skin = world.map.skin().clone();
        let tip = ResponseParams { tip_radius_m: 0.004 };
        let map = ResponseMap::from_nodal(skin.clone(), 10, &world.map.nodal(), &tip).unwrap();
        let again = ResponseMap::from_nodal(skin, 10, &map.nodal(), &ResponseParams::default());
        let again = again.unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(6);
        let mut under_tip = 0.0_f64;
        for _ in 0..500 {
            let point = world::draw_point(map.skin(), &mut rng);
            let (g, same) = (map.normal(&point), again.normal(&point));
            let size = g.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            for ((g, same), sharp) in g.iter().zip(&same).zip(world.map.normal(&point)) {
                assert!((g - same).abs() <= 1e-12 * size, "{g} and {same}");
                under_tip = under_tip.max((g - sharp).abs() / size);
            }
            for (v, same) in map.vector(&point).iter().zip(again.vector(&point)) {
                assert!((v - same).norm() <= 1e-12 * size, "{v} and {same}");
            }
        }
        assert!(under_tip > 1e-3, "the tip changes nothing: {under_tip:e}");
    }
}

#[test]
fn the_nearest_point_is_found() {
    let skin = barrel(20, 16, true);
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for _ in 0..50 {
        let point = world::draw_point(&skin, &mut rng);
        let x = skin.position(&point) + skin.normal(&point) * 1e-3;
        let (found, distance_m) = skin.nearest(&x).unwrap();
        let miss = (skin.position(&found) - skin.position(&point)).norm();
        assert!(miss < 2e-5 && (distance_m - 1e-3).abs() < 1e-6, "{miss:e}");
    }
}

/// A mean of a constant field is the constant, to the rim, whatever the tip's size; tips are a skin's own.
#[test]
fn tips_average_constants_to_themselves_and_fit_one_skin() {
    let skin = World::on(barrel(28, 22, true), 1, 20, 3).map.skin().clone();
    let constant = vec![Vector3::new(1.0, -2.0, 3.0); skin.n_nodes()];
    for tip_radius_m in [0.0, 1e-5, 0.002, 0.05] {
        let tips = TipMeans::new(&skin, tip_radius_m).unwrap();
        let map = ResponseMap::under_tips(skin.clone(), 1, &constant, &tips).unwrap();
        for mean in map.nodal() {
            assert!((mean - constant[0]).norm() < 1e-13, "{tip_radius_m}: {mean}");
        }
    }
    let other = World::on(barrel(20, 22, true), 1, 20, 3).map.skin().clone();
    let tips = TipMeans::new(&other, 0.002).unwrap();
    let refused = ResponseMap::under_tips(skin.clone(), 1, &constant, &tips);
    assert!(matches!(refused, Err(InverseError::Length { .. })));
    assert!(TipMeans::new(&skin, -1.0).is_err());
}
