//! Where the stop signal goes, and what it says when.

use std::io::Write;
use std::net::UdpSocket;
use std::str::FromStr;
use std::time::Duration;

use anyhow::{Context, Result, ensure};
use clap::Args;
use hapdef::SourceArg;
use hapdef_daq::source::{SerialOutput, SerialParams};
use hapdef_live::sinks::AlertSink;
use hapdef_live::{Alert, AlertParams, Threshold};

const ADDRESS: &str = "serial:DEV[@BAUD] or udp:HOST:PORT";

/// The stop signal.
#[derive(Args, Clone, Debug)]
pub(super) struct AlertArgs {
    #[arg(
        long, value_name = "ADDRESS",
        help = format!(
            "Tell a controller to warn and to stop, a short line whenever that changes and every \
             --alert-repeat-ms: {ADDRESS}"
        )
    )]
    alert: Option<AlertAddress>,
    /// Force of a contact from which on it is to warn, N, and the one below which that ends, half of it if not
    /// given.
    #[arg(long, value_name = "N[:OFF]", requires = "alert", default_value = "0.5")]
    warn_n: ThresholdArg,
    /// The same for a stop.
    #[arg(long, value_name = "N[:OFF]", requires = "alert", default_value = "1")]
    stop_n: ThresholdArg,
    /// What readings mean that no contacts explain: something touches, of a force that is not known.
    #[arg(long, value_enum, requires = "alert", default_value_t = MisfitArg::Stop)]
    alert_misfit: MisfitArg,
    /// Time after which what still holds is said again, ms: a controller takes a longer silence for a stop.
    #[arg(long, value_name = "MS", requires = "alert", default_value_t = 10)]
    alert_repeat_ms: u64,
}

/// What a misfit means to a controller.
#[derive(Clone, Copy, Debug, PartialEq, clap::ValueEnum)]
enum MisfitArg {
    /// A stop.
    Stop,
    /// Nothing is known.
    Unknown,
}

#[derive(Clone, Debug)]
enum AlertAddress {
    Serial { device: String, baud: u32 },
    Udp(String),
}

#[derive(Clone, Copy, Debug)]
struct ThresholdArg(Threshold);

impl FromStr for AlertAddress {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some(address) = text.strip_prefix("udp:") {
            return Ok(Self::Udp(address.to_owned()));
        }
        match text.parse() {
            Ok(SourceArg::Serial { device, baud }) => Ok(Self::Serial { device, baud }),
            _ => Err(format!("expected {ADDRESS}")),
        }
    }
}

impl FromStr for ThresholdArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (on, off) = text.split_once(':').map_or((text, None), |(on, off)| (on, Some(off)));
        let number = |text: &str| {
            text.parse().map_err(|_| format!("expected newtons such as 1 or 1:0.4, found {text}"))
        };
        let on_n = number(on)?;
        Ok(Self(match off {
            Some(off) => Threshold { on_n, off_n: number(off)? },
            None => Threshold::half_off(on_n),
        }))
    }
}

impl AlertArgs {
    pub(super) fn is_wanted(&self) -> bool {
        self.alert.is_some()
    }

    /// What says it, where that is asked for.
    pub(super) fn sink(&self) -> Result<Option<AlertSink<Box<dyn Write + Send>>>> {
        let Some(address) = &self.alert else {
            return Ok(None);
        };
        let params = AlertParams {
            warn: self.warn_n.0,
            stop: self.stop_n.0,
            misfit_stops: self.alert_misfit == MisfitArg::Stop,
        };
        let alert = Alert::new(params).context("--warn-n and --stop-n")?;
        ensure!(self.alert_repeat_ms > 0, "--alert-repeat-ms: expected above 0, found 0");
        let repeat = Duration::from_millis(self.alert_repeat_ms);
        Ok(Some(AlertSink::new(address.open()?, alert, repeat)))
    }
}

impl AlertAddress {
    fn open(&self) -> Result<Box<dyn Write + Send>> {
        match self {
            Self::Serial { device, baud } => {
                let params = SerialParams { baud: *baud, ..SerialParams::default() };
                Ok(Box::new(SerialOutput::open(device, &params).context("--alert")?))
            }
            Self::Udp(address) => {
                let open = || -> std::io::Result<UdpSocket> {
                    let is_v6 = address.starts_with('[');
                    let socket = UdpSocket::bind(if is_v6 { "[::]:0" } else { "0.0.0.0:0" })?;
                    socket.connect(address.as_str())?;
                    socket.set_nonblocking(true)?;
                    Ok(socket)
                };
                let socket = open().with_context(|| {
                    format!("--alert udp:{address}: expected HOST:PORT that can be reached")
                })?;
                Ok(Box::new(Datagrams(socket)))
            }
        }
    }
}

/// Each write is a datagram.
struct Datagrams(UdpSocket);

impl Write for Datagrams {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.send(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}
