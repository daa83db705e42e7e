//! From a glTF surface to gauge readings with a shell model, in the library and by one command.
#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test may panic, and says what it skips"
)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use hapdef::shell_limb::{ShellLimb, ShellLimbParams, ShellVerdict, WallChoice, shell_limb};
use hapdef_mesh::{FeNodeId, GltfParams, SurfaceMesh, read_gltf, write_glb};
use hapdef_sim::{IsotropicMaterial, NodalLoad};
use nalgebra::{Point3, Vector3};

fn fixture(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../fixtures/shin")
        .join(file)
}

/// A limb of the shared folder, if that is there.
fn shared_limb(file: &str) -> Option<PathBuf> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared");
    let folder = std::env::var_os("HAPDEF_SHARED").map_or(here, PathBuf::from);
    let path = folder.join("inputs/limbs").join(file);
    if path.exists() {
        return Some(path);
    }
    println!("skipped: {} is not there", path.display());
    None
}

fn surface(path: &Path) -> SurfaceMesh {
    read_gltf(path, &GltfParams::default()).unwrap().mesh
}

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
        n_threads,
        ..ShellLimbParams::new(WallChoice::Constant(1e-3), pa2200())
    };
    shell_limb(&surface(&fixture("shin_skin.glb")), &params).unwrap()
}

fn hapdef(words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hapdef"))
        .arg("shell")
        .args(words)
        .output()
        .unwrap()
}

