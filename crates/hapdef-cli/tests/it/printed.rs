//! What commands print: names and texts from outside command no terminal and make no line of their own, and a
//! reader that has enough is no error.

use std::ffi::OsStr;
use std::io::{BufRead, BufReader, Write};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::thread::JoinHandle;
use std::time::Duration;

use hapdef_daq::hdp1::{Encoder, FrameFlags, Hello, SampleFormat};
use hapdef_mesh::write_glb;
use serde_json::{Value, json};

use crate::recording_commands::made;
use crate::shell_limb_common::tube;

/// In a name or text: clears a terminal, begins a line, turns the writing.
const HOSTILE: &str = "a\x1b[2J\nerror: all is lost \u{9b}31m\u{202e}";
const INJECTED: &str = "error: all is lost";

fn shin(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin").join(file)
}

/// Results that the docs' commands solve and keep.
fn kept() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/hapdef")
}

fn hapdef(words: &[impl AsRef<OsStr>], folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hapdef"));
    command.args(words).current_dir(folder);
    command
}

/// Runs it with a hostile name in place of `NAME`; what it printed on both streams.
#[track_caller]
fn shown(words: &[&str], folder: &Path) -> Output {
    let words: Vec<String> = words.iter().map(|word| word.replace("NAME", HOSTILE)).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let output = hapdef(&words, folder).output().unwrap();
    harmless(&output);
    output
}

#[track_caller]
fn harmless(output: &Output) {
    for stream in [&output.stdout, &output.stderr] {
        let text = std::str::from_utf8(stream).unwrap();
        let is_bidi = |c: char| ('\u{202a}'..='\u{202e}').contains(&c);
        assert!(!text.chars().any(|c| is_bidi(c) || (c.is_control() && c != '\n')), "{text:?}");
        assert!(!text.lines().any(|line| line.starts_with(INJECTED)), "{text:?}");
    }
}

/// The bundled scene in a folder of its own, its first gauge with a hostile name, the file's name, too.
fn hostile_scene(folder: &Path) -> String {
    let mut scene: Value =
        serde_json::from_slice(&std::fs::read(shin("placed.json")).unwrap()).unwrap();
    scene["gauges"]["sites"][0]["name"] = json!(HOSTILE);
    scene["estimator"]["map_refinements"] = json!(0);
    let name = format!("{HOSTILE}.json");
    std::fs::write(folder.join(&name), scene.to_string()).unwrap();
    for file in std::fs::read_dir(shin("")).unwrap().map(|entry| entry.unwrap().path()) {
        let to = folder.join(file.file_name().unwrap());
        if !to.exists() {
            std::fs::copy(file, to).unwrap();
        }
    }
    name
}

#[test]
fn names_of_files_and_gauges_are_shown_harmless() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let scene = hostile_scene(folder);
    std::fs::copy(shin("shin_skin.glb"), folder.join(format!("{HOSTILE}.glb"))).unwrap();
    std::fs::copy(shin("shin.inp.gz"), folder.join(format!("{HOSTILE}.inp.gz"))).unwrap();
    for words in [
        &["inspect", "NAME.glb"][..],
        &["inspect", "NAME.inp.gz"],
        &["inspect", "NAME.inp.gz", "--json"],
        &["check", "NAME.json"],
        &["plan", "NAME.json"],
        &["doctor", "NAME.json"],
        &["bundle", "NAME.json", "-o", "NAME.hapdef"],
    ] {
        let output = shown(words, folder);
        assert!(output.status.code().is_some_and(|code| code < 2), "{words:?}: {output:?}");
    }
    let (source, device) = device(10, 1);
    let played = shown(&["live", "NAME.hapdef", "--source", &source, "--seconds", "0.7"], folder);
    device.join().unwrap();
    let said = String::from_utf8(played.stdout).unwrap();
    assert!(said.contains("device says: a\\u{1b}[2J\\nerror: all is lost"), "{said}");
    // A gauge off the wall is named.
    let text = std::fs::read_to_string(folder.join(&scene)).unwrap();
    let mut moved: Value = serde_json::from_str(&text).unwrap();
    moved["gauges"]["sites"][0]["position_m"] = json!([0.0, 0.1, 0.0]);
    std::fs::write(folder.join(&scene), moved.to_string()).unwrap();
    let refused = shown(&["check", "NAME.json"], folder);
    let said = String::from_utf8(refused.stderr).unwrap();
    assert!(said.contains("gauges.sites[0] (a\\u{1b}[2J"), "{said}");
}

