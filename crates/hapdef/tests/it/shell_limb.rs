//! From a glTF surface to gauge readings with a shell model.

use crate::shell_limb_common;

use std::sync::OnceLock;

use hapdef::Limb;
use hapdef::plan::Plan;
use hapdef::shell_limb::{
    ReportSource, ShellComparison, ShellLimb, ShellLimbParams, ShellVerdict, WallChoice, shell_limb,
};
use hapdef_live::estimator::EstimatorKind;
use hapdef_mesh::{FeNodeId, SurfaceMesh};
use hapdef_sim::{IsotropicMaterial, NodalLoad};
use nalgebra::{Point3, Vector3};
use shell_limb_common::{fixture, surface, tube};

fn pa2200() -> IsotropicMaterial {
    IsotropicMaterial::new(1.7e9, 0.394, 930.0).unwrap()
}

/// The bundled skin with a wall of 1 mm, made once, on one thread.
fn shin_limb() -> &'static ShellLimb {
    static LIMB: OnceLock<ShellLimb> = OnceLock::new();
    LIMB.get_or_init(|| shin_limb_on(1))
}

fn shin_limb_on(n_threads: usize) -> ShellLimb {
    let params = ShellLimbParams {
        n_presses: 60,
        n_threads,
        ..ShellLimbParams::new(WallChoice::Constant(1e-3), pa2200())
    };
    shell_limb(&surface(&fixture("shin_skin.glb")), &params).unwrap()
}

/// A reading from a gauge's adjoint field is the reading after a press on the node.
#[test]
fn readings_are_those_of_forward_solves() {
    let limb = shin_limb();
    let readings = limb.readings_ue_per_n();
    let n_gauges = limb.gauges.len();
    assert_eq!(readings.len(), n_gauges * limb.mesh.nodes().len());
    assert!(readings.iter().all(|r| r.is_finite()));
    assert!(limb.info.median_best_ue_per_n > 1.0, "{:?}", limb.info);
    let largest = readings.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    for node in [limb.info.gauges[3].strongest_node, limb.normals.len() / 2] {
        let press = NodalLoad::nodal(FeNodeId::from_index(node), -limb.normals[node]);
        let (motion, _) = limb.elastic_model.solve_motion(&press).unwrap();
        for (gauge, strain) in limb.gauges.iter().enumerate() {
            let expected = strain.strain(&motion) * 1e6;
            let found = readings[node * n_gauges + gauge];
            assert!(
                (found - expected).abs() <= 1e-8 * largest,
                "node {node}, gauge {gauge}: {found} and {expected}"
            );
        }
    }
}

#[test]
fn clamped_nodes_are_not_felt() {
    let limb = shin_limb();
    assert_eq!(limb.info.mount.axis, 'y');
    assert!(!limb.clamped.is_empty());
    let best = limb.best_ue_per_n();
    assert!(limb.clamped.iter().all(|node| best[node.index()] == 0.0));
}

#[test]
fn gauges_keep_off_the_mount_and_each_other() {
    let limb = shin_limb();
    let half_diagonal_m = 0.5 * 8e-3_f64.hypot(5e-3);
    let places: Vec<Point3<f64>> = limb.sites.iter().map(|site| site.position).collect();
    for (i, place) in places.iter().enumerate() {
        for node in &limb.clamped {
            // Sites lie half a wall below the middle.
            let distance_m = (limb.mesh.nodes()[node.index()] - place).norm();
            assert!(distance_m > half_diagonal_m - 0.5e-3, "{distance_m}");
        }
        for other in &places[..i] {
            assert!((other - place).norm() > 2.0 * half_diagonal_m);
        }
    }
}

#[test]
fn two_threads_give_the_same_bits() {
    let (one, two) = (shin_limb(), shin_limb_on(2));
    assert_eq!(one.readings_ue_per_n(), two.readings_ue_per_n());
    assert_eq!(one.info.gauges, two.info.gauges);
}

fn measured_tube(edge_m: f64, n_solid_halvings: usize) -> ShellLimb {
    let params = ShellLimbParams {
        edge_m: Some(edge_m),
        n_gauges: 4,
        n_presses: 60,
        n_threads: 2,
        n_solid_halvings: Some(n_solid_halvings),
        ..ShellLimbParams::new(WallChoice::Measured, pa2200())
    };
    shell_limb(&tube(0.07), &params).unwrap()
}

