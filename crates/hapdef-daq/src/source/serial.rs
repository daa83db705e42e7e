//! A serial port: exclusive, raw, with low latency where the driver can.

use std::io::{ErrorKind, Read, Write};
use std::time::Duration;

use serialport::{ClearBuffer, SerialPort, SerialPortBuilder, TTYPort};

use super::ports::permission_remedy;
use super::{Link, LinkFault};

const WRITE_TIMEOUT: Duration = Duration::from_millis(50);

/// How a port is opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SerialParams {
    /// Bits per second; native USB ports take any.
    pub baud: u32,
    /// Ask the driver to hand on bytes at once instead of every 16 ms (FTDI) or 4 ms.
    pub low_latency: bool,
}

/// A serial port by its path. Give a name that stays, such as one under /dev/serial/by-id: it is
/// looked up anew at every opening, so that a device is found again on whatever port it comes back.
#[derive(Debug)]
pub struct SerialLink {
    path: String,
    params: SerialParams,
    port: Option<TTYPort>,
    has_low_latency: bool,
}

/// A serial port that is only written to, and never waited for: a write that finds no room fails with
/// [`ErrorKind::TimedOut`].
#[derive(Debug)]
pub struct SerialOutput(TTYPort);

impl Default for SerialParams {
    fn default() -> Self {
        Self { baud: 115_200, low_latency: true }
    }
}

impl SerialOutput {
    /// Opens a port for writing.
    ///
    /// # Errors
    /// [`LinkFault`] as [`Link::open`].
    pub fn open(path: &str, params: &SerialParams) -> Result<Self, LinkFault> {
        let port = builder(path, params).timeout(Duration::ZERO).open_native();
        Ok(Self(port.map_err(|error| refused(path, &error))?))
    }
}

impl Write for SerialOutput {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl SerialLink {
    /// A link to a port, not opened yet.
    #[must_use]
    pub fn new(path: &str, params: SerialParams) -> Self {
        Self { path: path.to_owned(), params, port: None, has_low_latency: false }
    }

    /// True if the driver has agreed to low latency.
    #[must_use]
    pub fn has_low_latency(&self) -> bool {
        self.has_low_latency
    }
}

/// How every port is opened.
pub(crate) fn builder(path: &str, params: &SerialParams) -> SerialPortBuilder {
    serialport::new(path, params.baud).dtr_on_open(true).exclusive(true)
}

/// Why a port can't be opened.
pub(crate) fn refused(path: &str, error: &serialport::Error) -> LinkFault {
    use serialport::ErrorKind as K;
    let name = path.to_owned();
    match error.kind() {
        _ if !std::fs::exists(&name).unwrap_or(true) => LinkFault::NotFound { name },
        K::Io(ErrorKind::PermissionDenied) => {
            LinkFault::PermissionDenied { remedy: permission_remedy(&name), name }
        }
        K::NoDevice | K::Io(ErrorKind::ResourceBusy | ErrorKind::WouldBlock) => {
            LinkFault::Busy { name }
        }
        _ => LinkFault::Io { name, message: error.to_string() },
    }
}

impl Link for SerialLink {
    fn open(&mut self) -> Result<(), LinkFault> {
        let builder = builder(&self.path, &self.params).timeout(WRITE_TIMEOUT);
        let refused = |error: serialport::Error| refused(&self.path, &error);
        let port = builder.open_native().map_err(refused)?;
        // What was sent to whoever had the port before.
        port.clear(ClearBuffer::Input).map_err(refused)?;
        self.has_low_latency = self.params.low_latency && super::low_latency::ask(&port);
        self.port = Some(port);
        Ok(())
    }

    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkFault> {
        let gone = |kind: ErrorKind| LinkFault::of_use(&self.path, &kind.into());
        let Some(port) = &mut self.port else {
            return Err(gone(ErrorKind::NotConnected));
        };
        port.set_timeout(timeout).map_err(|_| gone(ErrorKind::NotConnected))?;
        match port.read(buffer) {
            // A hung-up port reads as empty for ever.
            Ok(0) => Err(gone(ErrorKind::UnexpectedEof)),
            Ok(n) => Ok(n),
            Err(e) if is_later(e.kind()) => Ok(0),
            Err(e) => Err(gone(e.kind())),
        }
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), LinkFault> {
        let Some(port) = &mut self.port else {
            return Ok(());
        };
        let sent = port
            .set_timeout(WRITE_TIMEOUT)
            .map_err(std::io::Error::from)
            .and_then(|()| port.write_all(bytes));
        match sent {
            Err(e) if !is_later(e.kind()) => Err(LinkFault::of_use(&self.path, &e)),
            _ => Ok(()),
        }
    }

    fn close(&mut self) {
        self.port = None;
    }

    fn name(&self) -> String {
        self.path.clone()
    }
}

fn is_later(kind: ErrorKind) -> bool {
    use ErrorKind as K;
    matches!(kind, K::WouldBlock | K::TimedOut | K::Interrupted)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_port_without_permission_says_what_to_do() {
        // root is refused nothing, so that no port is opened here
        let kind = serialport::ErrorKind::Io(ErrorKind::PermissionDenied);
        let error = serialport::Error::new(kind, "Permission denied");
        let fault = refused("/dev/null", &error);
        assert!(
            matches!(&fault, LinkFault::PermissionDenied { name, .. } if name == "/dev/null"),
            "{fault}"
        );
        let text = fault.to_string();
        assert!(text.contains("udev") || text.contains("group"), "{text}");
    }
}
