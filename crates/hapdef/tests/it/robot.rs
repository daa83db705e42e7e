//! Robot files: what is read, and what is refused with words that name the place.

use std::path::Path;

use hapdef::{LimbSource, Robot, is_robot_file, read_robot};
use serde_json::{Value, json};

/// A robot of two limbs that are there.
fn good() -> Value {
    json!({
        "name": "arm",
        "limbs": [
            {"name": "forearm", "scene": "forearm", "source": "sim", "seed": 3, "frame": "forearm_link"},
            {"name": "hand", "scene": "hand.hapdef", "source": "tcp:robot:7000", "frame": "hand_link"},
        ],
    })
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("forearm")).unwrap();
    std::fs::write(folder.path().join("forearm/scene.json"), "{}").unwrap();
    std::fs::write(folder.path().join("hand.hapdef"), "").unwrap();
    folder
}

fn read(folder: &Path, text: &str) -> Result<Robot, String> {
    let path = folder.join("robot.json");
    std::fs::write(&path, text).unwrap();
    read_robot(&path).map_err(|error| error.to_string())
}

#[track_caller]
fn refused(change: impl FnOnce(&mut Value), words: &[&str]) {
    let folder = folder();
    let mut robot = good();
    change(&mut robot);
    let why = read(folder.path(), &robot.to_string()).unwrap_err();
    for word in words.iter().chain(&["robot.json: "]) {
        assert!(why.contains(word), "{word:?} is not in: {why}");
    }
}

#[test]
fn a_robot_is_read_with_paths_from_its_file() {
    let folder = folder();
    let robot = read(folder.path(), &good().to_string()).unwrap();
    let names: Vec<&str> = robot.limbs.iter().map(|limb| limb.name.as_str()).collect();
    assert_eq!((robot.name.as_str(), names), ("arm", vec!["forearm", "hand"]));
    let [forearm, hand] = &robot.limbs[..] else { panic!("{robot:?}") };
    assert_eq!(forearm.scene, folder.path().join("forearm/scene.json"));
    assert_eq!(forearm.source, LimbSource::Sim { seed: 3 });
    assert_eq!(hand.source, LimbSource::Readings("tcp:robot:7000".parse().unwrap()));
    assert_eq!((hand.frame.as_str(), robot.prefix(hand)), ("hand_link", "/arm/hand".to_owned()));
}

#[test]
fn a_recording_is_found_beside_the_file_and_may_be_played_twice() {
    let folder = folder();
    let mut robot = good();
    for limb in robot["limbs"].as_array_mut().unwrap() {
        limb["source"] = json!("replay:bag.mcap@max");
        limb["topic"] = json!("/strain");
        limb.as_object_mut().unwrap().remove("seed");
    }
    let robot = read(folder.path(), &robot.to_string()).unwrap();
    let LimbSource::Readings(source) = &robot.limbs[1].source else { panic!("{robot:?}") };
    let file = folder.path().join("bag.mcap");
    assert_eq!(source.to_string(), format!("replay:{}@max, topic /strain", file.display()));
}

#[test]
fn what_is_no_robot_is_refused_with_the_place() {
    let folder = folder();
    let missing = read_robot(&folder.path().join("none.json")).unwrap_err().to_string();
    assert!(missing.contains("none.json") && missing.contains("check the path"), "{missing}");
    let cut = read(folder.path(), "{\"name\": \"arm\", ").unwrap_err();
    assert!(cut.contains("no whole JSON"), "{cut}");
    let more = read(folder.path(), &format!("{} {{}}", good())).unwrap_err();
    assert!(more.contains("no whole JSON"), "{more}");
    refused(|r| r["limbs"][1]["colour"] = json!(1), &["limbs[1].colour", "unknown field"]);
    refused(
        |r| drop(r["limbs"][0].as_object_mut().unwrap().remove("frame")),
        &["limbs[0]", "missing field `frame`"],
    );
    refused(|r| r["limbs"][1]["name"] = json!(7), &["limbs[1].name", "expected a string"]);
}

#[test]
fn names_that_topics_cannot_have_are_refused() {
    for name in ["", "fore arm", "2nd", "a__b", "a/b", "a-b", "ärm", "..", "a\n"] {
        refused(|r| r["limbs"][1]["name"] = json!(name), &["limbs[1].name", "no digit first"]);
        refused(|r| r["name"] = json!(name), &["at name", "no digit first"]);
    }
    for frame in ["", "a frame"] {
        refused(|r| r["limbs"][1]["frame"] = json!(frame), &["limbs[1].frame", "a frame's name"]);
    }
}

#[test]
fn limbs_that_share_what_is_ones_own_are_refused() {
    refused(|r| r["limbs"] = json!([]), &["at limbs", "found none", "add one"]);
    refused(|r| r["limbs"][1]["name"] = json!("forearm"), &["limbs[1].name", "limbs[0]"]);
    refused(
        |r| r["limbs"][1]["frame"] = json!("forearm_link"),
        &["limbs[1].frame", "forearm_link", "own link"],
    );
    let both = |first: &str, second: &str| {
        let (first, second) = (json!(first), json!(second));
        move |robot: &mut Value| {
            robot["limbs"][0].as_object_mut().unwrap().remove("seed");
            robot["limbs"][0]["source"] = first;
            robot["limbs"][1]["source"] = second;
        }
    };
    let words = ["limbs[1].source", "limbs[0]", "a device of its own"];
    refused(both("serial:/dev/ttyACM7", "/dev/ttyACM7"), &words);
    refused(both("serial:/dev/ttyACM7@9600", "csv:/dev/ttyACM7@4"), &words);
    refused(both("tcp:robot:7000", "tcp:robot:7000"), &words);
}

#[cfg(unix)]
#[test]
fn a_port_is_one_by_any_of_its_names() {
    let ports = tempfile::tempdir().unwrap();
    let (port, by_id) = (ports.path().join("tty"), ports.path().join("usb-arduino"));
    std::fs::write(&port, "").unwrap();
    std::os::unix::fs::symlink(&port, &by_id).unwrap();
    let change = |robot: &mut Value| {
        robot["limbs"][0].as_object_mut().unwrap().remove("seed");
        robot["limbs"][0]["source"] = json!(format!("serial:{}", port.display()));
        robot["limbs"][1]["source"] = json!(format!("serial:{}", by_id.display()));
    };
    refused(change, &["limbs[1].source", "a device of its own"]);
}

#[test]
fn sources_and_files_that_cannot_be_are_refused() {
    refused(
        |r| r["limbs"][1]["source"] = json!("usb:1"),
        &["limbs[1].source", "usb:1", "tcp:HOST:PORT", "\"sim\""],
    );
    refused(|r| r["limbs"][1]["scene"] = json!("none.json"), &["limbs[1].scene", "none.json"]);
    refused(|r| r["limbs"][1]["seed"] = json!(1), &["limbs[1].seed", "tcp:robot:7000"]);
    for limb in 0..2 {
        let at = format!("limbs[{limb}].topic");
        refused(|r| r["limbs"][limb]["topic"] = json!("/strain"), &[&at, "of ROS 2 alone"]);
    }
}

#[test]
fn a_robot_file_is_told_from_a_scene() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("left.json"), good().to_string()).unwrap();
    assert!(is_robot_file(&at("left.json")) && is_robot_file(&at("robot.json")));
    assert!(!is_robot_file(&at("forearm/scene.json")) && !is_robot_file(&at("hand.hapdef")));
    assert!(!is_robot_file(folder.path()) && !is_robot_file(&at("none.json")));
}