#[test]
fn what_is_not_there_is_named_harmless() {
    let folder = tempfile::tempdir().unwrap();
    for words in [
        &["inspect", "NAME.glb"][..],
        &["inspect", "NAME.inp"],
        &["inspect", "NAME"],
        &["deck", "NAME.inp"],
        &["check", "NAME.json"],
        &["plan", "NAME.json"],
        &["converge", "NAME.json"],
        &["shell", "NAME.glb"],
        &["limits", "NAME.json"],
        &["place", "NAME.json"],
        &["probe", "NAME.json", "NAME.csv"],
        &["calibrate", "NAME.json", "NAME.csv", "NAME.json"],
        &["rig", "NAME.json"],
        &["contacts", "NAME.json", "NAME.csv"],
        &["record", "--source", "replay:NAME.mcap", "-o", "x.mcap"],
        &["record", "--source", "NAME", "-o", "x.mcap"],
        &["replay", "NAME.mcap", "--json"],
        &["recover", "NAME.mcap"],
        &["export", "NAME.mcap", "--csv"],
        &["doctor", "NAME.json"],
        &["bundle", "NAME.json", "-o", "NAME.hapdef"],
        &["live", "NAME.hapdef", "--source", "replay:NAME.mcap"],
        &["eval", "NAME.json"],
        &["NAME"],
    ] {
        let output = shown(words, folder.path());
        assert_eq!(output.status.code(), Some(2), "{words:?}: {output:?}");
    }
}

#[test]
fn names_of_recordings_are_shown_harmless() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::rename(made(folder, 100), folder.join(format!("{HOSTILE}.mcap"))).unwrap();
    for words in [
        &["export", "NAME.mcap", "--csv"][..],
        &["export", "NAME.mcap", "--jsonl"],
        &["recover", "NAME.mcap"],
        &["replay", "NAME.mcap", "--json", "--speed", "max"],
        &["record", "--source", "replay:NAME.mcap@max", "-o", "NAME2.mcap"],
        &["doctor", "--source", "replay:NAME.mcap@max"],
    ] {
        let output = shown(words, folder);
        assert!(output.status.code().is_some_and(|code| code < 2), "{words:?}: {output:?}");
    }
}

#[test]
fn what_a_device_says_is_shown_harmless() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let (source, device) = device(3, 2);
    let words = ["record", "--source", &source, "-o", "x.mcap", "--seconds", "1"];
    let recorded = shown(&words, folder);
    assert!(recorded.status.success(), "{recorded:?}");
    let checked = shown(&["doctor", "--source", &source, "--seconds", "0.3"], folder);
    assert!(!checked.stdout.is_empty(), "{checked:?}");
    device.join().unwrap();
    for form in ["--csv", "--jsonl"] {
        let text = shown(&["export", "x.mcap", form], folder);
        assert!(text.status.success() && !text.stdout.is_empty(), "{text:?}");
    }
}

/// Has `n_hosts`, one after the other, and hostile words for each; where it is.
fn device(n_channels: usize, n_hosts: usize) -> (String, JoinHandle<()>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let source = format!("tcp:{}", listener.local_addr().unwrap());
    let device = std::thread::spawn(move || {
        let mut hello = Hello::plain(n_channels, SampleFormat::I16, 1000);
        hello.uid = *b"\x1b[2J\nerror: all ";
        hello.channels[0].name = *b"\x1b[2J";
        hello.seal();
        for _ in 0..n_hosts {
            let (mut host, _) = listener.accept().unwrap();
            let mut encoder = Encoder::new();
            let mut bytes = vec![0];
            encoder.hello(&hello, 0, &mut bytes).unwrap();
            encoder.log(HOSTILE, 0, &mut bytes);
            for n in 0..600u64 {
                let counts: Vec<i32> = (0..n_channels as i32).map(|c| c + n as i32).collect();
                encoder.data(&hello, 1000 * n, FrameFlags::default(), &counts, &mut bytes).unwrap();
            }
            host.write_all(&bytes).unwrap();
            std::thread::sleep(Duration::from_millis(800));
        }
    });
    (source, device)
}