/// The wall of a double-walled solid is found, and its shell answers as the solid extruded from it.
#[test]
fn a_tube_is_measured_and_its_shell_is_good() {
    let limb = measured_tube(5e-3, 1);
    let wall = &limb.info.wall;
    let [_, low, median, high, _] = wall.thickness_quantiles_m;
    for thickness_m in [low, median, high] {
        assert!((thickness_m - 1e-3).abs() < 2e-5, "{thickness_m}");
    }
    let measured = wall.measured.unwrap();
    assert!(measured.not_shell_share < 0.1, "{measured:?}");
    let comparison = limb.against_extruded().unwrap();
    println!("{comparison}");
    assert_eq!(comparison.verdict, ShellVerdict::ShellIsGood, "{comparison}");
    assert_eq!(comparison.n_gauges, 4);
    assert_eq!(comparison.recommendation(), None);
    check_report(&limb, comparison);
}

/// The page is well-formed and takes nothing from outside; page and JSON have the figures.
fn check_report(limb: &ShellLimb, comparison: ShellComparison) {
    let folder = tempfile::tempdir().unwrap();
    let source = ReportSource { file: "a & b.glb".into(), file_hash: "0123".into(), scene: None };
    let comparisons = [comparison];
    limb.write_report(folder.path(), &source, &comparisons).unwrap();
    let read = |file: &str| std::fs::read_to_string(folder.path().join(file)).unwrap();
    let page = read("shell-report.html");
    for outside in ["http:", "https:", "src=", "href=", "url("] {
        assert!(!page.contains(outside), "{outside} is in the page");
    }
    let markup = page.strip_prefix("<!doctype html>").unwrap();
    let tree = roxmltree::Document::parse(markup).unwrap();
    let named = |name: &'static str| tree.descendants().filter(move |n| n.has_tag_name(name));
    let views = named("canvas").filter(|c| c.has_attribute("data-map"));
    assert_eq!(views.count(), 6 * 4);
    let data = named("script").find(|s| s.attribute("id") == Some("data"));
    let data: serde_json::Value = serde_json::from_str(data.unwrap().text().unwrap()).unwrap();
    let drawn = &data["limbs"][0];
    let [comparison] = &comparisons;
    let n_vertices = comparison.skin.vertices().len();
    assert_eq!(drawn["points"].as_array().unwrap().len(), 3 * n_vertices);
    for map in drawn["maps"].as_array().unwrap() {
        assert_eq!(map["values"].as_array().unwrap().len(), n_vertices);
    }
    let figures: serde_json::Value = serde_json::from_str(&read("shell-report.json")).unwrap();
    assert_eq!(figures["source"]["file"], "a & b.glb");
    let compared = &figures["comparisons"][0];
    assert_eq!(compared["shell"]["tip"]["median"], comparison.shell.tip.median);
    assert_eq!(compared["presses"].as_array().unwrap().len(), comparison.presses.len());
    assert_eq!(compared["gauges"].as_array().unwrap().len(), 4);
    assert!(page.contains(&format!(
        "{:.1} % of the compared surface by displacement",
        100.0 * comparison.above_good.tip_share
    )));
}

/// A wall of 10 mm on a tube of 25 mm radius is no shell's, and its measures say so, too.
#[test]
fn a_thick_wall_asks_for_the_solid() {
    let params = ShellLimbParams {
        edge_m: Some(6e-3),
        n_gauges: 4,
        n_presses: 60,
        n_threads: 2,
        n_solid_halvings: Some(0),
        ..ShellLimbParams::new(WallChoice::Constant(10e-3), pa2200())
    };
    let limb = shell_limb(&outer_wall(&tube(0.1)), &params).unwrap();
    let thin_wall = limb.thin_wall();
    assert!(thin_wall.recommendation().is_some(), "{thin_wall}");
    let comparison = limb.against_extruded().unwrap();
    println!("{comparison}");
    let text = comparison.recommendation().unwrap();
    assert!(text.starts_with("use the solid: "), "{text}");
}

/// Nothing but shell theory and mesh is between a skin's shell and the wall extruded from it.
#[test]
fn the_bundled_skin_answers_as_its_own_wall() {
    let limb = shin_limb();
    assert_eq!(limb.thin_wall().recommendation(), None);
    let comparison = limb.against_extruded().unwrap();
    println!("{comparison}");
    assert_eq!(comparison.recommendation(), None, "{comparison}");
    assert!(comparison.above_good.tip_share < 0.5, "{comparison}");
    let gauges = &comparison.gauges;
    assert!(gauges.iter().all(|g| g.difference < 0.3), "{gauges:?}");
}

