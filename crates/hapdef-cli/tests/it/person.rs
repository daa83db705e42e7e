//! Commands that ask a person to press, answered by one who presses a simulated board on TCP, also when
//! nobody has asked.

use crate::support::page;

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::time::Duration;

use hapdef::{Limb, Profile, Progress, Run, VirtualRigParams, live_limb, virtual_device};
use hapdef_rig::live::{
    DevicePort, LiveLimb, PressHandle, Pressed, RigFault, RunParams, RunningRig, TcpPort, spawn_rig,
};
use nalgebra::Point3;
use serde_json::Value;

const FORCE_N: f64 = 15.0;
const N_PRESSES: usize = 12;
/// How long a press near a gauge lasts, and what a person takes to do anything.
const WHILE: Duration = Duration::from_millis(200);
/// Most that a kept press may be off the limb's own strains: gains are 3 % off, steps are coarse.
const WORST_OFF: f64 = 0.15;

/// The bundled limb's virtual rig as a board on TCP, which the docs' commands solve and keep.
struct Board {
    rig: RunningRig,
    limb: Arc<LiveLimb>,
    scene: PathBuf,
    source: String,
}

impl Board {
    fn start(folder: &Path, faults: &[RigFault]) -> Self {
        let scene = page::scene(folder);
        let run = Run::new(&scene, Profile::full(), &out(), 2, Progress::silent()).unwrap();
        let limb = Limb::load(&run.scene, &run.scene_dir).unwrap();
        let limb = Arc::new(live_limb(&run, &limb).unwrap());
        let params = VirtualRigParams { faults: faults.to_vec(), ..VirtualRigParams::default() };
        let device = virtual_device(&run.scene, Arc::clone(&limb), &params).unwrap();
        let port = TcpPort::listen("127.0.0.1:0").unwrap();
        let source = format!("tcp:{}", port.name());
        let rig = spawn_rig(device, port, RunParams::default(), |_| {}).unwrap();
        Self { rig, limb, scene, source }
    }

    fn finger(&self) -> PressHandle {
        self.rig.press_handle()
    }

    /// Strains under a normal press, µε `[n_gauges]`.
    fn strains_ue(&self, position: &Point3<f64>, force_n: f64) -> Vec<f64> {
        let (point, _) = self.limb.nearest(position).unwrap();
        let mut strains = vec![0.0; self.limb.n_gauges()];
        let force = self.limb.inward(&point) * force_n;
        self.limb.add_strain_ue(&point, &force, &mut strains);
        strains
    }
}

fn out() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/hapdef")
}

/// Runs the command; each line that it says to the person goes to `hear`.
fn converse(words: &[&str], mut hear: impl FnMut(&str)) -> (ExitStatus, String) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_hapdef"))
        .args(words)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let said = BufReader::new(child.stderr.take().unwrap()).lines();
    for line in said.map_while(Result::ok) {
        println!("{line}");
        hear(&line);
    }
    let output = child.wait_with_output().unwrap();
    (output.status, String::from_utf8(output.stdout).unwrap())
}

fn pressed(position: Point3<f64>) -> Vec<Pressed> {
    vec![Pressed::normal(1, position, FORCE_N)]
}

/// Presses near each gauge that doctor asks for: names of the gauges that it finds bad, and its words.
fn press_check(faults: &[RigFault]) -> (bool, Vec<String>) {
    let folder = tempfile::tempdir().unwrap();
    let board = Board::start(folder.path(), faults);
    let text = std::fs::read_to_string(&board.scene).unwrap();
    let scene: Value = serde_json::from_str(&text).unwrap();
    let sites = scene["gauges"]["sites"].as_array().unwrap().clone();
    let finger = board.finger();
    let path = board.scene.to_str().unwrap();
    let words = ["doctor", path, "--source", &board.source, "--press-check"];
    let (status, found) =
        converse(&[&words[..], &["--seconds", "0.5", "--json"]].concat(), |line| {
            let asked = line.strip_prefix("press near gauge ");
            let Some((name, _)) = asked.and_then(|rest| rest.split_once(',')) else {
                return;
            };
            let site = sites.iter().find(|site| site["name"] == name).unwrap();
            let at = [0, 1, 2].map(|k| site["position_m"][k].as_f64().unwrap());
            std::thread::sleep(WHILE);
            finger.set(pressed(at.into()));
            std::thread::sleep(WHILE);
            finger.set(Vec::new());
        });
    println!("{found}");
    let checks: Vec<Value> = serde_json::from_str(&found).unwrap();
    let of_presses = checks.iter().filter(|check| {
        let name = check["check"].as_str().unwrap();
        name.starts_with("press near ")
    });
    let of_presses: Vec<&Value> = of_presses.collect();
    assert_eq!(of_presses.len(), sites.len());
    let bad = of_presses.into_iter().filter(|c| c["state"] == "bad");
    let reported = bad.map(|c| format!("{} {}", c["check"], c["found"]));
    (status.success(), reported.collect())
}

