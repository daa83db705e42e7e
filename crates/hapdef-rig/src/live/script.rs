//! A script of presses, and the JSON file it is kept in.

use serde::{Deserialize, Serialize};

use crate::error::RigError;

/// Form of the file.
const VERSION: u32 = 1;

/// Who presses where, when and how hard. In the file unknown fields are refused; docs/rig.md walks
/// through one.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct PressScript {
    /// Form of the file; 1.
    pub version: u32,
    /// Time after which it begins again, s; it is played once if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub repeat_s: Option<f64>,
    /// The contacts.
    pub contacts: Vec<ScriptedContact>,
}

/// One contact: it may come and go several times.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ScriptedContact {
    /// Its number, one of its own.
    pub id: u32,
    /// What it does, in order; between events it holds still.
    pub events: Vec<PressEvent>,
}

/// What a contact does from `at_s` on, for `for_s`. Forces go from one value to the next along half a
/// period of a cosine.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum PressEvent {
    /// It comes, and its force rises.
    Arrive {
        /// Begin, s.
        at_s: f64,
        /// Time in which the force rises, s.
        for_s: f64,
        /// Where, m; at most 5 mm off the skin.
        position_m: [f64; 3],
        /// Normal force then, N.
        force_n: f64,
        /// Force along the skin then, N.
        #[serde(default)]
        shear_n: [f64; 3],
    },
    /// Its force goes to another value.
    Press {
        /// Begin, s.
        at_s: f64,
        /// Time in which the force changes, s.
        for_s: f64,
        /// Normal force then, N.
        force_n: f64,
        /// Force along the skin then, N.
        #[serde(default)]
        shear_n: [f64; 3],
    },
    /// It slides over the skin at constant speed.
    Slide {
        /// Begin, s.
        at_s: f64,
        /// Time that it takes, s.
        for_s: f64,
        /// Places that it goes through from where it is, m; at most 5 mm off the skin.
        path_m: Vec<[f64; 3]>,
    },
    /// Its force falls, and it is gone.
    Leave {
        /// Begin, s.
        at_s: f64,
        /// Time in which the force falls, s.
        for_s: f64,
    },
    /// It hits and is gone: half a period of a sine.
    Impact {
        /// Begin, s.
        at_s: f64,
        /// Time that it lasts, s.
        for_s: f64,
        /// Where, m; at most 5 mm off the skin.
        position_m: [f64; 3],
        /// Largest normal force, N.
        force_n: f64,
    },
}

impl PressScript {
    /// A script of these contacts, played once.
    #[must_use]
    pub fn new(contacts: Vec<ScriptedContact>) -> Self {
        Self { version: VERSION, repeat_s: None, contacts }
    }

    /// Reads a script from JSON and checks it.
    ///
    /// # Errors
    /// [`RigError::ScriptForm`] and [`RigError::Script`], with the JSON path of what is wrong.
    pub fn from_json(text: &str) -> Result<Self, RigError> {
        let mut json = serde_json::Deserializer::from_str(text);
        let script: Self = serde_path_to_error::deserialize(&mut json).map_err(|error| {
            RigError::ScriptForm { path: error.path().to_string(), source: error.into_inner() }
        })?;
        json.end()
            .map_err(|source| RigError::ScriptForm { path: "end of file".to_owned(), source })?;
        script.check()?;
        Ok(script)
    }

    /// The script as JSON.
    ///
    /// # Errors
    /// [`RigError::ScriptForm`] for numbers that JSON does not have.
    pub fn to_json(&self) -> Result<String, RigError> {
        serde_json::to_string_pretty(self)
            .map_err(|source| RigError::ScriptForm { path: ".".to_owned(), source })
    }

    /// End of the last event, s.
    #[must_use]
    pub fn end_s(&self) -> f64 {
        let events = self.contacts.iter().flat_map(|contact| &contact.events);
        events.fold(0.0, |end, event| end.max(event.end_s()))
    }

    /// Checks values and the order of events.
    ///
    /// # Errors
    /// [`RigError::Script`].
    pub fn check(&self) -> Result<(), RigError> {
        require(self.version == VERSION, "version", "1", self.version)?;
        if let Some(repeat_s) = self.repeat_s {
            let expected = "at least the end of the last event, and above 0";
            let is_right = repeat_s.is_finite() && repeat_s > 0.0 && repeat_s >= self.end_s();
            require(is_right, "repeat_s", expected, repeat_s)?;
        }
        for (i, contact) in self.contacts.iter().enumerate() {
            let is_own = self.contacts[..i].iter().all(|other| other.id != contact.id);
            let path = format!("contacts[{i}].id");
            require(is_own, &path, "a number that no other contact has", contact.id)?;
            check_events(i, &contact.events)?;
        }
        Ok(())
    }
}

