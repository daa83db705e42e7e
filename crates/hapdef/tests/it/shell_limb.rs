//! From a glTF surface to gauge readings with a shell model.

use crate::shell_limb_common;

use std::sync::OnceLock;

use hapdef::Limb;
use hapdef::plan::Plan;
use hapdef::scene::read_scene;
use hapdef::shell_limb::{ShellComparison, ShellLimb, ShellLimbParams, ShellVerdict, WallChoice};
use hapdef::touch::response_map;
use hapdef_live::estimator::EstimatorKind;
use hapdef_mesh::{LengthUnit, SurfaceMesh, write_glb};
use hapdef_sim::GaugeSite;
use nalgebra::Point3;
use shell_limb_common::{fixture, tube};

/// The bundled skin with a wall of 1 mm, made once, on one thread.
fn shin_limb() -> &'static ShellLimb {
    static LIMB: OnceLock<ShellLimb> = OnceLock::new();
    LIMB.get_or_init(|| shin_limb_on(1))
}

fn shin_limb_on(n_threads: usize) -> ShellLimb {
    let params = ShellLimbParams {
        n_presses: 60,
        n_threads,
        n_solid_halvings: Some(0),
        ..ShellLimbParams::new(WallChoice::Constant(1e-3))
    };
    ShellLimb::read(&fixture("shin_skin.glb"), LengthUnit::Metre, &params).unwrap()
}

/// The limb of a surface in memory.
fn limb_of(surface: &SurfaceMesh, params: &ShellLimbParams) -> ShellLimb {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a & b.glb");
    write_glb(&file, surface, None).unwrap();
    ShellLimb::read(&file, LengthUnit::Metre, params).unwrap()
}

/// The command's readings are those of the scene that it makes, read from files as any other.
#[test]
fn readings_are_those_of_the_scene() {
    let limb = shin_limb();
    let folder = tempfile::tempdir().unwrap();
    limb.write_scene(folder.path()).unwrap();
    let path = folder.path().join("scene.json");
    let scene = Limb::load(&read_scene(&path).unwrap(), folder.path()).unwrap();
    assert!(scene.shell.is_some());
    let nodal = response_map(&scene, 0.0, 1).unwrap().nodal();
    let found = limb.readings_ue_per_n();
    assert_eq!(found.len(), limb.limb.sites.len() * limb.limb.n_surface_nodes());
    let largest = found.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    assert!(limb.info.median_best_ue_per_n > 1.0, "{:?}", limb.info);
    let rows = nodal.chunks(scene.sites.len()).zip(&scene.directions);
    let expected = rows.flat_map(|(row, inward)| row.iter().map(|field| field.dot(inward)));
    for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert!((found - expected).abs() <= 1e-4 * largest, "{i}: {found} and {expected}");
    }
}

#[test]
fn clamped_nodes_are_not_felt() {
    let limb = shin_limb();
    assert_eq!(limb.info.mount.axis, 'y');
    assert!(limb.info.mount.n_clamped > 0);
    let best = limb.best_ue_per_n();
    let nodes = limb.limb.skin.nodes.iter().zip(best);
    let mut held = nodes.filter(|(node, _)| limb.limb.clamped.binary_search(node).is_ok());
    assert!(held.all(|(_, best)| best == 0.0));
}

#[test]
fn gauges_keep_off_the_mount_and_each_other() {
    let limb = shin_limb();
    let half_diagonal_m = 0.5 * 8e-3_f64.hypot(5e-3);
    let places: Vec<Point3<f64>> = limb.limb.sites.iter().map(|site| site.position).collect();
    for (i, place) in places.iter().enumerate() {
        for node in &limb.limb.clamped {
            let distance_m = (limb.limb.mesh.position(*node) - place).norm();
            // sites are rounded to the micrometre
            assert!(distance_m > half_diagonal_m - 2e-6, "{distance_m}");
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
        ..ShellLimbParams::new(WallChoice::Measured)
    };
    limb_of(&tube(0.07), &params)
}

/// The wall of a double-walled solid is found, and its shell answers as the solid extruded from it.
#[test]
fn a_tube_is_measured_and_its_shell_is_good() {
    let limb = measured_tube(3.5e-3, 1);
    let wall = &limb.info.wall;
    let [_, low, median, high, _] = wall.thickness_quantiles_m;
    for thickness_m in [low, median, high] {
        assert!((thickness_m - 1e-3).abs() < 2e-5, "{thickness_m}");
    }
    let made = wall.made.concat();
    assert!(made.contains("% of the outer skin is no shell"), "{made}");
    let comparison = limb.against_extruded().unwrap();
    println!("{}", comparison.advice());
    assert_eq!(comparison.verdict, ShellVerdict::ShellIsGood, "{}", comparison.advice());
    assert_eq!(comparison.n_gauges, 4);
    check_report(&limb, comparison);
}

/// The page is well-formed and takes nothing from outside; page and JSON have the figures.
fn check_report(limb: &ShellLimb, comparison: ShellComparison) {
    let folder = tempfile::tempdir().unwrap();
    let comparisons = [comparison];
    limb.write(folder.path(), &comparisons).unwrap();
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
    assert!(figures["source"]["file"].as_str().unwrap().ends_with("a & b.glb"));
    let compared = &figures["comparisons"][0];
    assert_eq!(compared["shell"]["tip"]["median"], comparison.shell.tip.median);
    let presses = compared["presses"].as_array().unwrap();
    assert_eq!(presses.len(), comparison.n_touches);
    let with_tip = presses.iter().filter(|press| press["shell_tip_um_per_n"].is_number());
    assert_eq!(with_tip.count(), comparison.n_tips);
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
        ..ShellLimbParams::new(WallChoice::Constant(10e-3))
    };
    let limb = limb_of(&outer_wall(&tube(0.1)), &params);
    assert!(limb.info.wall.too_thick.is_some(), "{:?}", limb.info.wall);
    let comparison = limb.against_extruded().unwrap();
    let text = comparison.advice();
    assert!(text.starts_with("use the solid: "), "{text}");
}

