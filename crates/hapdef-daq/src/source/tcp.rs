//! HDP1 over TCP: a device behind a network, or the virtual rig.

use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
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
    /// The answer to what address the name has, while it is waited for.
    asked: Option<Receiver<std::io::Result<Vec<SocketAddr>>>>,
}

impl TcpLink {
    /// A link to `host:port`, not opened yet.
    #[must_use]
    pub fn new(address: &str) -> Self {
        Self { address: address.to_owned(), stream: None, timeout: None, asked: None }
    }

    fn connect(&mut self) -> std::io::Result<TcpStream> {
        let mut last = ErrorKind::NotFound.into();
        for address in self.addresses()? {
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

impl TcpLink {
    /// Where the name leads. Names are asked for on a thread of their own, as that can take half a
    /// minute, and whoever reads has to be able to stop.
    fn addresses(&mut self) -> std::io::Result<Vec<SocketAddr>> {
        if let Ok(address) = self.address.parse() {
            return Ok(vec![address]);
        }
        let answer = match self.asked.take() {
            Some(answer) => answer,
            None => {
                let (sender, answer) = channel();
                let address = self.address.clone();
                let ask = move || {
                    let found = address.to_socket_addrs();
                    // A link that is gone does not wait any more.
                    let _ = sender.send(found.map(Iterator::collect));
                };
                std::thread::Builder::new().name("hapdef-resolve".to_owned()).spawn(ask)?;
                answer
            }
        };
        match answer.recv_timeout(CONNECT_TIMEOUT) {
            Ok(found) => found,
            Err(RecvTimeoutError::Timeout) => {
                self.asked = Some(answer);
                Err(std::io::Error::other("its name is being looked up"))
            }
            Err(RecvTimeoutError::Disconnected) => Err(ErrorKind::NotFound.into()),
        }
    }
}

impl Link for TcpLink {
    fn open(&mut self) -> Result<(), LinkFault> {
        let name = self.name();
        self.timeout = None;
        let stream = self.connect();
        self.stream = Some(stream.map_err(|error| LinkFault::of_connecting(name, &error))?);
        Ok(())
    }

    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkFault> {
        let gone = |error: &std::io::Error| LinkFault::of_use(&self.address, error);
        let Some(stream) = &mut self.stream else {
            return Err(gone(&ErrorKind::NotConnected.into()));
        };
        let timeout = timeout.max(Duration::from_millis(1));
        if self.timeout != Some(timeout) {
            stream.set_read_timeout(Some(timeout)).map_err(|e| gone(&e))?;
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
