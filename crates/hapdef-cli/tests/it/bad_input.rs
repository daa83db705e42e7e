//! Bad input gets one clear error, exit code 2, and leaves nothing half-written.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use hapdef_mesh::{SurfaceMesh, write_glb};
use serde_json::{Value, json};

use crate::support::page::scene_with_gltf;
use crate::support::shared;

fn shin() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin")
}

fn hapdef(words: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hapdef")).args(words).current_dir(folder).output().unwrap()
}

/// The bundled scene with its deck beside it, changed by `change`, in a folder of its own.
fn scene_with(folder: &Path, change: impl FnOnce(&mut Value)) {
    let text = fs::read(shin().join("scene.json")).unwrap();
    let mut scene: Value = serde_json::from_slice(&text).unwrap();
    change(&mut scene);
    fs::write(folder.join("scene.json"), scene.to_string()).unwrap();
    let deck = scene["geometry"]["solid_deck"].as_str().unwrap().to_owned();
    if !folder.join(&deck).exists() {
        fs::copy(shin().join("shin.inp.gz"), folder.join(deck)).unwrap();
    }
}

#[track_caller]
fn refused(change: impl FnOnce(&mut Value), expected: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    scene_with(folder.path(), change);
    refused_in(folder.path(), expected);
}

#[track_caller]
fn refused_in(folder: &Path, expected: &[&str]) {
    refused_by("simulate", folder, expected);
}

#[track_caller]
fn refused_by(command: &str, folder: &Path, expected: &[&str]) {
    refused_words(&[command, "scene.json"], folder, expected);
}

#[track_caller]
fn refused_words(words: &[&str], folder: &Path, expected: &[&str]) -> String {
    let output = hapdef(words, folder);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert_eq!(text.matches("error:").count(), 1, "{text}");
    for words in expected {
        assert!(text.contains(words), "{words:?} is not in: {text}");
    }
    let cache = fs::read_dir(folder.join("target/hapdef/cache"));
    let left: Vec<_> = cache.into_iter().flatten().map(|entry| entry.unwrap().path()).collect();
    let is_lock = |path: &PathBuf| path.extension().is_some_and(|e| e == "lock");
    assert!(left.iter().all(is_lock), "left behind: {left:?}");
    text
}

#[test]
fn a_field_that_does_not_exist() {
    refused(|scene| scene["contact"]["tip"] = json!(1), &["contact", "unknown field `tip`"]);
}

#[test]
fn a_field_of_the_wrong_type() {
    refused(|scene| scene["gauges"]["sites"][3]["axis"] = json!("up"), &["gauges.sites[3].axis"]);
}

#[test]
fn a_field_that_this_mount_does_not_have() {
    refused(
        |scene| scene["mount"] = json!({"kind": "deck", "name": "FOOT"}),
        &["mount", "unknown field `name`"],
    );
}

#[test]
fn a_value_out_of_range() {
    refused(
        |scene| scene["contact"]["force_range_n"] = json!([34, 0]),
        &["contact.force_range_n", "[34, 0]"],
    );
}

#[test]
fn a_scene_that_is_no_json() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.json"), "{\"name\": ").unwrap();
    refused_in(folder.path(), &["scene.json", "EOF", "line 1 column 9"]);
}

/// Cut off within a field: its path means little there, line and column say where.
#[test]
fn a_scene_that_is_cut_off() {
    let folder = tempfile::tempdir().unwrap();
    scene_with(folder.path(), |_| {});
    let file = folder.path().join("scene.json");
    let text = fs::read(&file).unwrap();
    fs::write(&file, &text[..300]).unwrap();
    refused_in(folder.path(), &["no whole JSON", "line 1 column 300"]);
}

#[test]
fn what_is_no_scene_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let cases = [
        ("limb.glb", "hapdef new"),
        ("limb.GLTF", "hapdef new"),
        ("limb.hapdef", "hapdef live"),
        ("limb.json", "docs/scene.md"),
    ];
    for (name, advice) in cases {
        fs::write(folder.path().join(name), b"glTF\x02\0\0\0\xff").unwrap();
        refused_words(&["check", name], folder.path(), &[name, "expected JSON text", advice]);
    }
}

