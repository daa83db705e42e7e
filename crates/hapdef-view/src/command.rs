//! What people do on the page.

use serde::Deserialize;

use crate::offers::Offers;

/// What people do on the page.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ViewCommand {
    /// Take the present readings as zero.
    Tare,
    /// Start or stop recording.
    Record(bool),
    /// Keep what is shown.
    Snapshot {
        /// Time of the frame that the page shows, [`crate::ViewFrame::t_s`]; the newest if it does not
        /// say.
        t_s: Option<f64>,
    },
    /// Stop or go on with a replay.
    Pause(bool),
    /// Go to a time of a replay.
    Seek {
        /// From the recording's beginning, s.
        position_s: f64,
    },
    /// Press the virtual limb with a finger, or move that finger there.
    Press {
        /// Which finger, below [`MOST_FINGERS`]: several press at a time.
        finger: u32,
        /// Where, on the limb at rest, m.
        point_m: [f64; 3],
        /// Outward unit normal there.
        normal: [f64; 3],
        /// Force against the normal, N.
        force_n: f64,
    },
    /// One finger lets go.
    Lift {
        /// Which finger.
        finger: u32,
    },
    /// All fingers let go.
    Release,
    /// Whether the virtual limb is pressed at random while nobody presses it.
    Random(bool),
}

/// Fingers that may press the virtual limb at a time.
pub const MOST_FINGERS: u32 = 5;

/// A message of the page.
#[derive(Debug, Deserialize)]
#[serde(tag = "cmd", rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum PageMessage {
    /// The first one.
    Hello {
        #[cfg_attr(not(feature = "server"), allow(dead_code, reason = "only a server has one"))]
        token: Option<String>,
    },
    /// A frame was taken: room for another. The number of the one that was drawn last.
    Got {
        #[cfg_attr(not(feature = "server"), allow(dead_code, reason = "only a server counts"))]
        drawn: Option<u64>,
    },
    Tare,
    Record {
        on: bool,
    },
    Snapshot {
        t_s: Option<f64>,
    },
    Pause {
        on: bool,
    },
    Seek {
        position_s: f64,
    },
    Press {
        #[serde(default)]
        finger: u32,
        point_m: [f64; 3],
        normal: [f64; 3],
        force_n: f64,
    },
    Lift {
        finger: u32,
    },
    Release,
    Random {
        on: bool,
    },
}

impl PageMessage {
    /// Reads a message, in words what is wrong with it.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        serde_json::from_str(text).map_err(|error| format!("not a message: {error}"))
    }

    /// The command in it, `None` where it is none, in words why it is refused.
    pub(crate) fn command(self, offers: &Offers) -> Result<Option<ViewCommand>, String> {
        let offered = |is_offered: bool, what: &str| {
            if is_offered { Ok(()) } else { Err(format!("{what} is not offered here")) }
        };
        let command = match self {
            Self::Hello { .. } | Self::Got { .. } => return Ok(None),
            Self::Tare => {
                offered(offers.tare, "tare")?;
                ViewCommand::Tare
            }
            Self::Record { on } => {
                offered(offers.record, "recording")?;
                ViewCommand::Record(on)
            }
            Self::Snapshot { t_s } if t_s.is_none_or(f64::is_finite) => {
                ViewCommand::Snapshot { t_s }
            }
            Self::Snapshot { t_s } => return Err(format!("no time to keep: {t_s:?} s")),
            Self::Pause { on } => ViewCommand::Pause(on),
            Self::Seek { position_s } if position_s.is_finite() && position_s >= 0.0 => {
                ViewCommand::Seek { position_s }
            }
            Self::Seek { position_s } => return Err(format!("no time to go to: {position_s} s")),
            Self::Press { finger, point_m, normal, force_n } => {
                press(offers, finger, (point_m, normal), force_n)?
            }
            Self::Lift { finger } => {
                offered(offers.press.is_some(), "pressing")?;
                ViewCommand::Lift { finger }
            }
            Self::Release => {
                offered(offers.press.is_some(), "pressing")?;
                ViewCommand::Release
            }
            Self::Random { on } => {
                offered(offers.press.is_some(), "pressing")?;
                ViewCommand::Random(on)
            }
        };
        Ok(Some(command))
    }
}

