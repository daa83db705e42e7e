//! A skin's wall solved as a shell and as a solid.

use std::f64::consts::{PI, TAU};
use std::path::Path;

use hapdef::convergence::{ConvergenceParams, convergence};
use hapdef::plan::{Rates, plan};
use hapdef::scene::{Scene, WallSolver, read_scene};
use hapdef::touch::{
    LayoutCandidates, LayoutParams, UncertainParams, UncertainResponse, response_map,
};
use hapdef::{Limb, OpenParams, OpenScene, Profile, Progress, Run};
use hapdef_mesh::{SurfaceMesh, write_glb};
use nalgebra::{Point3, Vector3};
use serde_json::{Value, json};

const RADIUS_M: f64 = 0.025;
const LENGTH_M: f64 = 0.12;

/// An open tube along z, 50 mm across.
fn tube(edge_m: f64) -> SurfaceMesh {
    let (n_around, n_along) =
        ((TAU * RADIUS_M / edge_m).round() as u32, (LENGTH_M / edge_m).round() as u32);
    let vertex = |i: u32, k: u32| {
        let angle = TAU * (f64::from(k) + 0.5 * f64::from(i % 2)) / f64::from(n_around);
        let z = LENGTH_M * f64::from(i) / f64::from(n_along);
        Point3::new(RADIUS_M * angle.cos(), RADIUS_M * angle.sin(), z)
    };
    let vertices = (0..=n_along).flat_map(|i| (0..n_around).map(move |k| vertex(i, k)));
    let at = |i: u32, k: u32| i * n_around + k % n_around;
    let cell = |(i, k): (u32, u32)| {
        let [a, b, c, d] = [at(i, k), at(i, k + 1), at(i + 1, k), at(i + 1, k + 1)];
        if i % 2 == 0 { [[a, b, c], [b, d, c]] } else { [[a, d, c], [a, b, d]] }
    };
    let cells = (0..n_along).flat_map(|i| (0..n_around).map(move |k| (i, k)));
    SurfaceMesh::new(vertices.collect(), cells.flat_map(cell).collect()).unwrap()
}

/// A tube with six gauges on its inner side, along, around and between.
fn scene(wall_m: f64, solver: &str) -> Value {
    let places: [[f64; 3]; 6] = [
        [0.3, 0.03, 0.0],
        [2.4, 0.06, 0.0],
        [4.4, 0.08, 0.0],
        [1.3, 0.05, 1.0],
        [3.4, 0.035, 1.0],
        [5.4, 0.07, 0.5],
    ];
    let site = |(i, [turn, z, tilt]): (usize, [f64; 3])| {
        let (sin, cos) = turn.sin_cos();
        let (across, along) = (0.5 * PI * tilt).sin_cos();
        let inner_m = RADIUS_M - wall_m;
        json!({
            "name": format!("g{i}"),
            "position_m": [inner_m * cos, inner_m * sin, z],
            "axis": [-across * sin, across * cos, along],
        })
    };
    let sites: Vec<Value> = places.into_iter().enumerate().map(site).collect();
    json!({
        "name": "tube",
        "geometry": {"skin": "skin.glb", "wall_m": wall_m, "unit": "m", "solver": solver},
        "mount": {"kind": "plane", "point_m": [0.0, 0.0, 1e-4], "normal": [0.0, 0.0, -1.0]},
        "contact": {"region": {"rule": "free_skin", "mount_gap_m": 2.0 * wall_m}},
        "gauges": {"sites": sites},
    })
}

fn written(folder: &Path, edge_m: f64, scene: &Value) -> std::path::PathBuf {
    write_glb(&folder.join("skin.glb"), &tube(edge_m), None).unwrap();
    let path = folder.join("scene.json");
    std::fs::write(&path, scene.to_string()).unwrap();
    path
}

fn opened(folder: &Path, edge_m: f64, scene: &Value) -> OpenScene {
    let path = written(folder, edge_m, scene);
    let out = folder.join("out");
    OpenScene::with_params(&path, OpenParams { results: out, threads: 2, ..OpenParams::default() })
        .unwrap()
}

