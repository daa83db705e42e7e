//! Strain gauges: exact readings, reciprocity, refusals.

use crate::common;

use common::{E_PA, cantilever, close, mapped_box, shared, straight_box};
use hapdef_mesh::{GaugeId, Tet10Mesh, read_deck};
use hapdef_sim::{
    ElasticModel, ElasticParams, GaugeParams, GaugeSite, GaugeStrain, IsotropicMaterial, NodalLoad,
    SimError,
};
use nalgebra::{Matrix3, Point3, Vector3};
use proptest::prelude::*;

fn site(position: Point3<f64>, axis: Vector3<f64>) -> GaugeSite {
    GaugeSite { position, axis, length_m: 8e-3, width_m: 5e-3 }
}

fn gauge(mesh: &Tet10Mesh, site: &GaugeSite) -> Result<GaugeStrain, SimError> {
    GaugeStrain::new(mesh, &mesh.boundary().faces, site)
}

fn linear(mesh: &Tet10Mesh, grad: &Matrix3<f64>) -> Vec<Vector3<f64>> {
    mesh.nodes().iter().map(|p| grad * p.coords + Vector3::new(0.1, 0.2, 0.3)).collect()
}

proptest! {
    #![proptest_config(common::cases(48))]

    /// Under u = G x the reading is aᵀ sym(G) a, whatever the axis; a rotation reads nothing.
    #[test]
    fn uniform_strain_is_read_exactly(
        g in prop::array::uniform9(-1e-3..1e-3), angle in 0.0..6.3, x in 0.012..0.028, y in 0.012..0.028,
    ) {
        let mesh = straight_box([7, 5, 2], [0.04, 0.04, 0.01]);
        let axis = Vector3::new(f64::cos(angle), f64::sin(angle), 0.0);
        // lifted off the wall and tilted, as a site read from a drawing would be
        let site = site(Point3::new(x, y, 0.0105), axis * 3.0 + Vector3::z());
        let gauge = gauge(&mesh, &site).expect("on the wall");
        prop_assert_eq!(gauge.n_samples(), 40);
        prop_assert_eq!(gauge.lost_share(), 0.0);
        prop_assert!((gauge.normal() - Vector3::z()).norm() < 1e-12);
        prop_assert!((gauge.axis() - axis).norm() < 1e-12);
        let grad = Matrix3::from_row_slice(&g);
        let expected = (axis.transpose() * grad * axis).x;
        let found = gauge.strain(&linear(&mesh, &grad));
        prop_assert!((found - expected).abs() < 1e-12, "{found:e} against {expected:e}");
        let turn = grad - grad.transpose();
        let turned = gauge.strain(&linear(&mesh, &turn));
        prop_assert!(turned.abs() < 1e-12, "a rotation reads {turned:e}");
    }
}

#[test]
fn a_curved_wall_is_read_along_its_tangent() {
    // a quarter tube, radius 30 to 31 mm; hoop strain of u = α × (x, y, 0) is α everywhere
    let mesh = mapped_box([12, 1, 6], [1.5, 1e-3, 0.03], |p| {
        let r = 0.031 - p.y;
        Point3::new(r * p.x.cos(), r * p.x.sin(), p.z)
    });
    let at = |r: f64| Point3::new(r * 0.75_f64.cos(), r * 0.75_f64.sin(), 0.015);
    let hoop = Vector3::new(-0.75_f64.sin(), 0.75_f64.cos(), 0.0);
    let outer = gauge(&mesh, &site(at(0.031), hoop)).expect("on the outer wall");
    let inner = gauge(&mesh, &site(at(0.030), hoop)).expect("on the inner wall");
    assert!(outer.normal().dot(&inner.normal()) < -0.999);
    let grad = Matrix3::from_diagonal(&Vector3::new(2e-4, 2e-4, 0.0));
    close(outer.strain(&linear(&mesh, &grad)), 2e-4, 1e-6);
    close(inner.strain(&linear(&mesh, &grad)), 2e-4, 1e-6);
    // each reads its own side of the wall: u = (r − 30.5 mm) in hoop direction strain differs in sign
    let bend = |p: &Point3<f64>| {
        let (r, phi) = (p.x.hypot(p.y), p.y.atan2(p.x));
        Vector3::new(-phi.sin(), phi.cos(), 0.0) * ((r - 0.0305) * (phi - 0.75))
    };
    let u: Vec<Vector3<f64>> = mesh.nodes().iter().map(bend).collect();
    close(outer.strain(&u), 0.0005 / 0.031, 2e-2);
    close(inner.strain(&u), -0.0005 / 0.030, 2e-2);
}

#[test]
fn bending_strain_matches_beam_theory_on_both_sides() {
    let (mesh, model) = cantilever([20, 4, 2]);
    let end = common::nodes_where(&mesh, |p| p.x == 0.1);
    let share = 1.0 / end.len() as f64;
    let load = NodalLoad {
        forces_n: end.iter().map(|&n| (n, Vector3::new(0.0, 0.0, -share))).collect(),
        ..NodalLoad::default()
    };
    let (u, _) = model.solve(&load).expect("solved");
    // ε = 6 P (L − x) / (E b h²), tension on top
    let expected = 6.0 * 0.05 / (E_PA * 0.02 * 0.01 * 0.01);
    for (z, sign) in [(0.01, 1.0), (0.0, -1.0)] {
        let gauge =
            gauge(&mesh, &site(Point3::new(0.05, 0.01, z), Vector3::x())).expect("on the beam");
        close(gauge.strain(&u), sign * expected, 1e-2);
    }
}