impl PressEvent {
    /// When it begins, s.
    #[must_use]
    pub fn at_s(&self) -> f64 {
        self.times_s().0
    }

    /// When it has ended, s.
    #[must_use]
    pub fn end_s(&self) -> f64 {
        let (at_s, for_s) = self.times_s();
        at_s + for_s
    }

    fn times_s(&self) -> (f64, f64) {
        match self {
            Self::Arrive { at_s, for_s, .. }
            | Self::Press { at_s, for_s, .. }
            | Self::Slide { at_s, for_s, .. }
            | Self::Leave { at_s, for_s }
            | Self::Impact { at_s, for_s, .. } => (*at_s, *for_s),
        }
    }
}

pub(super) fn require(
    holds: bool,
    path: &str,
    expected: &'static str,
    found: impl ToString,
) -> Result<(), RigError> {
    if holds {
        return Ok(());
    }
    Err(RigError::Script { path: path.to_owned(), expected, found: found.to_string() })
}

fn check_events(contact: usize, events: &[PressEvent]) -> Result<(), RigError> {
    let (mut free_s, mut is_there) = (0.0, false);
    for (k, event) in events.iter().enumerate() {
        let path = |field: &str| format!("contacts[{contact}].events[{k}]{field}");
        let (at_s, for_s) = event.times_s();
        let expected = "a time of 0 or more, not before the event in front has ended";
        require(at_s.is_finite() && at_s >= free_s, &path(".at_s"), expected, at_s)?;
        let is_short = matches!(event, PressEvent::Impact { .. } | PressEvent::Slide { .. });
        let is_right = for_s.is_finite() && (for_s > 0.0 || (for_s == 0.0 && !is_short));
        let expected = "a time of 0 or more; above 0 for impacts and slides";
        require(is_right, &path(".for_s"), expected, for_s)?;
        check_values(event, &path)?;
        is_there = check_turn(event, is_there, &path(""))?;
        free_s = at_s + for_s;
    }
    Ok(())
}

/// Whether the contact is there after `event`.
fn check_turn(event: &PressEvent, is_there: bool, path: &str) -> Result<bool, RigError> {
    let (name, needs_contact, leaves_contact) = match event {
        PressEvent::Arrive { .. } => ("arrive", false, true),
        PressEvent::Press { .. } => ("press", true, true),
        PressEvent::Slide { .. } => ("slide", true, true),
        PressEvent::Leave { .. } => ("leave", true, false),
        PressEvent::Impact { .. } => ("impact", false, false),
    };
    let expected = if is_there {
        "press, slide or leave while the contact is there"
    } else {
        "arrive or impact while the contact is not there"
    };
    require(needs_contact == is_there, path, expected, name)?;
    Ok(leaves_contact)
}

fn check_values(event: &PressEvent, path: &dyn Fn(&str) -> String) -> Result<(), RigError> {
    let finite = |v: &[f64; 3]| v.iter().all(|c| c.is_finite());
    let vector = |v: &[f64; 3], field| {
        require(finite(v), &path(field), "three finite numbers", format!("{v:?}"))
    };
    let force = |force_n: f64| {
        let is_right = force_n.is_finite() && force_n > 0.0;
        require(is_right, &path(".force_n"), "a force above 0 N", force_n)
    };
    match event {
        PressEvent::Arrive { position_m, force_n, shear_n, .. } => {
            vector(position_m, ".position_m")?;
            vector(shear_n, ".shear_n")?;
            force(*force_n)
        }
        PressEvent::Press { force_n, shear_n, .. } => {
            vector(shear_n, ".shear_n")?;
            force(*force_n)
        }
        PressEvent::Slide { path_m, .. } => {
            let n = path_m.len();
            require(n > 0, &path(".path_m"), "at least one place", n)?;
            path_m.iter().try_for_each(|x| vector(x, ".path_m"))
        }
        PressEvent::Leave { .. } => Ok(()),
        PressEvent::Impact { position_m, force_n, .. } => {
            vector(position_m, ".position_m")?;
            force(*force_n)
        }
    }
}