#[test]
fn a_calibration_that_is_not_there_or_of_another_limb() {
    let folder = tempfile::tempdir().unwrap();
    let calibrated = |scene: &mut Value| {
        scene["estimator"] = json!({
            "kind": "superposition", "noise_ue": 1.0, "calibration": "made.json.gz"
        });
    };
    scene_with(folder.path(), calibrated);
    let expected = ["estimator.calibration", "made.json.gz", "hapdef calibrate"];
    refused_by("check", folder.path(), &expected);
    let made = folder.path().join("made.json.gz");
    fs::copy(shin().join("demo_calibration.json.gz"), made).unwrap();
    scene_with(folder.path(), |scene| {
        calibrated(scene);
        scene["gauges"]["sites"].as_array_mut().unwrap().pop();
    });
    let expected = ["estimator.calibration", "of another scene: n_gauges"];
    refused_by("check", folder.path(), &expected);
}

#[cfg(not(feature = "cuda"))]
#[test]
fn a_backend_that_is_not_built_in() {
    let folder = tempfile::tempdir().unwrap();
    scene_with(folder.path(), |_| ());
    let words = ["train", "scene.json", "--backend", "cuda:1"];
    let expected = ["--backend", "ordinal: 1", "feature"];
    refused_words(&words, folder.path(), &expected);
}

#[test]
fn a_deck_in_metres_called_millimetres() {
    refused(
        |scene| scene["geometry"]["unit"] = json!("mm"),
        &["contact region", "check the unit", "0.05 to 0.8 m"],
    );
}

#[test]
fn a_layout_without_gauges() {
    let folder = tempfile::tempdir().unwrap();
    scene_with(folder.path(), |_| {});
    let words = ["place", "scene.json", "--gauges", "0"];
    refused_words(&words, folder.path(), &["--gauges", "1.."]);
    assert!(!folder.path().join("target").exists());
}

/// Refused before anything is solved for it.
#[test]
fn a_replay_of_what_is_no_recording() {
    let folder = tempfile::tempdir().unwrap();
    scene_with(folder.path(), |_| {});
    fs::write(folder.path().join("notes.md"), "# Notes\n").unwrap();
    let words = ["live", "scene.json", "--source", "replay:notes.md"];
    let said = refused_words(&words, folder.path(), &["notes.md: 8 bytes", "a recording"]);
    assert!(!said.contains("solving"), "{said}");
}

#[test]
fn frames_from_nowhere() {
    let words = ["live", "shin.hapdef"];
    let folder = tempfile::tempdir().unwrap();
    refused_words(&words, folder.path(), &["--source", "--sim"]);
}

#[test]
fn a_deck_that_is_not_there() {
    let folder = tempfile::tempdir().unwrap();
    scene_with(folder.path(), |_| {});
    fs::remove_file(folder.path().join("shin.inp.gz")).unwrap();
    refused_in(folder.path(), &["geometry.solid_deck", "shin.inp.gz", "relative to the scene"]);
}

#[test]
fn a_truncated_deck() {
    let folder = tempfile::tempdir().unwrap();
    scene_with(folder.path(), |_| {});
    let deck = folder.path().join("shin.inp.gz");
    let bytes = fs::read(&deck).unwrap();
    fs::write(&deck, &bytes[..bytes.len() / 2]).unwrap();
    refused_in(folder.path(), &["shin.inp.gz"]);
}

#[test]
fn a_node_set_that_the_deck_does_not_have() {
    refused(
        |scene| scene["mount"] = json!({"kind": "node_set", "name": "ANKLE"}),
        &["mount", "ANKLE", "MOUNT"],
    );
}

#[test]
fn a_mount_that_holds_nothing() {
    refused(
        |scene| {
            scene["mount"] = json!({"kind": "box", "min_m": [1, 1, 1], "max_m": [2, 2, 2]});
        },
        &["mount", "no node lies in the box", "name a node set"],
    );
}