fn said(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[track_caller]
fn refused(words: &[&str], expected: &[&str]) -> String {
    let output = hapdef(words);
    let text = said(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{text}");
    for words in expected {
        assert!(text.contains(words), "{words:?} is not in: {text}");
    }
    said(&output.stdout)
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

/// A tube 50 mm across with a wall of 1 mm, closed at its rims.
fn tube(length_m: f64) -> SurfaceMesh {
    let (n_around, n_along) = (48_u32, 20_u32);
    let ring = |radius: f64, i: u32| {
        let y = length_m * f64::from(i) / f64::from(n_along);
        (0..n_around).map(move |k| {
            let angle = std::f64::consts::TAU * f64::from(k) / f64::from(n_around);
            Point3::new(radius * angle.cos(), y, -radius * angle.sin())
        })
    };
    let walls = [0.025, 0.024].map(|radius| (0..=n_along).flat_map(move |i| ring(radius, i)));
    let vertices = walls.into_iter().flatten().collect();
    let at = |wall: u32, i: u32, k: u32| (wall * (n_along + 1) + i) * n_around + k % n_around;
    let mut triangles = Vec::new();
    let mut quad = |[a, b, c, d]: [u32; 4]| triangles.extend([[a, b, c], [a, c, d]]);
    for k in 0..n_around {
        for i in 0..n_along {
            quad([
                at(0, i, k),
                at(0, i, k + 1),
                at(0, i + 1, k + 1),
                at(0, i + 1, k),
            ]);
            quad([
                at(1, i, k),
                at(1, i + 1, k),
                at(1, i + 1, k + 1),
                at(1, i, k + 1),
            ]);
        }
        quad([at(0, 0, k), at(1, 0, k), at(1, 0, k + 1), at(0, 0, k + 1)]);
        let top = n_along;
        quad([
            at(0, top, k),
            at(0, top, k + 1),
            at(1, top, k + 1),
            at(1, top, k),
        ]);
    }
    SurfaceMesh::new(vertices, triangles).unwrap()
}

fn measured_tube(edge_m: f64, n_solid_halvings: usize) -> ShellLimb {
    let params = ShellLimbParams {
        edge_m: Some(edge_m),
        n_gauges: 4,
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
    assert_eq!(
        comparison.verdict,
        ShellVerdict::ShellIsGood,
        "{comparison}"
    );
    assert_eq!(comparison.n_gauges, 4);
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

/// A moment of 1 N m at the free end of a tube turns it by L / (E I).
#[test]
fn a_tube_bends_as_a_beam() {
    let params = ShellLimbParams {
        edge_m: Some(4e-3),
        n_gauges: 1,
        ..ShellLimbParams::new(WallChoice::Constant(1e-3), pa2200())
    };
    let tube = tube(0.12);
    let n_outer = 48 * 21;
    let is_outer = |t: &&[u32; 3]| t.iter().all(|v| *v < n_outer);
    let outer = tube.triangles().iter().filter(is_outer).copied().collect();
    let vertices = tube.vertices()[..n_outer as usize].to_vec();
    let skin = SurfaceMesh::new(vertices, outer).unwrap();
    let limb = shell_limb(&skin, &params).unwrap();
    let nodes = limb.mesh.nodes();
    let is_top = |&i: &usize| nodes[i].y > 0.12 - 1e-9;
    let top: Vec<usize> = (0..nodes.len()).filter(is_top).collect();
    let sum: f64 = top.iter().map(|&i| nodes[i].x.powi(2)).sum();
    let force = |&i: &usize| {
        let force = Vector3::new(0.0, nodes[i].x / sum, 0.0);
        (FeNodeId::from_index(i), force)
    };
    let load = NodalLoad {
        forces_n: top.iter().map(force).collect(),
        ..NodalLoad::default()
    };
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
fn the_command_reads_a_tube_and_writes_its_files() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("tube.glb");
    write_glb(&file, &tube(0.12), None).unwrap();
    let out = folder.path().join("out");
    let [file, out] = [&file, &out].map(|p| p.to_str().unwrap().to_owned());
    let words = [
        &file, "--unit", "m", "--wall", "measured", "--gauges", "3", "--edge", "5", "--out", &out,
    ];
    let output = hapdef(&words);
    assert!(output.status.success(), "{}", said(&output.stderr));
    let table = said(&output.stdout);
    assert!(table.contains("best gauge"), "{table}");
    for name in ["response.glb", "thickness.glb", "response.safetensors"] {
        assert!(Path::new(&out).join(name).exists(), "{name}");
    }
    let json = std::fs::read(Path::new(&out).join("response.json")).unwrap();
    let json: serde_json::Value = serde_json::from_slice(&json).unwrap();
    assert_eq!(json["limb"]["gauges"].as_array().unwrap().len(), 3);
    let skin = surface(&Path::new(&out).join("response.glb"));
    assert_eq!(json["limb"]["model"]["n_nodes"], skin.vertices().len());
}

#[test]
fn without_a_unit_the_guess_is_told() {
    let file = fixture("shin_skin.glb");
    let file = file.to_str().unwrap();
    refused(
        &[file, "--wall", "1"],
        &["0.1100 units long: m (0.110 m)", "--unit"],
    );
    refused(&[file, "--unit", "m"], &["--wall"]);
    refused(&[file, "--unit", "m", "--wall", "0"], &["above 0"]);
}

/// A skin without a second wall has no thickness to measure.
#[test]
fn an_open_skin_is_no_solid() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let file = fixture("shin_skin.glb");
    let words = [
        file.to_str().unwrap(),
        "--unit",
        "m",
        "--wall",
        "measured",
        "--out",
        out,
    ];
    let said = refused(
        &words,
        &["a closed solid is wanted", "open edges", "252.898 cm3"],
    );
    assert!(said.contains("no part of the surface"), "{said}");
}

#[test]
fn a_wall_that_does_not_fit_asks_for_the_middle() {
    let file = fixture("shin_skin.glb");
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let words = [
        file.to_str().unwrap(),
        "--unit",
        "m",
        "--wall",
        "90",
        "--edge",
        "2.75",
        "--out",
        out,
    ];
    refused(&words, &["turns over", "--side middle"]);
}

#[test]
fn the_ribbed_solid_is_not_its_plain_skin() {
    let limb = shin_limb();
    let path = fixture("scene.json");
    let scene = hapdef::scene::read_scene(&path).unwrap();
    let solid = hapdef::Limb::load(&scene, path.parent().unwrap()).unwrap();
    let comparison = limb.against_solid("the ribbed limb", &solid).unwrap();
    println!("{comparison}");
    assert_eq!(
        comparison.verdict,
        ShellVerdict::UseTheSolid,
        "{comparison}"
    );
    assert!(comparison.shell.readings.median > 0.5, "{comparison}");
    assert_eq!(comparison.reading_difference.len(), solid.n_surface_nodes());
}

#[track_caller]
fn runs_through(file: &str) {
    let Some(path) = shared_limb(file) else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let words = [
        path.to_str().unwrap(),
        "--unit",
        "m",
        "--wall",
        "2",
        "--json",
        "--out",
        folder.path().to_str().unwrap(),
    ];
    let output = hapdef(&words);
    assert!(output.status.success(), "{}", said(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let limb = &report["limb"];
    let best = limb["median_best_ue_per_n"].as_f64().unwrap();
    println!("{file}: {best:.1} µε/N, {}", limb["model"]);
    assert!(best > 1.0);
    assert_eq!(limb["gauges"].as_array().unwrap().len(), 10);
    assert!(limb["model"]["worst_backward_error"].as_f64().unwrap() < 1e-11);
    assert!(limb["wall"]["volume_change"].as_f64().unwrap().abs() < 0.02);
}

#[test]
fn kinova_forearm_runs_through() {
    runs_through("kinova_forearm.glb");
}

#[test]
fn alexander_shin_runs_through() {
    runs_through("alexander_left_shin.glb");
}

#[test]
fn hyq_lower_leg_runs_through() {
    runs_through("hyq_lowerleg.glb");
}

#[track_caller]
fn refused_with_volume(file: &str, cause: &[&str]) {
    let Some(path) = shared_limb(file) else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    for wall in ["2", "measured"] {
        let words = [
            path.to_str().unwrap(),
            "--unit",
            "m",
            "--wall",
            wall,
            "--out",
            out,
        ];
        refused(&words, cause);
    }
}

#[test]
fn go2_calf_is_refused() {
    refused_with_volume(
        "go2_calf.glb",
        &["open edges", "non-manifold edges", "volume 166.102 cm3"],
    );
}

#[test]
fn poppy_part_is_refused() {
    refused_with_volume(
        "poppy_r_shin_part.glb",
        &[
            "7 non-manifold edges",
            "2 non-manifold vertices",
            "volume 38.874 cm3",
        ],
    );
}