/// Nothing but shell theory and mesh is between a skin's shell and the wall extruded from it.
#[test]
fn the_bundled_skin_answers_as_its_own_wall() {
    let limb = shin_limb();
    assert_eq!(limb.info.wall.too_thick, None);
    let comparison = limb.against_extruded().unwrap();
    println!("{}", comparison.advice());
    assert_eq!(comparison.verdict, ShellVerdict::ShellIsGood, "{}", comparison.advice());
    assert!(comparison.above_good.tip_share < 0.5, "{:?}", comparison.above_good);
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

/// Under a moment of 1 N m at the free end of a tube a gauge reads x / (E I), x off the neutral plane.
#[test]
fn a_tube_bends_as_a_beam() {
    let params = ShellLimbParams {
        edge_m: Some(6e-3),
        n_gauges: 16,
        ..ShellLimbParams::new(WallChoice::Constant(1e-3))
    };
    let limb = limb_of(&outer_wall(&tube(0.12)), &params);
    let points = limb.limb.surface_points();
    let top: Vec<usize> = (0..points.len()).filter(|&i| points[i].y > 0.12 - 1e-6).collect();
    let sum: f64 = top.iter().map(|&i| points[i].x.powi(2)).sum();
    let fields = limb.response().unwrap().nodal();
    let stiffness = 1.7e9 * std::f64::consts::PI * 24.5e-3_f64.powi(3) * 1e-3;
    // the mount keeps the tube from widening; clear of both ends that is no more felt
    let is_clear = |site: &GaugeSite| (0.035..0.09).contains(&site.position.y);
    let clear: Vec<_> =
        (0..limb.limb.sites.len()).filter(|&g| is_clear(&limb.limb.sites[g])).collect();
    assert!(clear.len() > 2, "{:?}", limb.limb.sites);
    for gauge in clear {
        let site = &limb.limb.sites[gauge];
        let of = |&i: &usize| fields[i * limb.limb.sites.len() + gauge].y * points[i].x / sum;
        let found_ue: f64 = top.iter().map(of).sum();
        let expected_ue = 1e6 * site.position.x / stiffness;
        println!("{found_ue} µε, beam {expected_ue}");
        assert!((found_ue - expected_ue).abs() < 0.05 * 1e6 * 24e-3 / stiffness);
    }
}

#[test]
fn the_ribbed_solid_is_not_its_plain_skin() {
    let limb = shin_limb();
    let path = fixture("scene.json");
    let comparison = limb.against_scene(&path).unwrap();
    let text = comparison.advice();
    assert_eq!(comparison.verdict, ShellVerdict::UseTheSolid, "{text}");
    assert!(comparison.shell.readings.median > 0.5, "{text}");
    assert!(text.starts_with("use the solid: "), "{text}");
    let solid = Limb::load(&read_scene(&path).unwrap(), path.parent().unwrap()).unwrap();
    assert_eq!(comparison.deck_hash, Some(solid.deck_hash.clone()));
    assert!(comparison.above_good.readings_share > 0.9, "{:?}", comparison.above_good);
    check_plan(limb, comparison, &solid);
}

/// The plan of the scene finds the report by its deck.
fn check_plan(limb: &ShellLimb, comparison: ShellComparison, solid: &Limb) {
    let results = tempfile::tempdir().unwrap();
    let readings = format!("{:.1} %", 100.0 * comparison.shell.readings.median);
    limb.write(&results.path().join("shin_skin"), &[comparison]).unwrap();
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