/// A second body, far from the first: a deck goes on where its compressed file does.
#[test]
fn a_body_that_nothing_holds() {
    let folder = tempfile::tempdir().unwrap();
    scene_with(folder.path(), |_| {});
    let path = folder.path().join("shin.inp.gz");
    let mut file = fs::OpenOptions::new().append(true).open(path).unwrap();
    let mut more = flate2::write::GzEncoder::new(&mut file, flate2::Compression::fast());
    let body = "*NODE\n900001, 1., 0., 0.\n900002, 1.01, 0., 0.\n900003, 1., 0.02, 0.\n\
                900004, 1., 0., 0.03\n*ELEMENT, TYPE=C3D4\n900001, 900001, 900002, 900003, 900004\n";
    more.write_all(body.as_bytes()).unwrap();
    more.finish().unwrap();
    let expected = ["none of the 1 elements", "(1005.0, 10.0, 15.0) mm", "10.0 x 20.0 x 30.0 mm"];
    refused_by("check", folder.path(), &expected);

    let Some(tubes) = shared("inputs/field/gmsh/two_tubes_scene.json") else { return };
    let tubes = tubes.display().to_string();
    refused_words(
        &["check", &tubes],
        folder.path(),
        &["mount: it holds none of the", "one of 2 that"],
    );
}

/// One clamped node does not hold the limb: it can still turn about it.
#[test]
fn a_mount_that_lets_the_limb_turn() {
    let deck = hapdef_mesh::read_deck(&shin().join("shin.inp.gz")).unwrap();
    let node = deck.mesh.nodes()[0];
    let around = |by: f64| [node.x + by, node.y + by, node.z + by];
    refused(
        |scene| {
            scene["mount"] = json!({"kind": "box", "min_m": around(-1e-6), "max_m": around(1e-6)});
        },
        &["the supports leave", "free to move"],
    );
}

#[test]
fn a_gauge_off_the_wall() {
    refused(
        |scene| scene["gauges"]["sites"][2]["position_m"] = json!([0.0, 0.1, 0.0]),
        &["gauges.sites[2] (g2)", "from the nearest wall face", "move it onto the wall"],
    );
}

#[test]
fn a_contact_region_without_skin() {
    refused(|scene| scene["contact"]["region"]["axial_range_m"] = json!([5.0, 6.0]), &["region"]);
}

/// `hapdef check` refuses the rig's own deck, which `prepare` puts or changes at the path it is given.
#[track_caller]
fn rig_deck_refused(prepare: impl FnOnce(&Path), expected: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    scene_with(folder.path(), |scene| {
        scene["rig"]["mesh"] = json!({"kind": "deck", "solid_deck": "other.inp.gz"});
    });
    prepare(&folder.path().join("other.inp.gz"));
    let expected = [&["rig.mesh.solid_deck", "other.inp.gz"], expected].concat();
    refused_by("check", folder.path(), &expected);
}

#[test]
fn a_rigs_deck_that_is_not_there() {
    rig_deck_refused(|_| {}, &["relative to the scene"]);
    rig_deck_refused(|path| fs::create_dir(path).unwrap(), &["relative to the scene"]);
}

#[test]
fn a_rigs_deck_that_is_truncated_or_none() {
    let bytes = fs::read(shin().join("shin_rig.inp.gz")).unwrap();
    let half = &bytes[..bytes.len() / 2];
    let advice = &["must be found on it"];
    rig_deck_refused(|path| fs::write(path, half).unwrap(), advice);
    rig_deck_refused(|path| fs::write(path, "no deck").unwrap(), advice);
}

#[test]
fn a_rigs_deck_that_is_the_limbs() {
    let same = |path: &Path| {
        fs::copy(shin().join("shin.inp.gz"), path).unwrap();
    };
    rig_deck_refused(same, &["the simulated hardware would be the model"]);
}

