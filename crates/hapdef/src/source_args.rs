//! `--source`: where gauge readings come from, in one word of the command line.

use std::path::PathBuf;
use std::str::FromStr;

/// Bits per second of a port where none are named.
pub(crate) const BAUD: u32 = 115_200;
/// Channels a line can have at most.
const MAX_CHANNELS: usize = hapdef_daq::hdp1::MAX_CHANNELS;

/// What `--source` can be; the value is for `--help`.
pub const SOURCE_FORMS: &str = "serial:DEV[@BAUD], tcp:HOST:PORT, replay:FILE[@SPEED|@max], \
                                csv:DEV[@CHANNELS], ros2:DOMAIN[@HOST:PORT] with --topic";

/// Where readings come from, as the command line says it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SourceArg {
    /// `serial:DEV[@BAUD]`: HDP1 on a serial port or a pseudo-terminal.
    Serial {
        /// Path of the port.
        device: String,
        /// Bits per second, 115200 where none are named; native USB ports take any.
        baud: u32,
    },
    /// `tcp:HOST:PORT`: HDP1 over TCP.
    Tcp {
        /// Host and port.
        address: String,
    },
    /// `replay:FILE[@SPEED]`: a recording, at its own pace or so many times as fast.
    Replay {
        /// The recording.
        file: PathBuf,
        /// Times the original pace; infinite (`@max`) is as fast as it goes.
        speed: f64,
        /// The topic whose numbers are the readings, µε, where it is no recording of hapdef.
        topic: Option<String>,
    },
    /// `csv:DEV[@CHANNELS]`: lines of integers, as the paper's authors' sketch prints them.
    Csv {
        /// Path of the port.
        device: String,
        /// Integers in a line, where they are named.
        n_channels: Option<usize>,
    },
    /// `ros2:DOMAIN[@HOST:PORT]`: the numbers of a topic of ROS 2 by rmw_zenoh, µε.
    Ros2 {
        /// ROS_DOMAIN_ID.
        domain_id: u32,
        /// Host and port of the router, localhost:7447 where none is named.
        router: Option<String>,
        /// The topic whose numbers are the readings.
        topic: Option<String>,
    },
}

/// A `--source` that can't be understood.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum SourceArgError {
    #[error("found {found:?}, expected one of {SOURCE_FORMS}")]
    Form { found: String },
    #[error("{found:?}: expected {expected}")]
    Number { found: String, expected: &'static str },
    #[error("{found}: a topic is read of a file, replay:FILE, or of ROS 2, ros2:DOMAIN, alone")]
    Topic { found: String },
    #[error("{found}: expected the topic of the gauges' readings: --topic /strain")]
    NoTopic { found: String },
    #[error(
        "{found}: this build has no zenoh, by which ROS 2 is read; build with --features zenoh (cargo install \
         --path crates/hapdef-cli --features zenoh)"
    )]
    NoZenoh { found: String },
}

impl SourceArg {
    /// The same, but the numbers of a topic of the recording, or of ROS 2.
    ///
    /// # Errors
    /// [`SourceArgError::Topic`] where it is neither.
    pub fn of_topic(&self, named: &str) -> Result<Self, SourceArgError> {
        let mut of_topic = self.clone();
        match &mut of_topic {
            Self::Replay { topic, .. } | Self::Ros2 { topic, .. } => {
                *topic = Some(named.to_owned());
            }
            other => return Err(SourceArgError::Topic { found: other.to_string() }),
        }
        Ok(of_topic)
    }

    /// Whether its readings were recorded before.
    #[must_use]
    pub fn is_recorded(&self) -> bool {
        matches!(self, Self::Replay { .. })
    }

    /// Whether it hands readings out as fast as they are taken.
    #[must_use]
    pub fn is_unpaced(&self) -> bool {
        matches!(self, Self::Replay { speed, .. } if speed.is_infinite())
    }
}

impl FromStr for SourceArg {
    type Err = SourceArgError;

