//! HDP1 over TCP: a device behind a network, or the virtual rig.

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

use super::{Link, LinkFault};

const CONNECT_TIMEOUT: Duration = Duration::from_millis(500);
const WRITE_TIMEOUT: Duration = Duration::from_millis(50);

/// A connection to a device's TCP port.
#[derive(Debug)]
pub struct TcpLink {
    address: String,
    stream: Option<TcpStream>,
    timeout: Option<Duration>,
}

impl TcpLink {
    /// A link to `host:port`, not opened yet.
    #[must_use]
    pub fn new(address: &str) -> Self {
        Self {
            address: address.to_owned(),
            stream: None,
            timeout: None,
        }
    }

    fn connect(&self) -> std::io::Result<TcpStream> {
        let mut last = ErrorKind::NotFound.into();
        for address in self.address.to_socket_addrs()? {
            match TcpStream::connect_timeout(&address, CONNECT_TIMEOUT) {
                Ok(stream) => {
                    stream.set_nodelay(true)?;
                    stream.set_write_timeout(Some(WRITE_TIMEOUT))?;
                    return Ok(stream);
                }
                Err(error) => last = error,
            }
        }
        Err(last)
    }
}

impl Link for TcpLink {
    fn open(&mut self) -> Result<(), LinkFault> {
        let name = self.name();
        self.timeout = None;
        self.stream = Some(self.connect().map_err(|error| match error.kind() {
            ErrorKind::ConnectionRefused | ErrorKind::NotFound | ErrorKind::TimedOut => {
                LinkFault::NotFound { name }
            }
            _ => LinkFault::Io {
                name,
                message: error.to_string(),
            },
        })?);
        Ok(())
    }

    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkFault> {
        let gone = |error: &std::io::Error| LinkFault::of_use(&self.address, error);
        let Some(stream) = &mut self.stream else {
            return Err(gone(&ErrorKind::NotConnected.into()));
        };
        let timeout = timeout.max(Duration::from_millis(1));
        if self.timeout != Some(timeout) {
            stream
                .set_read_timeout(Some(timeout))
                .map_err(|e| gone(&e))?;
            self.timeout = Some(timeout);
        }
        match stream.read(buffer) {
            Ok(0) => Err(gone(&ErrorKind::UnexpectedEof.into())),
            Ok(n) => Ok(n),
            Err(e) if is_later(e.kind()) => Ok(0),
            Err(e) => Err(gone(&e)),
        }
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), LinkFault> {
        let Some(stream) = &mut self.stream else {
            return Ok(());
        };
        match stream.write_all(bytes) {
            Err(e) if !is_later(e.kind()) => Err(LinkFault::of_use(&self.address, &e)),
            _ => Ok(()),
        }
    }

    fn close(&mut self) {
        self.stream = None;
    }

    fn name(&self) -> String {
        self.address.clone()
    }
}

fn is_later(kind: ErrorKind) -> bool {
    use ErrorKind as K;
    matches!(kind, K::WouldBlock | K::TimedOut | K::Interrupted)
}
