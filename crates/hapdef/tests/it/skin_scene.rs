//! Scenes of a skin and its wall, and what a scene leaves out.

use std::path::{Path, PathBuf};

use crate::shell_limb_common::bottle;
use hapdef::scene::{Scene, Shape, WallThickness, read_scene};
use hapdef::{HapdefError, Limb};
use hapdef_mesh::{SkinRegion, SurfaceMesh, write_glb};
use nalgebra::Vector3;
use proptest::prelude::*;
use serde_json::{Value, json};

const WALL_M: f64 = 2e-3;
/// Sections and fields that a scene may leave out.
const OPTIONAL: [&str; 20] = [
    "/name",
    "/seed",
    "/geometry/axis",
    "/geometry/side",
    "/geometry/refinements",
    "/material",
    "/contact",
    "/contact/region",
    "/contact/region/rule",
    "/contact/tip_radius_m",
    "/contact/max_contacts",
    "/gauges/length_m",
    "/gauges/patch_nodes",
    "/rig",
    "/rig/mesh/kind",
    "/rig/mesh/times",
    "/rig/max_wall_m",
    "/rig/electronics/adc_bits",
    "/estimator",
    "/estimator/kind",
];

fn short() -> Value {
    json!({
        "geometry": {"skin": "skin.glb", "wall_m": WALL_M, "unit": "m"},
        "mount": {"kind": "plane", "point_m": [0.0, 0.0, 0.01], "normal": [0.0, 0.0, -1.0]},
        "gauges": {"sites": [
            {"name": "g0", "position_m": [0.028, 0.0, 0.1], "axis": [0.0, 0.0, 1.0]}
        ]},
    })
}

fn written(folder: &Path, scene: &Value) -> PathBuf {
    if !folder.join("skin.glb").exists() {
        write_glb(&folder.join("skin.glb"), &bottle(), None).unwrap();
    }
    let path = folder.join("scene.json");
    std::fs::write(&path, scene.to_string()).unwrap();
    path
}

fn loaded(folder: &Path, scene: &Value) -> Result<(Scene, Limb), HapdefError> {
    let scene = read_scene(&written(folder, scene))?;
    let limb = Limb::load(&scene, folder)?;
    Ok((scene, limb))
}

#[track_caller]
fn refused(scene: &Value, surface: &SurfaceMesh, expected: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    write_glb(&folder.path().join("skin.glb"), surface, None).unwrap();
    let error = loaded(folder.path(), scene).err().unwrap();
    let text = hapdef::error_text(&error);
    for words in expected {
        assert!(text.contains(words), "{words:?} is not in: {text}");
    }
}

/// Area in mm², and the mean distance of its nodes from the axis in mm.
fn size(limb: &Limb, skin: &SkinRegion) -> [f64; 2] {
    let off = skin.nodes.iter().map(|node| limb.mesh.position(*node).coords.xy().norm());
    [skin.area_m2(&limb.mesh) * 1e6, 1e3 * off.sum::<f64>() / skin.nodes.len() as f64]
}

#[test]
fn a_skin_with_a_wall_is_a_limb() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, limb) = loaded(folder.path(), &short()).unwrap();
    limb.check_held().unwrap();
    let off = Vector3::from(limb.axis.direction) - Vector3::z();
    assert!(off.norm() < 1e-6 && limb.axis.point_m[2] > 0.0999, "{:?}", limb.axis);
    assert!((limb.max_wall_m - 1.5 * WALL_M).abs() < 1e-12);
    // 38 cm² a cm and the far dome, without 1 cm of mount
    let [area_mm2, off_mm] = size(&limb, &limb.skin);
    let expected_mm2 = std::f64::consts::TAU * 30.0 * (200.0 - 10.0 - 6.7);
    assert!((area_mm2 / expected_mm2 - 1.0).abs() < 0.05, "{area_mm2} {expected_mm2}");
    assert!(off_mm > 25.0, "{off_mm}");
    let is_held = |node| limb.clamped.binary_search(node).is_ok();
    assert!(!limb.skin.nodes.iter().any(is_held));
    assert!(limb.clamped.iter().all(|node| limb.mesh.position(*node).z <= 0.01 + 1e-9));
    assert_eq!(scene.name, folder.path().file_name().unwrap().to_str().unwrap().replace('.', "-"));
}

