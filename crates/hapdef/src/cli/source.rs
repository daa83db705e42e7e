//! Where frames come from, as it is typed: `serial:/dev/ttyACM0`, `replay:press.mcap@2`.

use std::path::Path;
use std::str::FromStr;

use anyhow::{Context, Result};
use hapdef_daq::record::Recording;
use hapdef_daq::source::{
    FrameSource, Protocol, ReplaySource, SerialLink, SerialParams, StreamParams, StreamSource,
    TcpLink,
};

/// How `--source` is written.
pub(crate) const FORMS: &str = "serial:PATH[@BAUD], tcp:HOST:PORT, csv:PATH[@BAUD] (lines of the \
                                authors' sketch), or replay:FILE[@SPEED] (1 is as it was, max as \
                                fast as it goes)";

/// A source of frames.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum SourceSpec {
    /// HDP1 by a serial port or pseudo-terminal.
    Serial { path: String, baud: u32 },
    /// HDP1 by TCP.
    Tcp { address: String },
    /// Lines of integers by a serial port.
    Csv { path: String, baud: u32 },
    /// A recording, at so many times its speed; 0 is as fast as it goes.
    Replay { path: String, speed: f64 },
}

impl FromStr for SourceSpec {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let refused = || format!("expected {FORMS}, found {text:?}");
        if text.starts_with('/') {
            return format!("serial:{text}").parse();
        }
        let (kind, rest) = text.split_once(':').ok_or_else(refused)?;
        if rest.is_empty() {
            return Err(refused());
        }
        let baud = |said: Option<&str>| {
            let default = SerialParams::default().baud;
            said.map_or(Ok(default), |b| b.parse().map_err(|_| refused()))
        };
        let (path, said) = match rest.rsplit_once('@') {
            Some((path, said)) => (path.to_owned(), Some(said)),
            None => (rest.to_owned(), None),
        };
        match kind {
            "serial" => Ok(Self::Serial {
                path,
                baud: baud(said)?,
            }),
            "csv" => Ok(Self::Csv {
                path,
                baud: baud(said)?,
            }),
            "tcp" if rest.contains(':') => Ok(Self::Tcp {
                address: rest.to_owned(),
            }),
            "replay" => {
                let speed: f64 = match said {
                    None => 1.0,
                    Some("max") => 0.0,
                    Some(said) => said.parse().map_err(|_| refused())?,
                };
                let is_fine = said == Some("max") || speed > 0.0 && speed.is_finite();
                is_fine
                    .then_some(Self::Replay { path, speed })
                    .ok_or_else(refused)
            }
            _ => Err(refused()),
        }
    }
}

impl SourceSpec {
    /// Whether it hands out frames as fast as they are taken.
    pub(crate) fn is_unpaced(&self) -> bool {
        matches!(self, Self::Replay { speed, .. } if *speed == 0.0)
    }

    /// Whether its frames were recorded before.
    pub(crate) fn is_recorded(&self) -> bool {
        matches!(self, Self::Replay { .. })
    }

    /// The source; lines of integers have `n_channels`.
    pub(crate) fn open(&self, n_channels: usize) -> Result<Box<dyn FrameSource>> {
        let serial = |path: &str, baud: u32, protocol: Protocol| -> Box<dyn FrameSource> {
            let params = SerialParams {
                baud,
                ..SerialParams::default()
            };
            let stream = StreamParams {
                protocol,
                ..StreamParams::default()
            };
            Box::new(StreamSource::new(SerialLink::new(path, params), stream))
        };
        Ok(match self {
            Self::Serial { path, baud } => serial(path, *baud, Protocol::Hdp1),
            Self::Csv { path, baud } => serial(path, *baud, Protocol::Csv { n_channels }),
            Self::Tcp { address } => Box::new(StreamSource::new(
                TcpLink::new(address),
                StreamParams::default(),
            )),
            Self::Replay { path, speed } => {
                let recording = Recording::open(Path::new(path))
                    .context("--source: give a recording of hapdef")?;
                Box::new(ReplaySource::new(path, recording.messages(), *speed))
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sources_are_read_as_they_are_typed() {
        let serial = |path: &str, baud| SourceSpec::Serial {
            path: path.to_owned(),
            baud,
        };
        assert_eq!("/dev/pts/3".parse(), Ok(serial("/dev/pts/3", 115_200)));
        assert_eq!("serial:/dev/a@9600".parse(), Ok(serial("/dev/a", 9600)));
        let replay = |speed| SourceSpec::Replay {
            path: "a.mcap".to_owned(),
            speed,
        };
        assert_eq!("replay:a.mcap".parse(), Ok(replay(1.0)));
        assert_eq!("replay:a.mcap@0.5".parse(), Ok(replay(0.5)));
        assert!(
            "replay:a.mcap@max"
                .parse::<SourceSpec>()
                .unwrap()
                .is_unpaced()
        );
        for bad in [
            "",
            "serial:",
            "usb:1",
            "tcp:host",
            "replay:a@-1",
            "serial:/dev/a@x",
        ] {
            let fault = bad.parse::<SourceSpec>().unwrap_err();
            assert!(fault.contains("tcp:HOST:PORT"), "{bad}: {fault}");
        }
    }
}