/// The displacements of the finer mesh hold those of the coarser, so it gives way more.
#[test]
fn halving_the_solids_edges_softens_it() {
    let comparison = measured_tube(9e-3, 1).against_extruded().unwrap();
    let coarser = comparison.coarser_solid.unwrap();
    println!("{coarser:?}");
    assert!(coarser.tip.median_ratio < 1.0, "{coarser:?}");
    assert!(coarser.tip.median_ratio > 0.5, "{coarser:?}");
}

/// The outer wall of a tube, open at both ends.
fn outer_wall(tube: &SurfaceMesh) -> SurfaceMesh {
    let n_outer = 48 * 21;
    let is_outer = |t: &&[u32; 3]| t.iter().all(|v| *v < n_outer);
    let outer = tube.triangles().iter().filter(is_outer).copied().collect();
    let vertices = tube.vertices()[..n_outer as usize].to_vec();
    SurfaceMesh::new(vertices, outer).unwrap()
}

/// A moment of 1 N m at the free end of a tube turns it by L / (E I).
#[test]
fn a_tube_bends_as_a_beam() {
    let params = ShellLimbParams {
        edge_m: Some(4e-3),
        n_gauges: 1,
        ..ShellLimbParams::new(WallChoice::Constant(1e-3), pa2200())
    };
    let limb = shell_limb(&outer_wall(&tube(0.12)), &params).unwrap();
    let nodes = limb.mesh.nodes();
    let is_top = |&i: &usize| nodes[i].y > 0.12 - 1e-9;
    let top: Vec<usize> = (0..nodes.len()).filter(is_top).collect();
    let sum: f64 = top.iter().map(|&i| nodes[i].x.powi(2)).sum();
    let force = |&i: &usize| {
        let force = Vector3::new(0.0, nodes[i].x / sum, 0.0);
        (FeNodeId::from_index(i), force)
    };
    let load = NodalLoad { forces_n: top.iter().map(force).collect(), ..NodalLoad::default() };
    let (displacement, _) = limb.elastic_model.solve(&load).unwrap();
    let turned_rad = load.work_j(&displacement).unwrap();
    let held_m = limb.clamped.iter().map(|n| nodes[n.index()].y);
    let length_m = 0.12 - held_m.fold(0.0, f64::max);
    let inertia_m4 = std::f64::consts::PI * 24.5e-3_f64.powi(3) * 1e-3;
    let expected_rad = length_m / (1.7e9 * inertia_m4);
    println!("{turned_rad:e} rad, beam {expected_rad:e}");
    assert!((turned_rad / expected_rad - 1.0).abs() < 0.03);
}

#[test]
fn the_ribbed_solid_is_not_its_plain_skin() {
    let limb = shin_limb();
    let path = fixture("scene.json");
    let scene = hapdef::scene::read_scene(&path).unwrap();
    let solid = Limb::load(&scene, path.parent().unwrap()).unwrap();
    let comparison = limb.against_solid("the ribbed limb", &solid).unwrap();
    println!("{comparison}");
    assert_eq!(comparison.verdict, ShellVerdict::UseTheSolid, "{comparison}");
    assert!(comparison.shell.readings.median > 0.5, "{comparison}");
    let text = comparison.recommendation().unwrap();
    assert!(text.starts_with("use the solid: "), "{text}");
    assert_eq!(comparison.deck_hash, Some(solid.deck_hash.clone()));
    assert!(comparison.above_good.readings_share > 0.9, "{comparison:?}");
    assert_eq!(comparison.reading_difference.len(), solid.n_surface_nodes());
    check_plan(limb, comparison, &solid);
}

/// The plan of the scene finds the report by its deck.
fn check_plan(limb: &ShellLimb, comparison: ShellComparison, solid: &Limb) {
    let results = tempfile::tempdir().unwrap();
    let readings = format!("{:.1} %", 100.0 * comparison.shell.readings.median);
    let source =
        ReportSource { file: "shin_skin.glb".into(), file_hash: String::new(), scene: None };
    let folder = results.path().join("shin_skin");
    limb.write_report(&folder, &source, &[comparison]).unwrap();
    let plan = Plan {
        scene: String::new(),
        estimator: EstimatorKind::Superposition,
        profile: String::new(),
        steps: Vec::new(),
    };
    let plan = plan.with_shell_advice(solid, 3e-3, results.path()).unwrap();
    let why = &plan.steps[0].why;
    assert!(why.starts_with("use the solid, as this scene does: compared"), "{why}");
    assert!(why.contains(&readings) && why.contains("shin_skin.glb"), "{why}");
}