fn press(
    offers: &Offers,
    finger: u32,
    (point_m, normal): ([f64; 3], [f64; 3]),
    force_n: f64,
) -> Result<ViewCommand, String> {
    let Some(offer) = offers.press else {
        return Err("pressing is not offered here".to_owned());
    };
    if finger >= MOST_FINGERS {
        return Err(format!("finger {finger}, expected one below {MOST_FINGERS}"));
    }
    if !(force_n > 0.0 && force_n <= offer.max_n) {
        return Err(format!("a press of {force_n} N, expected up to {} N", offer.max_n));
    }
    let length = normal.iter().map(|c| c * c).sum::<f64>().sqrt();
    if !point_m.iter().all(|c| c.is_finite()) || (length - 1.0).abs() > 1e-3 || length.is_nan() {
        return Err(format!("a press at {point_m:?} with a normal of length {length}, expected 1"));
    }
    Ok(ViewCommand::Press { finger, point_m, normal, force_n })
}

#[cfg(test)]
mod tests {
    use super::{PageMessage, ViewCommand};
    use crate::offers::{Offers, PressOffer};

    fn read(text: &str, offers: &Offers) -> Result<Option<ViewCommand>, String> {
        PageMessage::parse(text)?.command(offers)
    }

    fn all() -> Offers {
        Offers { tare: true, record: true, press: Some(PressOffer { default_n: 1.0, max_n: 10.0 }) }
    }

    #[track_caller]
    fn check(text: &str, expected: ViewCommand) {
        assert_eq!(read(text, &all()), Ok(Some(expected)));
    }

    #[test]
    fn commands() {
        check(r#"{"cmd":"tare"}"#, ViewCommand::Tare);
        check(r#"{"cmd":"record","on":true}"#, ViewCommand::Record(true));
        check(r#"{"cmd":"pause","on":false}"#, ViewCommand::Pause(false));
        check(r#"{"cmd":"snapshot"}"#, ViewCommand::Snapshot { t_s: None });
        check(r#"{"cmd":"snapshot","t_s":-2.5}"#, ViewCommand::Snapshot { t_s: Some(-2.5) });
        check(r#"{"cmd":"seek","position_s":2.5}"#, ViewCommand::Seek { position_s: 2.5 });
        check(r#"{"cmd":"release"}"#, ViewCommand::Release);
        check(r#"{"cmd":"lift","finger":2}"#, ViewCommand::Lift { finger: 2 });
        check(r#"{"cmd":"random","on":false}"#, ViewCommand::Random(false));
        let pressed = |finger| ViewCommand::Press {
            finger,
            point_m: [0.0, 0.1, 0.2],
            normal: [0.0, 0.0, 1.0],
            force_n: 4.0,
        };
        check(r#"{"cmd":"press","point_m":[0,0.1,0.2],"normal":[0,0,1],"force_n":4}"#, pressed(0));
        check(
            r#"{"cmd":"press","finger":4,"point_m":[0,0.1,0.2],"normal":[0,0,1],"force_n":4}"#,
            pressed(4),
        );
        assert_eq!(read(r#"{"cmd":"got"}"#, &all()), Ok(None));
        assert_eq!(read(r#"{"cmd":"got","drawn":7}"#, &all()), Ok(None));
    }

    #[test]
    fn nonsense_is_refused() {
        let bad = [
            "",
            "[]",
            r#"{"cmd":"rm"}"#,
            r#"{"cmd":"record"}"#,
            r#"{"cmd":"record","on":true,"also":1}"#,
            r#"{"cmd":"seek","position_s":-1}"#,
            r#"{"cmd":"seek","position_s":1e999}"#,
            r#"{"cmd":"press","point_m":[0,0,0],"normal":[0,0,1],"force_n":11}"#,
            r#"{"cmd":"press","point_m":[0,0,0],"normal":[0,0,1],"force_n":0}"#,
            r#"{"cmd":"press","point_m":[0,0,0],"normal":[0,0,2],"force_n":1}"#,
            r#"{"cmd":"press","point_m":[0,0],"normal":[0,0,1],"force_n":1}"#,
            r#"{"cmd":"press","finger":5,"point_m":[0,0,0],"normal":[0,0,1],"force_n":1}"#,
            r#"{"cmd":"press","finger":-1,"point_m":[0,0,0],"normal":[0,0,1],"force_n":1}"#,
            r#"{"cmd":"lift"}"#,
        ];
        for text in bad {
            assert!(read(text, &all()).is_err(), "{text}");
        }
    }

    #[test]
    fn what_is_not_offered_is_refused() {
        for text in [
            r#"{"cmd":"tare"}"#,
            r#"{"cmd":"record","on":true}"#,
            r#"{"cmd":"release"}"#,
            r#"{"cmd":"lift","finger":0}"#,
            r#"{"cmd":"random","on":true}"#,
            r#"{"cmd":"press","point_m":[0,0,0],"normal":[0,0,1],"force_n":1}"#,
        ] {
            assert!(read(text, &Offers::default()).is_err(), "{text}");
        }
    }
}