/// Rows of the map against the directions of contacts `[n_nodes][n_gauges]`, µε/N.
fn normal_rows(limb: &Limb, nodal: &[Vector3<f64>]) -> Vec<Vec<f64>> {
    let rows = nodal.chunks(limb.sites.len()).zip(&limb.directions);
    rows.map(|(row, direction)| row.iter().map(|v| v.dot(direction)).collect()).collect()
}

fn median_difference(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|x| x * x).sum::<f64>().sqrt();
    let off = |(a, b): (&Vec<f64>, &Vec<f64>)| {
        norm(&mut a.iter().zip(b).map(|(a, b)| a - b)) / norm(&mut b.iter().copied())
    };
    let mut all: Vec<f64> = a.iter().zip(b).map(off).collect();
    all.sort_by(f64::total_cmp);
    all[all.len() / 2]
}

/// A shell scene opens and solves as any other; its map is that of the solid within what is expected of both.
#[test]
fn a_shell_reads_as_the_solid_within_what_is_expected() {
    let folder = tempfile::tempdir().unwrap();
    let map = |solver| {
        let scene = opened(folder.path(), 6e-3, &scene(3e-3, solver));
        let rows = normal_rows(scene.limb(), &scene.solve().unwrap().response().nodal());
        (scene, rows)
    };
    let ((shell, of_shell), (solid, of_solid)) = (map("shell"), map("solid"));
    assert!(shell.limb().shell.is_some() && solid.limb().shell.is_none());
    let wall = shell.limb().wall.as_ref().unwrap();
    let expected = wall.measures.shell_error() + wall.measures.solid_error();
    let off = median_difference(&of_shell, &of_solid);
    assert!(off < expected && off > 0.1 * expected, "{off} {expected}");
}

/// The measured tubes, some of them again: the finest solid knows, the expected errors are met within a
/// factor of two, and the better of the two is chosen.
#[test]
fn the_better_of_shell_and_solid_is_chosen() {
    let measured = |wall_m: f64, edge_m: f64, chosen: WallSolver| {
        let folder = tempfile::tempdir().unwrap();
        let path = written(folder.path(), edge_m, &scene(wall_m, "auto"));
        let limb = Limb::load(&read_scene(&path).unwrap(), folder.path()).unwrap();
        let wall = limb.wall.as_ref().unwrap();
        assert_eq!(wall.solver, chosen, "{wall}");
        let params = ConvergenceParams { n_threads: 2, ..ConvergenceParams::default() };
        let study = convergence(&limb, 2e-3, &params, &|_| {}).unwrap();
        let words = study.in_words(&limb);
        let judged = ["the mesh's gauge readings", "the shell's gauge readings differ"];
        let judged = judged[usize::from(chosen == WallSolver::Shell)];
        assert!(words.contains(judged), "{words}");
        let found = study.shell.unwrap();
        let is_shell_better = found.median_difference < found.solid_median_difference;
        assert_eq!(is_shell_better, chosen == WallSolver::Shell, "{wall}: {found:?}");
        let near = |expected: f64, found: f64| (0.5..2.0).contains(&(found / expected));
        assert!(near(wall.measures.shell_error(), found.median_difference), "{wall}: {found:?}");
        assert!(
            near(wall.measures.solid_error(), found.solid_median_difference),
            "{wall}: {found:?}"
        );
    };
    measured(1e-3, 1e-2, WallSolver::Shell);
    measured(8e-3, 1e-2, WallSolver::Solid);
}

