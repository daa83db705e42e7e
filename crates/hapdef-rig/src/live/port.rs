//! Ports on which the device is reached: within the program, a pseudo-terminal, TCP.

use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};

use hapdef_daq::source::MemoryDevice;

use crate::error::RigError;

/// What a look at a port found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PortState {
    /// No host has it open.
    Closed,
    /// A host has it open.
    Open,
}

/// A port of the device. Nothing here ever waits for the host.
pub trait DevicePort: Send {
    /// Appends what the host has sent to `from_host` and says whether one is there.
    fn look(&mut self, from_host: &mut Vec<u8>) -> PortState;

    /// Sends as many of the bytes as go at once, and says how many.
    fn send(&mut self, bytes: &[u8]) -> usize;

    /// Pulls the plug.
    fn unplug(&mut self);

    /// Plugs it in again.
    ///
    /// # Errors
    /// [`RigError::Port`] when the operating system refuses; it may be tried again.
    fn replug(&mut self) -> Result<(), RigError>;

    /// What a host connects to, in words.
    fn name(&self) -> String;
}

impl DevicePort for MemoryDevice {
    fn look(&mut self, from_host: &mut Vec<u8>) -> PortState {
        from_host.extend(self.receive());
        if self.is_open() { PortState::Open } else { PortState::Closed }
    }

    fn send(&mut self, bytes: &[u8]) -> usize {
        Self::send(self, bytes);
        bytes.len()
    }

    fn unplug(&mut self) {
        Self::unplug(self);
    }

    fn replug(&mut self) -> Result<(), RigError> {
        Self::replug(self);
        Ok(())
    }

    fn name(&self) -> String {
        "memory".to_owned()
    }
}

/// A TCP port with one host at a time; a second one waits until the first has gone.
#[derive(Debug)]
pub struct TcpPort {
    address: SocketAddr,
    listener: Option<TcpListener>,
    host: Option<TcpStream>,
}

impl TcpPort {
    /// Listens at `address`; port 0 picks a free one, [`DevicePort::name`] says which.
    ///
    /// # Errors
    /// [`RigError::Port`] for an address that is taken or not this machine's.
    pub fn listen(address: &str) -> Result<Self, RigError> {
        let refused = |source| port_error(address, source);
        let listener = TcpListener::bind(address).map_err(refused)?;
        listener.set_nonblocking(true).map_err(refused)?;
        Ok(Self {
            address: listener.local_addr().map_err(refused)?,
            listener: Some(listener),
            host: None,
        })
    }

    fn accept(&mut self) {
        let Some(Ok((host, _))) = self.listener.as_ref().map(TcpListener::accept) else {
            return;
        };
        if host.set_nonblocking(true).is_ok() && host.set_nodelay(true).is_ok() {
            self.host = Some(host);
        }
    }
}

impl DevicePort for TcpPort {
    fn look(&mut self, from_host: &mut Vec<u8>) -> PortState {
        if self.host.is_none() {
            self.accept();
        }
        let Some(host) = &mut self.host else {
            return PortState::Closed;
        };
        let mut buffer = [0; 256];
        match host.read(&mut buffer) {
            Ok(n) if n > 0 => from_host.extend_from_slice(&buffer[..n]),
            Err(error) if is_later(error.kind()) => {}
            _ => {
                self.host = None;
                return PortState::Closed;
            }
        }
        PortState::Open
    }

    fn send(&mut self, bytes: &[u8]) -> usize {
        let sent = self.host.as_mut().map(|host| host.write(bytes));
        match sent {
            Some(Ok(n)) => n,
            Some(Err(error)) if !is_later(error.kind()) => {
                self.host = None;
                0
            }
            _ => 0,
        }
    }

    fn unplug(&mut self) {
        (self.listener, self.host) = (None, None);
    }

    fn replug(&mut self) -> Result<(), RigError> {
        let again = Self::listen(&self.address.to_string())?;
        self.listener = again.listener;
        Ok(())
    }

    fn name(&self) -> String {
        self.address.to_string()
    }
}

pub(super) fn port_error(port: &str, source: std::io::Error) -> RigError {
    RigError::Port { port: port.to_owned(), source }
}

fn is_later(kind: ErrorKind) -> bool {
    matches!(kind, ErrorKind::WouldBlock | ErrorKind::Interrupted)
}