#[test]
fn adjoint_readings_equal_forward_readings() {
    let (mesh, model) = cantilever([10, 3, 2]);
    let sites = [
        site(Point3::new(0.03, 0.01, 0.01), Vector3::new(1.0, 0.5, 0.0)),
        site(Point3::new(0.06, 0.01, 0.0), Vector3::x()),
        site(Point3::new(0.08, 0.02, 0.005), Vector3::new(1.0, 0.0, 1.0)),
    ];
    let gauges: Vec<GaugeStrain> =
        sites.iter().map(|s| gauge(&mesh, s).expect("on the beam")).collect();
    let (response, info) = model.response(&gauges).expect("solved");
    assert_eq!((response.n_gauges(), info.n_loads), (3, 3));
    for i in (0..mesh.nodes().len()).step_by(37) {
        let node = hapdef_mesh::FeNodeId::from_index(i);
        let load = NodalLoad::nodal(node, Vector3::new(1.0, -2.0, 0.5));
        let (u, _) = model.solve(&load).expect("solved");
        for (g, gauge) in gauges.iter().enumerate() {
            let (forward, adjoint) =
                (gauge.strain(&u), response.reading(GaugeId::from_index(g), &load));
            assert!(
                (forward - adjoint).abs() <= 1e-9 * forward.abs() + 1e-18,
                "{forward:e} {adjoint:e}"
            );
        }
    }
}

#[test]
fn gauges_off_their_wall_are_refused() {
    let mesh = straight_box([10, 4, 1], [0.04, 0.02, 0.005]);
    let refuse = |s: &GaugeSite| gauge(&mesh, s).expect_err("refused");
    let error = refuse(&site(Point3::new(0.02, 0.01, 0.02), Vector3::x()));
    assert!(
        matches!(error, SimError::GaugeOffWall { distance_m, .. } if (distance_m - 0.015).abs() < 1e-9),
        "{error}"
    );
    // the axis runs across the rim: two of eight columns hang over
    let error = refuse(&site(Point3::new(0.038, 0.01, 0.005), Vector3::x()));
    assert!(matches!(error, SimError::GaugeOverhang { n_lost: 10, n_samples: 40, .. }), "{error}");
    let error = refuse(&site(Point3::new(0.02, 0.01, 0.005), Vector3::z()));
    assert!(matches!(error, SimError::Direction { .. }), "{error}");
    let error =
        refuse(&GaugeSite { length_m: 0.0, ..site(Point3::new(0.02, 0.01, 0.005), Vector3::x()) });
    assert!(matches!(error, SimError::Parameter { .. }), "{error}");
}

#[test]
fn the_ten_sites_on_the_authors_limb() {
    let (Some(deck), Some(sites)) =
        (shared("hapdef-shin/02_skin_ds.dat.gz"), shared("hapdef-shin/gauge-sites.json"))
    else {
        return;
    };
    let deck = read_deck(&deck).expect("readable");
    let text = std::fs::read_to_string(sites).expect("readable");
    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let vector =
        |key: &str, i: usize| Vector3::from_fn(|c, _| json[key][i][c].as_f64().expect("a number"));
    let boundary = deck.mesh.boundary();
    // the sites were chosen without regard to the lattice: some hang over its holes
    let lenient = GaugeParams { max_lost_share: 0.5, ..GaugeParams::default() };
    let mut gauges = Vec::new();
    for i in 0..10 {
        let site = site(Point3::from(vector("sites_mm", i) * 1e-3), vector("axis", i));
        let gauge = GaugeStrain::with_params(&deck.mesh, &boundary.faces, &site, &lenient)
            .expect("on the inner wall");
        let agreement = gauge.normal().dot(&vector("normal", i));
        let (lost, distance_m) = (gauge.lost_share(), gauge.distance_to_wall_m());
        println!(
            "site {i}: lost {lost:.3}, {distance_m:.1e} m to the wall, normals agree to {agreement:.4}"
        );
        assert!(agreement > 0.95, "site {i}");
        let strict = GaugeStrain::new(&deck.mesh, &boundary.faces, &site);
        assert_eq!(strict.is_ok(), lost <= 0.1, "site {i}");
        gauges.push(gauge);
    }
    let material = IsotropicMaterial::new(1.7e9, 0.394, 930.0).expect("valid");
    let clamped = deck.fixed_nodes.clone();
    let params = ElasticParams { n_threads: 2, ..ElasticParams::new(material, clamped) };
    let model = ElasticModel::build(&deck.mesh, &params).expect("supported");
    let (response, info) = model.response(&gauges).expect("solved");
    println!("{info:?}");
    let load = NodalLoad { forces_n: deck.nodal_forces.clone(), ..NodalLoad::default() };
    let (u, _) = model.solve(&load).expect("solved");
    for (g, gauge) in gauges.iter().enumerate() {
        let adjoint = response.reading(GaugeId::from_index(g), &load);
        println!("gauge {g}: {:.2} µε", adjoint * 1e6);
        close(gauge.strain(&u), adjoint, 1e-9);
    }
}