/// Betti and Maxwell on the shell: what gauges read by the compliance of the wall is what the map says, and a
/// layout's candidates, a calibration's modes and the plan come as they do of a solid.
#[test]
fn what_follows_works_with_a_shell() {
    let folder = tempfile::tempdir().unwrap();
    let path = written(folder.path(), 8e-3, &scene(1e-3, "shell"));
    let out = folder.path().join("out");
    let run = Run::new(&path, Profile::quick(), &out, 2, Progress::silent()).unwrap();
    let limb = Limb::load(&run.scene, &run.scene_dir).unwrap();
    let params =
        UncertainParams { tip_radius_m: 2e-3, refinements: 0, n_stiffness: 60, n_threads: 2 };
    let response = UncertainResponse::solve(&limb, &limb.sites, &limb.gauges, &params).unwrap();
    let map = response_map(&limb, 2e-3, 2).unwrap().nodal();
    assert_eq!(response.map.nodal(), map);
    // a limb stiffer all over reads less, by as much
    let modes: Vec<Vec<Vector3<f64>>> =
        response.stiffness_modes.iter().map(hapdef_inverse::ResponseMap::nodal).collect();
    assert_eq!(modes.len(), 60);
    let summed = |i: usize| modes.iter().map(|mode| mode[i]).sum::<Vector3<f64>>();
    let down = (0..map.len()).map(|i| summed(i).dot(&map[i])).sum::<f64>();
    let size = map.iter().map(Vector3::norm_squared).sum::<f64>();
    assert!(down < -0.5 * size, "{down} {size}");
    let layouts = LayoutParams { n_gauges: 6, n_positions: 60, ..LayoutParams::default() };
    let candidates = LayoutCandidates::solve(&run, &limb, &layouts).unwrap();
    assert_eq!(candidates.recommended(6).unwrap().len(), 6);
    let made = plan(&run, &limb, &Rates::default()).unwrap();
    let made = made.with_shell_advice(&limb, limb.max_wall_m, &out).unwrap();
    let step = made.step("shell or extruded solid").unwrap();
    assert!(step.why.starts_with("shell: the scene asks for it"), "{}", step.why);
    let equations = made.step("response").unwrap().sizes["equations"];
    assert_eq!(equations % 6, 0);
    assert!(equations < 6 * 4000, "{equations}");
}

#[test]
fn the_cache_tells_a_shell_from_a_solid() {
    let folder = tempfile::tempdir().unwrap();
    let stage = |solver| {
        let scene = opened(folder.path(), 1.2e-2, &scene(2e-3, solver));
        hapdef::stages::compliance(scene.run(), scene.limb()).unwrap()
    };
    let (shell, solid, again) = (stage("shell"), stage("solid"), stage("shell"));
    assert_ne!(shell.dir, solid.dir);
    assert!(again.cached && !shell.cached && !solid.cached);
    let softness = |stage: &hapdef::Stage| {
        stage.record.info["median_self_compliance_um_per_n"].as_f64().unwrap()
    };
    let ratio = softness(&shell) / softness(&solid);
    assert!((1.0..2.0).contains(&ratio), "{ratio}");
}

#[test]
fn a_shell_that_cant_be_had_is_refused_with_what_to_do() {
    let refused = |scene: Value, edge_m: f64, expected: &[&str]| {
        let folder = tempfile::tempdir().unwrap();
        let path = written(folder.path(), edge_m, &scene);
        let error = Scene::open(&path).and_then(|scene| scene.solve().map(drop)).unwrap_err();
        let text = hapdef::error_text(&error);
        for words in expected {
            assert!(text.contains(words), "{words:?} is not in: {text}");
        }
    };
    let mut refined = scene(1e-3, "shell");
    refined["estimator"] = json!({"kind": "superposition", "map_refinements": 1});
    let words = ["geometry.solver", "skin.glb", "1.00 mm", "map_refinements", "state \"solid\""];
    refused(refined.clone(), 1e-2, &words);
    let folder = tempfile::tempdir().unwrap();
    refined["geometry"]["solver"] = json!("auto");
    let path = written(folder.path(), 1e-2, &refined);
    let limb = Limb::load(&read_scene(&path).unwrap(), folder.path()).unwrap();
    let wall = limb.wall.unwrap();
    assert_eq!(wall.solver, WallSolver::Solid);
    assert!(wall.to_string().contains("map_refinements refines the solid"), "{wall}");
}
