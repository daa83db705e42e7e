//! Solves that are left out: the limb moves, and the gauges read, as with them.

use hapdef::Limb;
use hapdef::scene::{ContactRegion, EstimatorSpec, MaterialSpec};
use hapdef::touch::{Calibration, PressQuality, Touch, response_map, touch_estimator};
use hapdef_inverse::{Press, SkinPoint};
use hapdef_mesh::{FeNodeId, GaugeId};
use hapdef_sim::{ComplianceParams, ElasticModel, ElasticParams, NodalLoad};
use nalgebra::Vector3;

use super::{loaded, run_of};

/// Rounding of a solve with a condition of some 1e7.
const ROUNDING: f64 = 1e-8;

fn solved(limb: &Limb) -> ElasticModel {
    let params =
        ElasticParams { n_threads: 2, ..ElasticParams::new(limb.material, limb.clamped.clone()) };
    ElasticModel::build(&limb.mesh, &params).unwrap()
}

/// Displacements at `wanted` under each load, m `[n_loads, n_wanted]`.
fn moved(model: &ElasticModel, loads: &[NodalLoad], wanted: &[FeNodeId]) -> Vec<Vector3<f64>> {
    let params = ComplianceParams::default();
    let (rows, _) = model.compliance(loads, wanted, &params).unwrap();
    let of_load = |i| (0..wanted.len()).map(move |j| (i, j));
    let all = (0..loads.len()).flat_map(of_load);
    all.map(|(i, j)| rows.displacement(i, j)).collect()
}

fn assert_equal(a: &[Vector3<f64>], b: &[Vector3<f64>]) {
    let largest = a.iter().map(Vector3::norm).fold(0.0, f64::max);
    assert!(largest > 0.0 && a.len() == b.len());
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).norm() <= ROUNDING * largest, "{a} {b}");
    }
}

/// Normal loads alone move the limb as they do among loads in all three directions, and a few of them
/// as they do among all.
#[test]
pub(crate) fn loads_that_are_left_out_change_no_other() {
    let out = tempfile::tempdir().unwrap();
    let run = run_of("scene.json", out.path());
    let limb = loaded(&run);
    let model = solved(&limb);
    let normal = limb.unit_loads(run.scene.contact.tip_radius_m).unwrap();
    let some: Vec<NodalLoad> = normal.iter().step_by(700).cloned().collect();
    let wanted: Vec<FeNodeId> = limb.wanted_nodes().into_iter().step_by(90).collect();
    let alone = moved(&model, &some, &wanted);
    let tangential = limb.skin.nodes.iter().step_by(700).flat_map(|node| {
        [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| NodalLoad::nodal(*node, axis))
    });
    let among: Vec<NodalLoad> = some.iter().cloned().chain(tangential).collect();
    let among = moved(&model, &among, &wanted);
    assert_equal(&alone, &among[..alone.len()]);
}

/// A narrower region of contacts has the same displacements where it has them.
#[test]
pub(crate) fn nodes_that_nothing_touches_change_no_other() {
    let out = tempfile::tempdir().unwrap();
    let mut run = run_of("scene.json", out.path());
    let whole = loaded(&run);
    let ContactRegion::Radial { axial_range_m, .. } = &mut run.scene.contact.region else {
        panic!("the bundled scene has a radial region")
    };
    *axial_range_m = [0.08, 0.13];
    let part = loaded(&run);
    let is_inner = |node: &FeNodeId| {
        // a tip at the region's rim is cut off there
        let along_m = part.mesh.position(*node).y;
        (0.103..0.107).contains(&along_m)
    };
    let loads = |limb: &Limb| -> Vec<NodalLoad> {
        let all = limb.unit_loads(run.scene.contact.tip_radius_m).unwrap();
        let both = limb.skin.nodes.iter().zip(all);
        let inner = both.filter(|(node, _)| is_inner(node) && part.skin.nodes.contains(node));
        inner.map(|(_, load)| load).collect()
    };
    assert!(part.n_surface_nodes() < whole.n_surface_nodes() * 2 / 3);
    let wanted: Vec<FeNodeId> = part.skin.nodes.iter().step_by(5).copied().collect();
    let of = |limb: &Limb| moved(&solved(limb), &loads(limb), &wanted);
    assert_equal(&of(&part), &of(&whole));
}

/// One solve for each gauge tells what a solve for each load tells.
#[test]
pub(crate) fn adjoint_solves_read_what_a_load_at_every_node_reads() {
    let out = tempfile::tempdir().unwrap();
    let run = run_of("placed.json", out.path());
    let limb = loaded(&run);
    let model = solved(&limb);
    let (response, _) = model.response(&limb.gauges).unwrap();
    let normal = limb.unit_loads(run.scene.contact.tip_radius_m).unwrap();
    for load in normal.iter().step_by(800) {
        let (displacement, _) = model.solve(load).unwrap();
        for (i, gauge) in limb.gauges.iter().enumerate() {
            let forward = gauge.strain(&displacement);
            let adjoint = load.work_j(response.field(GaugeId::from_index(i))).unwrap();
            assert!((forward - adjoint).abs() <= ROUNDING * forward.abs().max(1e-9));
        }
    }
}

/// A calibration stands for the response that it was fitted from: with it nothing is solved, so that
/// twice the stiffness in the scene, by which a solve reads half, changes no contact.
#[test]
pub(crate) fn a_calibration_leaves_out_the_response_and_changes_no_contact() {
    let out = tempfile::tempdir().unwrap();
    let mut run = run_of("placed.json", out.path());
    let EstimatorSpec::Superposition(spec) = &mut run.scene.estimator else {
        panic!("placed.json chooses superposition")
    };
    spec.map_refinements = 0;
    spec.calibration = Some(out.path().join("calibration.json"));
    let spec = spec.clone();
    let limb = loaded(&run);
    let map = response_map(&limb, run.scene.contact.tip_radius_m, 2).unwrap();
    let press = |face: usize| {
        let point = SkinPoint::new(map.skin(), face, [0.5, 0.3, 0.2]).unwrap();
        let readings = map.normal(&point).iter().map(|g| 20.4 * g).collect();
        Press { point, force_n: 20.0, readings }
    };
    let presses: Vec<Press> = (0..30).map(|i| press(47 * i)).collect();
    let quality = PressQuality { noise_ue: 1.0, position_sd_m: 0.0, force_sd_n: 0.0 };
    let (fitted, _) = Calibration::fit(&run, &limb, &presses, &quality, 200).unwrap();
    fitted.write(&out.path().join("calibration.json")).unwrap();
    let solved = fitted.estimator(&run.scene, &spec, &limb).unwrap();
    run.scene.material = Some(MaterialSpec {
        youngs_modulus_pa: 2.0 * limb.material.youngs_modulus_pa(),
        poissons_ratio: limb.material.poissons_ratio(),
        density_kg_m3: limb.material.density_kg_m3(),
    });
    let stiff = loaded(&run);
    let stiff_map = response_map(&stiff, run.scene.contact.tip_radius_m, 2).unwrap();
    let mut left_out = touch_estimator(&run, &stiff).unwrap();
    for press in presses.iter().step_by(7) {
        let halved = stiff_map.normal(&press.point)[0] / map.normal(&press.point)[0];
        assert!((halved - 0.5).abs() < ROUNDING);
        let a = &solved.estimate(&press.readings).unwrap().contacts[0];
        let mut touch = Touch::default();
        left_out.estimate(&press.readings, &mut touch).unwrap();
        let b = &touch.contacts[0];
        assert_eq!((a.position_m, a.force_n), (b.position_m, b.force_n));
    }
}