    fn from_str(text: &str) -> Result<Self, SourceArgError> {
        let form = || SourceArgError::Form { found: text.to_owned() };
        if text.starts_with('/') {
            return format!("serial:{text}").parse();
        }
        let (word, rest) = text.split_once(':').ok_or_else(form)?;
        if rest.is_empty() {
            return Err(form());
        }
        match word {
            "serial" => {
                let (device, baud) = with_number(text, rest, 1..=u32::MAX)?;
                let baud = baud.unwrap_or(BAUD);
                Ok(Self::Serial { device, baud })
            }
            "csv" => {
                let (device, n_channels) = with_number(text, rest, 1..=MAX_CHANNELS)?;
                Ok(Self::Csv { device, n_channels })
            }
            "tcp" => tcp(text, rest),
            "replay" => replay(text, rest),
            "ros2" => ros2(text, rest),
            _ => Err(form()),
        }
    }
}

impl std::fmt::Display for SourceArg {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Serial { device, baud } => write!(f, "serial:{device}@{baud}"),
            Self::Tcp { address } => write!(f, "tcp:{address}"),
            Self::Replay { file, speed, topic } => {
                write!(f, "replay:{}@", file.display())?;
                match speed.is_finite() {
                    true => write!(f, "{speed}")?,
                    false => f.write_str("max")?,
                }
                write_topic(f, topic.as_deref())
            }
            Self::Ros2 { domain_id, router, topic } => {
                write!(f, "ros2:{domain_id}")?;
                router.as_ref().map_or(Ok(()), |router| write!(f, "@{router}"))?;
                write_topic(f, topic.as_deref())
            }
            Self::Csv { device, n_channels: Some(n) } => write!(f, "csv:{device}@{n}"),
            Self::Csv { device, .. } => write!(f, "csv:{device}"),
        }
    }
}

fn write_topic(f: &mut std::fmt::Formatter<'_>, topic: Option<&str>) -> std::fmt::Result {
    topic.map_or(Ok(()), |topic| write!(f, ", topic {topic}"))
}

/// Splits `@NUMBER` off, where there is one.
fn with_number<N: FromStr + PartialOrd>(
    text: &str,
    rest: &str,
    range: std::ops::RangeInclusive<N>,
) -> Result<(String, Option<N>), SourceArgError> {
    let Some((name, number)) = rest.rsplit_once('@') else {
        return Ok((rest.to_owned(), None));
    };
    let number = number.parse().ok().filter(|n| range.contains(n));
    match number {
        Some(number) if !name.is_empty() => Ok((name.to_owned(), Some(number))),
        _ => Err(SourceArgError::Number {
            found: text.to_owned(),
            expected: "after the @ a whole number: bits per second of a serial port, or 1 to 64 \
                       channels",
        }),
    }
}

fn tcp(text: &str, rest: &str) -> Result<SourceArg, SourceArgError> {
    match has_port(rest) {
        true => Ok(SourceArg::Tcp { address: rest.to_owned() }),
        false => Err(SourceArgError::Number {
            found: text.to_owned(),
            expected: "tcp:HOST:PORT with a port from 1 to 65535",
        }),
    }
}

fn ros2(text: &str, rest: &str) -> Result<SourceArg, SourceArgError> {
    let (domain, router) =
        rest.split_once('@').map_or((rest, None), |(domain, router)| (domain, Some(router)));
    match domain.parse() {
        Ok(domain_id) if router.is_none_or(has_port) => {
            Ok(SourceArg::Ros2 { domain_id, router: router.map(str::to_owned), topic: None })
        }
        _ => Err(SourceArgError::Number {
            found: text.to_owned(),
            expected: "ros2:DOMAIN, the number that is ROS_DOMAIN_ID or else 0, or \
                       ros2:DOMAIN@HOST:PORT with the router's port from 1 to 65535",
        }),
    }
}

/// Whether it is `HOST:PORT`.
fn has_port(address: &str) -> bool {
    let port = address.rsplit_once(':').filter(|(host, _)| !host.is_empty());
    port.and_then(|(_, port)| port.parse::<u16>().ok()).is_some_and(|port| port > 0)
}