#[test]
fn an_inner_skin_has_its_wall_outside() {
    let folder = tempfile::tempdir().unwrap();
    let mut inner = short();
    inner["geometry"]["side"] = json!("inner");
    inner["gauges"]["sites"][0]["position_m"][0] = json!(0.03);
    let (_, limb) = loaded(folder.path(), &inner).unwrap();
    let farthest = limb.skin.nodes.iter().map(|n| limb.mesh.position(*n).coords.xy().norm());
    let farthest_m = farthest.fold(0.0, f64::max);
    assert!((farthest_m - 0.032).abs() < 1e-4, "{farthest_m}");
}

#[test]
fn a_wall_of_many_thicknesses_counts_in_the_hash() {
    let folder = tempfile::tempdir().unwrap();
    let (_, even) = loaded(folder.path(), &short()).unwrap();
    let n = bottle().vertices().len();
    std::fs::write(folder.path().join("wall.txt"), "0.002\n".repeat(n)).unwrap();
    let mut scene = short();
    scene["geometry"]["wall_m"] = json!("wall.txt");
    let (read, by_file) = loaded(folder.path(), &scene).unwrap();
    let Shape::Skin(skin) = &read.geometry.shape else { panic!("{:?}", read.geometry) };
    assert_eq!(skin.wall, WallThickness::File("wall.txt".into()));
    assert_eq!(by_file.mesh, even.mesh);
    assert_ne!(by_file.deck_hash, even.deck_hash);
    std::fs::write(folder.path().join("wall.txt"), "0.0019\n".repeat(n)).unwrap();
    let (_, thinner) = loaded(folder.path(), &scene).unwrap();
    assert_ne!(by_file.deck_hash, thinner.deck_hash);
    std::fs::write(folder.path().join("wall.txt"), "0.002\n-1\n").unwrap();
    let error = loaded(folder.path(), &scene).err().unwrap().to_string();
    assert!(error.contains("line 2: expected metres above 0"), "{error}");
}

#[test]
fn a_wall_by_regions_is_thicker_in_its_boxes() {
    let folder = tempfile::tempdir().unwrap();
    let mut scene = short();
    let of = |low: f64, high: f64, wall_m: f64| json!({"min_m": [-1.0, -1.0, low], "max_m": [1.0, 1.0, high], "wall_m": wall_m});
    scene["geometry"]["wall_m"] =
        json!({"elsewhere_m": WALL_M, "boxes": [of(-1.0, 0.05, 0.001), of(-1.0, 0.03, 0.003)]});
    let (read, limb) = loaded(folder.path(), &scene).unwrap();
    assert_eq!(json!(read)["geometry"]["wall_m"], scene["geometry"]["wall_m"]);
    let wall = limb.wall.as_ref().unwrap();
    for (node, wall_m) in wall.outside.nodes.iter().zip(&wall.thickness_m) {
        let expected = match limb.mesh.position(*node).z {
            z if z < 0.029 => 0.003,
            z if (0.037..0.045).contains(&z) => 0.001,
            z if z > 0.056 => WALL_M,
            _ => continue,
        };
        assert!((wall_m - expected).abs() < 1e-9, "{wall_m} {expected}");
    }
    scene["geometry"]["wall_m"]["boxes"][0]["min_m"] = json!([0.5, 0.5, -1.0]);
    let error = loaded(folder.path(), &scene).err().unwrap().to_string();
    assert!(error.contains("geometry.wall_m.boxes[0]: no vertex"), "{error}");
    scene["geometry"]["wall_m"]["boxes"][0]["wall_m"] = json!(0);
    let error = loaded(folder.path(), &scene).err().unwrap().to_string();
    assert!(error.contains("geometry.wall_m.boxes[0].wall_m"), "{error}");
}

#[test]
fn what_is_no_clean_skin_is_refused_with_the_remedy() {
    let bottle = bottle();
    let remedy = "hapdef new";
    let far = bottle.vertices().iter().map(|x| x + Vector3::x());
    let n = bottle.vertices().len() as u32;
    let twice = bottle.triangles().iter().map(|t| t.map(|v| v + n));
    let vertices = bottle.vertices().iter().copied().chain(far).collect();
    let triangles = bottle.triangles().iter().copied().chain(twice).collect();
    let two = SurfaceMesh::new(vertices, triangles).unwrap();
    refused(&short(), &two, &["geometry.skin", "2 bodies", remedy]);
    let inward = bottle.triangles().iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    let inward = SurfaceMesh::new(bottle.vertices().to_vec(), inward).unwrap();
    refused(&short(), &inward, &["face inward", remedy]);
    let mut doubled = bottle.triangles().to_vec();
    doubled.push(doubled[7]);
    let doubled = SurfaceMesh::new(bottle.vertices().to_vec(), doubled).unwrap();
    refused(&short(), &doubled, &["manifold surface", remedy]);
    let mut thick = short();
    thick["geometry"]["wall_m"] = json!(0.05);
    refused(&thick, &bottle, &["geometry.skin", remedy]);
}

