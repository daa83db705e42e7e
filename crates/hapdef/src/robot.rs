//! A robot file: several limbs, each with its scene, its source of readings and its frame.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde_json::error::Category;
use serde_json::{Map, Value};

use crate::error::RobotError;
use crate::scene::scene_file;
use crate::source_args::SourceArg;

/// What a robot file is called where a folder has one.
const FILE_NAME: &str = "robot.json";
/// The source that is the scene's simulated rig.
const SIM: &str = "sim";
/// What [`is_name`] takes.
const NAME: &str = "letters, digits and _, no digit first, no two _ in a row";

/// Limbs that one program follows.
#[derive(Clone, Debug, PartialEq)]
pub struct Robot {
    /// Its name: topics begin with it.
    pub name: String,
    /// At least one; no two have the same name, frame or device.
    pub limbs: Vec<RobotLimb>,
}

/// A limb of a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotLimb {
    /// Its name: topics have it after the robot's, files and the page's address, too.
    pub name: String,
    /// Its scene, or its bundle.
    pub scene: PathBuf,
    /// Where its readings come from.
    pub source: LimbSource,
    /// Frame of its link in the robot's tf; positions are in it.
    pub frame: String,
}

/// Where a limb's readings come from.
#[derive(Clone, Debug, PartialEq)]
pub enum LimbSource {
    /// The simulated rig of its scene, pressed at random.
    Sim {
        /// Seed of the presses.
        seed: u64,
    },
    /// A device, a recording or a topic.
    Readings(SourceArg),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RobotEntry {
    name: String,
    limbs: Vec<LimbEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LimbEntry {
    name: String,
    scene: PathBuf,
    source: String,
    seed: Option<u64>,
    frame: String,
    topic: Option<String>,
}

/// Something wrong at a place of the file.
struct Fault {
    path: String,
    expected: String,
    found: String,
    advice: &'static str,
}

/// What no two limbs have alike: the field, its value and what to do then.
type Own = (&'static str, String, &'static str);

impl Robot {
    /// What a limb's topics begin with.
    #[must_use]
    pub fn prefix(&self, limb: &RobotLimb) -> String {
        format!("/{}/{}", self.name, limb.name)
    }
}

/// Whether a path leads to a robot file: one that is called so, or JSON that lists limbs.
#[must_use]
pub fn is_robot_file(path: &Path) -> bool {
    let lists_limbs = || {
        let text = std::fs::read_to_string(path).ok()?;
        let fields: Map<String, Value> = serde_json::from_str(&text).ok()?;
        Some(fields.contains_key("limbs"))
    };
    let is_called_so = path.file_name().is_some_and(|name| name == FILE_NAME);
    let is_json = path.extension().is_some_and(|ending| ending == "json");
    is_called_so || (is_json && lists_limbs().unwrap_or(false))
}

/// Reads and checks a robot file. Its paths are relative to it.
///
/// # Errors
/// [`RobotError`], naming the file and the place in it, when the file can't be read, is no JSON of this form, has an
/// unknown field, or what it says can't be.
pub fn read_robot(path: &Path) -> Result<Robot, RobotError> {
    let file = path.display().to_string();
    let text = std::fs::read_to_string(path)
        .map_err(|source| RobotError::Unreadable { file: file.clone(), source })?;
    let mut json = serde_json::Deserializer::from_str(&text);
    let entry: RobotEntry = serde_path_to_error::deserialize(&mut json).map_err(|error| {
        let json_path = error.path().to_string();
        let source = error.into_inner();
        let file = file.clone();
        match source.classify() {
            Category::Data => RobotError::Form { file, path: json_path, source },
            _ => RobotError::NoJson { file, source },
        }
    })?;
    json.end().map_err(|source| RobotError::NoJson { file: file.clone(), source })?;
    let folder = path.parent().unwrap_or(Path::new("."));
    checked(entry, folder).map_err(|fault| RobotError::Value {
        file,
        path: fault.path,
        expected: fault.expected,
        found: fault.found,
        advice: fault.advice,
    })
}

fn checked(entry: RobotEntry, folder: &Path) -> Result<Robot, Fault> {
    check_name("name".to_owned(), &entry.name)?;
    if entry.limbs.is_empty() {
        return Err(Fault {
            path: "limbs".to_owned(),
            expected: "one limb or more".to_owned(),
            found: "none".to_owned(),
            advice: "add one with its name, scene, source and frame",
        });
    }
    let numbered = entry.limbs.into_iter().enumerate();
    let limbs: Result<Vec<RobotLimb>, Fault> =
        numbered.map(|(i, limb)| limb.checked(i, folder)).collect();
    let robot = Robot { name: entry.name, limbs: limbs? };
    check_that_none_share(&robot.limbs)?;
    Ok(robot)
}

impl LimbEntry {
    fn checked(self, index: usize, folder: &Path) -> Result<RobotLimb, Fault> {
        let at = |field: &str| format!("limbs[{index}].{field}");
        check_name(at("name"), &self.name)?;
        check_frame(at("frame"), &self.frame)?;
        let scene = scene_file(&folder.join(&self.scene));
        if !scene.is_file() {
            return Err(Fault {
                path: at("scene"),
                expected: "a scene's .json or a bundle".to_owned(),
                found: format!("no file {}", scene.display()),
                advice: "the path is relative to the robot file: correct it",
            });
        }
        let source = self.source(&at, folder)?;
        Ok(RobotLimb { name: self.name, scene, source, frame: self.frame })
    }

    fn source(&self, at: &impl Fn(&str) -> String, folder: &Path) -> Result<LimbSource, Fault> {
        let only_with = |field: &str, expected: &str, found: String| Fault {
            path: at(field),
            expected: expected.to_owned(),
            found,
            advice: "leave it out, or correct the source",
        };
        if self.source == SIM {
            return match &self.topic {
                Some(topic) => {
                    let expected = "a topic of a recording or of ROS 2 alone";
                    Err(only_with("topic", expected, format!("{topic:?} of the simulated rig")))
                }
                None => Ok(LimbSource::Sim { seed: self.seed.unwrap_or(1) }),
            };
        }
        if let Some(seed) = self.seed {
            let found = format!("{seed} of {}", self.source);
            return Err(only_with("seed", "a seed of the simulated rig, \"sim\", alone", found));
        }
        let not_understood = |expected: String| Fault {
            path: at("source"),
            expected,
            found: format!("{:?}", self.source),
            advice: "correct it; \"sim\" is the scene's simulated rig",
        };
        let source = self.source.parse::<SourceArg>();
        let mut source = source.map_err(|error| not_understood(format!("a source ({error})")))?;
        if let Some(topic) = &self.topic {
            let found = || format!("{topic:?} of {}", self.source);
            source = source.of_topic(topic).map_err(|_| {
                only_with("topic", "a topic of a recording or of ROS 2 alone", found())
            })?;
        }
        if let SourceArg::Replay { file, .. } = &mut source {
            *file = folder.join(&*file);
        }
        Ok(LimbSource::Readings(source))
    }
}

impl RobotLimb {
    /// What no other limb may have.
    fn own(&self) -> Vec<Own> {
        let mut own = vec![
            ("name", self.name.clone(), "give each limb a name of its own"),
            ("frame", self.frame.clone(), "name each limb's own link"),
        ];
        let device = match &self.source {
            LimbSource::Readings(source) => device(source),
            LimbSource::Sim { .. } => None,
        };
        own.extend(device.map(|name| ("source", name, "give each limb a device of its own")));
        own
    }
}

/// What a live source reads of, that nobody else can read; none for a recording.
fn device(source: &SourceArg) -> Option<String> {
    match source {
        SourceArg::Serial { device, .. } | SourceArg::Csv { device, .. } => {
            // one port has several names, by its number and by what is connected
            let path = std::fs::canonicalize(device).unwrap_or_else(|_| device.into());
            Some(path.display().to_string())
        }
        SourceArg::Replay { .. } => None,
        SourceArg::Tcp { .. } | SourceArg::Ros2 { .. } => Some(source.to_string()),
    }
}

fn check_that_none_share(limbs: &[RobotLimb]) -> Result<(), Fault> {
    for (i, limb) in limbs.iter().enumerate() {
        for (field, value, advice) in limb.own() {
            let has_it = |other: &RobotLimb| {
                other.own().iter().any(|(name, others, _)| *name == field && *others == value)
            };
            if let Some(other) = limbs[..i].iter().position(has_it) {
                return Err(Fault {
                    path: format!("limbs[{i}].{field}"),
                    expected: format!("another than that of limbs[{other}]"),
                    found: value,
                    advice,
                });
            }
        }
    }
    Ok(())
}

fn check_name(path: String, name: &str) -> Result<(), Fault> {
    match is_name(name) {
        true => Ok(()),
        false => Err(Fault {
            path,
            expected: format!("a name that topics can have: {NAME}"),
            found: format!("{name:?}"),
            advice: "choose another",
        }),
    }
}

fn check_frame(path: String, frame: &str) -> Result<(), Fault> {
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '/';
    match !frame.is_empty() && frame.chars().all(is_word) {
        true => Ok(()),
        false => Err(Fault {
            path,
            expected: "a frame's name: letters, digits, _ and /".to_owned(),
            found: format!("{frame:?}"),
            advice: "give it the name of the limb's link",
        }),
    }
}

/// Whether it can be a part of a topic's name, and so a file's and an address's.
fn is_name(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && !name.contains("__")
}