#[test]
fn a_drawn_skin_that_is_missing_or_elsewhere() {
    let folder = tempfile::tempdir().unwrap();
    scene_with(folder.path(), |scene| {
        scene["geometry"]["skin_gltf"] = json!("skin.glb");
    });
    let expected = ["geometry.skin_gltf", "skin.glb", "relative to the scene"];
    refused_by("check", folder.path(), &expected);
    let corners = [[1.0, 0.0, 0.0], [1.1, 0.0, 0.0], [1.0, 0.1, 0.0]].map(Into::into);
    let surface = SurfaceMesh::new(corners.to_vec(), vec![[0, 1, 2]]).unwrap();
    write_glb(&folder.path().join("skin.glb"), &surface, None).unwrap();
    let expected = ["geometry.skin_gltf", "skin.glb", "in the deck's frame"];
    refused_by("check", folder.path(), &expected);
}

/// The bundled skin is drawn from y = 46 mm to 156 mm, and touched from 40 to 162.
#[test]
fn how_far_the_touchable_skin_is_off_the_drawn_one_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let said = |scene: &Path| {
        let output = hapdef(&["check", scene.to_str().unwrap()], folder.path());
        assert!(output.status.success(), "{output:?}");
        String::from_utf8(output.stdout).unwrap()
    };
    let own = said(&shin().join("demo.json"));
    assert!(
        own.contains("drawn skin: the limb's own, of which the touchable skin is a part"),
        "{own}"
    );
    let shorter = said(&scene_with_gltf(folder.path()));
    let words = shorter.split_once("the touchable skin is at most ").expect(&shorter).1;
    let (gap_mm, rest) = words.split_once(" mm off the drawn one, at (").expect(&shorter);
    let gap_mm: f64 = gap_mm.parse().unwrap();
    let y_mm: f64 = rest.split(", ").nth(1).unwrap().parse().unwrap();
    assert!((4.0..8.0).contains(&gap_mm), "{shorter}");
    assert!(!(46.0..=156.0).contains(&y_mm), "{shorter}");
}

/// A deck of another limb: what the scene names is not on it.
#[test]
fn a_rigs_deck_of_another_limb() {
    let other = "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,.5,0,0\n6,.5,.5,0\n7,0,.5,0\n\
                 8,0,0,.5\n9,.5,0,.5\n10,0,.5,.5\n*ELEMENT,TYPE=C3D10,ELSET=ALL\n\
                 1,1,2,3,4,5,6,7,8,9,10\n";
    let folder = tempfile::tempdir().unwrap();
    scene_with(folder.path(), |scene| {
        scene["rig"]["mesh"] = json!({"kind": "deck", "solid_deck": "other.inp"});
    });
    fs::write(folder.path().join("other.inp"), other).unwrap();
    let expected = ["rig.mesh.solid_deck", "other.inp", "MOUNT"];
    refused_by("check", folder.path(), &expected);
}

/// Khronos' broken files, each refused or read whole: what its validator finds wrong with the
/// container, the accessors or the positions must not get through silently.
#[test]
fn khronos_files_are_read_or_refused_with_one_error() {
    let Some(folder) = shared("inputs/gltf/khronos-validator") else { return };
    let mut n_refused = 0;
    for file in ["glb", "mesh"].into_iter().flat_map(|kind| files(&folder.join(kind))) {
        let output = hapdef(&["inspect", &file.display().to_string()], &folder);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        match output.status.code() {
            Some(0) => assert!(error.is_empty(), "{}: {error}", file.display()),
            Some(2) => {
                n_refused += 1;
                let name = file.file_name().unwrap().to_string_lossy().into_owned();
                assert!(error.contains(&name), "{error} does not name {name}");
                assert_eq!(error.matches("error:").count(), 1, "{error}");
            }
            code => panic!("{}: exit code {code:?}: {error}", file.display()),
        }
    }
    assert!(n_refused >= 20, "only {n_refused} files were refused");
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let is_model = |path: &PathBuf| path.extension().is_some_and(|e| e == "glb" || e == "gltf");
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> = entries.filter(is_model).collect();
    files.sort();
    files
}