#[test]
fn a_section_that_names_no_kind_has_the_usual_one() {
    let folder = tempfile::tempdir().unwrap();
    let mut scene = short();
    scene["estimator"] = json!({"noise_ue": 2.0});
    scene["contact"] = json!({"region": {"mount_gap_m": 0.004}});
    scene["rig"] = json!({"mesh": {"times": 2}});
    let full = json!(read_scene(&written(folder.path(), &scene)).unwrap());
    assert_eq!(full["estimator"]["kind"], "superposition");
    assert_eq!(full["estimator"]["noise_ue"], 2.0);
    assert_eq!(full["contact"]["region"], json!({"rule": "free_skin", "mount_gap_m": 0.004}));
    assert_eq!(full["rig"]["mesh"], json!({"kind": "refined", "times": 2}));
    scene["estimator"] = json!({"kmax_radius_m": 0.01});
    let error = read_scene(&written(folder.path(), &scene)).unwrap_err().to_string();
    assert!(error.contains("at estimator: unknown field `kmax_radius_m`"), "{error}");
}

#[test]
fn a_mount_that_holds_nothing_or_all_is_refused() {
    let held = |mount: Value, expected: &str| {
        let mut scene = short();
        scene["mount"] = mount;
        refused(&scene, &bottle(), &["mount", expected]);
    };
    let plane = |z: f64, up: f64| json!({"kind": "plane", "point_m": [0.0, 0.0, z], "normal": [0.0, 0.0, up]});
    held(plane(-0.01, -1.0), "no node lies on the plane");
    held(plane(-0.01, 1.0), "holds every node");
    held(json!({"kind": "end", "end": "high", "length_m": 0.3}), "holds every node");
    held(json!({"kind": "node_set", "name": "MOUNT"}), "it has none");
    held(json!({"kind": "deck"}), "fixes no node");
}

#[test]
fn a_gauge_that_no_press_moves_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let (_, limb) = loaded(folder.path(), &short()).unwrap();
    limb.check_reached().unwrap();
    let mut scene = short();
    scene["mount"]["point_m"][2] = json!(0.12);
    let (_, limb) = loaded(folder.path(), &scene).unwrap();
    let error = limb.check_reached().unwrap_err().to_string();
    assert!(error.contains("gauges.sites[0]") && error.contains("held by the mount"), "{error}");
}

#[test]
fn an_end_is_a_plane_across_the_axis() {
    let folder = tempfile::tempdir().unwrap();
    let (_, by_plane) = loaded(folder.path(), &short()).unwrap();
    let mut scene = short();
    scene["mount"] = json!({"kind": "end", "end": "low", "length_m": 0.01});
    let (_, by_end) = loaded(folder.path(), &scene).unwrap();
    assert_eq!(by_plane.clamped, by_end.clamped);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// A scene without any of its optional fields, filled in, says all there is and means the same.
    #[test]
    fn a_filled_scene_is_the_scene(without in proptest::collection::vec(any::<bool>(), OPTIONAL.len())) {
        let folder = tempfile::tempdir().unwrap();
        let (scene, limb) = loaded(folder.path(), &short()).unwrap();
        let full = json!(limb.filled(&scene));
        let mut left = full.clone();
        for (path, _) in OPTIONAL.iter().zip(&without).filter(|(_, without)| **without) {
            let (parent, field) = path.rsplit_once('/').unwrap();
            if let Some(Value::Object(fields)) = left.pointer_mut(parent) {
                prop_assert!(fields.remove(field).is_some(), "{}", path);
            }
        }
        let (scene, limb) = loaded(folder.path(), &left).unwrap();
        prop_assert_eq!(json!(limb.filled(&scene)), full.clone());
        let (scene, limb) = loaded(folder.path(), &full).unwrap();
        prop_assert_eq!(json!(&scene), full);
        prop_assert_eq!(json!(limb.filled(&scene)), json!(scene));
    }
}