/// A file's name may have an @ in it: only a number, or `max`, behind the last one is a speed.
fn replay(text: &str, rest: &str) -> Result<SourceArg, SourceArgError> {
    let of = |file: &str, speed| SourceArg::Replay { file: file.into(), speed, topic: None };
    let Some((file, speed)) = rest.rsplit_once('@').filter(|(file, _)| !file.is_empty()) else {
        return Ok(of(rest, 1.0));
    };
    match parse_speed(speed) {
        Ok(speed) => Ok(of(file, speed)),
        Err(_) if speed.parse::<f64>().is_err() => Ok(of(rest, 1.0)),
        Err(expected) => Err(SourceArgError::Number { found: text.to_owned(), expected }),
    }
}

/// A speed of a replay: a number above 0, or `max`, which is infinite.
///
/// # Errors
/// What was expected, in words.
pub fn parse_speed(text: &str) -> Result<f64, &'static str> {
    if text == "max" {
        return Ok(f64::INFINITY);
    }
    let speed = text.parse().ok();
    let good = speed.filter(|s: &f64| s.is_finite() && *s > 0.0);
    good.ok_or("a speed above 0, or max")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(text: &str, expected: &str) {
        let source: SourceArg = text.parse().unwrap();
        assert_eq!(source.to_string(), expected);
        let again: SourceArg = expected.parse().unwrap();
        assert_eq!(again, source);
    }

    #[test]
    fn sources_are_read() {
        check("serial:/dev/ttyACM0", "serial:/dev/ttyACM0@115200");
        check("serial:/dev/serial/by-id/usb-A@B@921600", "serial:/dev/serial/by-id/usb-A@B@921600");
        check("csv:/dev/ttyUSB0", "csv:/dev/ttyUSB0");
        check("/dev/pts/3", "serial:/dev/pts/3@115200");
        check("csv:COM3@4", "csv:COM3@4");
        check("tcp:robot.local:7000", "tcp:robot.local:7000");
        check("tcp:[::1]:7000", "tcp:[::1]:7000");
        check("replay:a.mcap", "replay:a.mcap@1");
        check("replay:a@home/b.mcap", "replay:a@home/b.mcap@1");
        check("replay:a.mcap@2.5", "replay:a.mcap@2.5");
        check("replay:a.mcap@max", "replay:a.mcap@max");
        check("ros2:0", "ros2:0");
        check("ros2:42@robot.local:7447", "ros2:42@robot.local:7447");
    }

    #[test]
    fn what_is_no_source_is_refused_with_the_forms() {
        for text in ["", "serial:", "usb:/dev/x", "ttyACM0", ":x"] {
            let error = text.parse::<SourceArg>().unwrap_err();
            assert!(error.to_string().contains("tcp:HOST:PORT"), "{error}");
        }
        for text in [
            "serial:/dev/x@fast",
            "serial:@9600",
            "serial:/dev/x@0",
            "csv:/dev/x@65",
            "csv:/dev/x@0",
            "tcp:host",
            "tcp:host:0",
            "tcp::7000",
            "tcp:host:65536",
            "replay:a.mcap@0",
            "replay:a.mcap@-1",
            "replay:a.mcap@NaN",
            "ros2:zero",
            "ros2:-1",
            "ros2:0@robot",
            "ros2:0@robot:0",
        ] {
            let error = text.parse::<SourceArg>().unwrap_err();
            assert!(matches!(error, SourceArgError::Number { .. }), "{text}");
        }
    }

    #[test]
    fn a_topic_is_one_of_a_recording_or_of_ros_2() {
        let of = |source: &str| source.parse::<SourceArg>().unwrap().of_topic("/strain");
        assert_eq!(of("replay:a.mcap@2").unwrap().to_string(), "replay:a.mcap@2, topic /strain");
        assert_eq!(of("ros2:3").unwrap().to_string(), "ros2:3, topic /strain");
        let error = of("tcp:robot:7000").unwrap_err();
        assert!(error.to_string().starts_with("tcp:robot:7000: a topic is read of"), "{error}");
    }
}