/// What is printed by commands that end by themselves, and what they need in `folder`.
fn commands(folder: &Path) -> Vec<Vec<String>> {
    made(folder, 100);
    let [skin, deck, scene] = ["shin_skin.glb", "shin.inp.gz", "placed.json"]
        .map(|f| shin(f).to_str().unwrap().to_owned());
    write_glb(&folder.join("tube.glb"), &tube(0.12), None).unwrap();
    let out = kept();
    let out = out.to_str().unwrap();
    let commands = [
        &["--help"][..],
        &["live", "--help"],
        &["--version"],
        &["completions", "bash"],
        &["man"],
        &["inspect", &skin],
        &["inspect", &skin, "--json"],
        &["inspect", &deck],
        &["check", &scene],
        &["plan", &scene],
        &["plan", &scene, "--json"],
        &["doctor", &scene],
        &["export", "made.mcap", "--csv"],
        &["export", "made.mcap", "--jsonl"],
        &["replay", "made.mcap", "--json", "--speed", "max"],
        &["recover", "made.mcap", "-o", "r.mcap"],
        &["record", "--source", "replay:made.mcap@max", "-o", "again.mcap"],
        &["shell", "tube.glb", "--unit", "m", "--wall", "measured", "--gauges", "3", "--edge", "5"],
        &["limits", &scene, "--results", out],
        &["live", &scene, "--sim", "--seconds", "0.5", "--results", out],
        &["live", &scene, "--sim", "--seconds", "0.5", "--json", "--results", out],
    ];
    commands.map(|words| words.iter().map(|word| (*word).to_owned()).collect()).into()
}

/// Both streams closed by who read them: as `hapdef … 2>&1 | head -0` does.
#[test]
fn a_reader_that_has_enough_is_no_error() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for words in commands(folder) {
        let (reader, closed) = std::io::pipe().unwrap();
        drop(reader);
        let mut command = hapdef(&words, folder);
        let status = command.stdout(closed.try_clone().unwrap()).stderr(closed).status().unwrap();
        assert!(status.code().is_some_and(|code| code < 2), "{words:?}: {status:?}");
    }
}

/// As `hapdef … | head -1` does.
#[test]
fn a_reader_that_has_a_line_hears_of_no_error() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for words in commands(folder) {
        let mut command = hapdef(&words, folder);
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut line = Vec::new();
        let mut reader = BufReader::with_capacity(1, child.stdout.take().unwrap());
        reader.read_until(b'\n', &mut line).unwrap();
        drop(reader);
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        let is_told = words[0] == "recover" || words[0] == "record";
        assert!(is_told || line.ends_with(b"\n"), "{words:?}: {said}");
        assert!(output.status.code().is_some_and(|code| code < 2), "{words:?}: {said}");
        assert!(!said.contains("error") && !said.contains("roken pipe"), "{words:?}: {said}");
    }
}

/// A pipe that a command writes to by its name, whose reader leaves.
#[cfg(target_os = "linux")]
#[test]
fn a_broken_pipe_that_is_not_standard_output_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    made(folder, 5000);
    let scene = shin("placed.json");
    let out = kept();
    let [scene, out] = [&scene, &out].map(|path| path.to_str().unwrap());
    let pipe = folder.join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    for words in [
        &["export", "made.mcap", "--csv", "-o", "pipe"][..],
        &["export", "made.mcap", "--jsonl", "-o", "pipe"],
        &["live", scene, "--sim", "--seconds", "1.5", "--csv", "pipe", "--results", out],
    ] {
        let mut command = hapdef(words, folder);
        let child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        drop(std::fs::File::open(&pipe).unwrap());
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{words:?}: {said}");
        assert!(said.contains("Broken pipe"), "{words:?}: {said}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_is_full_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    made(folder, 100);
    let [skin, scene, kept] = [shin("shin_skin.glb"), shin("placed.json"), kept()];
    let [skin, scene, kept] = [&skin, &scene, &kept].map(|path| path.to_str().unwrap());
    for words in [
        &["inspect", skin][..],
        &["export", "made.mcap", "--csv"],
        &["live", scene, "--sim", "--seconds", "0.5", "--results", kept],
        &["completions", "bash"],
    ] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let output = hapdef(words, folder).stdout(full).stderr(Stdio::piped()).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{words:?}: {said}");
        assert!(said.contains("standard output: "), "{words:?}: {said}");
    }
}