#[test]
fn each_gauge_answers_the_press_near_it_and_swapped_ones_for_each_other() {
    let (_, bad) = press_check(&[]);
    assert!(bad.is_empty(), "{bad:?}");
    let (is_well, bad) = press_check(&["swap=1,7".parse().unwrap()]);
    assert!(!is_well);
    assert_eq!(bad.len(), 2, "{bad:?}");
    assert!(bad[0].contains("near g1") && bad[0].contains("channel 7"));
    assert!(bad[1].contains("near g7") && bad[1].contains("channel 1"));
}

/// A finger that rests on the limb while it is solved, and comes before it is asked for, is in no press
/// that is kept.
#[test]
fn only_presses_that_were_asked_for_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let board = Board::start(folder.path(), &[]);
    let table = folder.path().join("presses.csv");
    let result = folder.path().join("calibration.json");
    let [scene, table, result] = [&board.scene, &table, &result].map(|p| p.to_str().unwrap());
    let kept = out();
    let (finger, stray) = (board.finger(), Point3::new(-0.03, 0.1, 0.015));
    let (n, force) = (N_PRESSES.to_string(), FORCE_N.to_string());
    let mut words = vec!["calibrate", scene, table, result, "--live", &board.source];
    words.extend(["--presses", &n, "--force-n", &force, "--json"]);
    words.extend(["--results", kept.to_str().unwrap()]);
    let (status, reported) = converse(&words, |line| {
        if line.starts_with("solving") {
            finger.set(pressed(stray));
        } else if line.starts_with("taking the tare") || line.starts_with("  let go") {
            finger.set(Vec::new());
        } else if let Some(at) = asked(line) {
            std::thread::sleep(WHILE);
            finger.set(pressed(at));
        }
    });
    assert!(status.success());
    let reported: Value = serde_json::from_str(&reported).unwrap();
    let error = |key: &str| reported[key].as_f64().unwrap();
    assert!(error("relative_error") < error("relative_error_before"), "{reported}");

    let rows = std::fs::read_to_string(table).unwrap();
    assert_eq!(rows.lines().count(), 1 + N_PRESSES);
    for row in rows.lines().skip(1) {
        let row: Vec<f64> = row.split(',').map(|v| v.parse().unwrap()).collect();
        let strains = board.strains_ue(&Point3::new(row[0], row[1], row[2]), row[3]);
        let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|x| x * x).sum::<f64>().sqrt();
        let off = norm(&mut strains.iter().zip(&row[4..]).map(|(a, b)| a - b));
        let off = off / norm(&mut strains.iter().copied());
        println!("{:.1} % off the limb's strains", 100.0 * off);
        assert!(off < WORST_OFF, "{row:?}: {strains:?}");
    }
}

/// Where `press 3: 15 N at (1.0, 2.0, 3.0) mm` wants it, m.
fn asked(line: &str) -> Option<Point3<f64>> {
    let (_, rest) = line.strip_prefix("press ")?.split_once('(')?;
    let (numbers, _) = rest.split_once(')')?;
    let mm: Vec<f64> = numbers.split(", ").map(|v| v.parse().unwrap()).collect();
    Some(Point3::new(mm[0], mm[1], mm[2]) * 1e-3)
}
