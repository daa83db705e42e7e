//! JSON lines for whoever connects, by TCP or a Unix socket.

use std::io::{ErrorKind, Write};
use std::net::TcpListener;
#[cfg(unix)]
use std::os::unix::net::UnixListener;
#[cfg(unix)]
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::json::{event_line, frame_line};
use crate::error::{AnyError, LiveError};
use crate::frame::LiveFrame;
use crate::health::ClientHealth;
use crate::sink::{Clients, Delivery, LiveEvent, Sink, Wants};

/// Bytes that wait for a client at most; beyond that lines are left out.
const MAX_WAITING: usize = 256 << 10;

/// Clients at most.
const MAX_CLIENTS: usize = 8;

/// Frames that wait for this sink.
const N_QUEUED: usize = 1024;

/// Sends every frame as a line of JSON to all clients. A client that is too slow misses whole lines
/// and receives their number in an event line; the others miss nothing. A clone sends to the same clients, for
/// another limb.
#[derive(Clone)]
pub struct JsonServer {
    address: String,
    hub: Arc<Mutex<Hub>>,
    limb: Option<String>,
    health: Clients,
    line: Vec<u8>,
}

/// Whoever listens, for all limbs that are sent.
struct Hub {
    listener: Listener,
    clients: Vec<Client>,
}

enum Listener {
    Tcp(TcpListener),
    #[cfg(unix)]
    Unix(UnixListener, PathBuf),
}

struct Client {
    stream: Box<dyn Write + Send>,
    waiting: Vec<u8>,
    /// Lines left out since the last such event line.
    n_left_out: u64,
    health: ClientHealth,
}

impl JsonServer {
    /// Listens at `tcp:HOST:PORT` or `unix:PATH`.
    ///
    /// # Errors
    /// [`LiveError::Listen`].
    pub fn bind(address: &str) -> Result<Self, LiveError> {
        let refused = |source| LiveError::Listen { address: address.to_owned(), source };
        let listener = Listener::bind(address).map_err(refused)?;
        Ok(Self {
            address: listener.address().unwrap_or_else(|| address.to_owned()),
            hub: Arc::new(Mutex::new(Hub { listener, clients: Vec::new() })),
            limb: None,
            health: Clients::default(),
            line: Vec::with_capacity(4096),
        })
    }

    /// The same for a limb of several, whose lines have its name as `"limb"`.
    #[must_use]
    pub fn of_limb(self, name: &str) -> Self {
        Self { limb: Some(name.to_owned()), ..self }
    }

    /// Where it listens, with the port that the system gave for port 0.
    #[must_use]
    pub fn address(&self) -> &str {
        &self.address
    }

    fn hub(&self) -> MutexGuard<'_, Hub> {
        self.hub.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Hub {
    fn accept(&mut self) {
        while let Some((stream, name)) = self.listener.accept() {
            if self.clients.len() < MAX_CLIENTS {
                self.clients.push(Client {
                    stream,
                    waiting: Vec::with_capacity(MAX_WAITING),
                    n_left_out: 0,
                    health: ClientHealth { name, n_left_out: 0 },
                });
            }
        }
    }

    /// Publishes the state of the clients for the health line.
    fn publish_health(&self, health: &Clients) {
        let mut health = health.lock().unwrap_or_else(PoisonError::into_inner);
        health.clear();
        health.extend(self.clients.iter().map(|client| client.health.clone()));
    }

    fn send(&mut self, line: &[u8]) {
        self.clients.retain_mut(|client| {
            client.add(line);
            client.send()
        });
    }
}

impl Sink for JsonServer {
    fn name(&self) -> String {
        format!("json {}", self.address)
    }

    fn wants(&self) -> Wants {
        Wants::ALL
    }

    fn delivery(&self) -> Delivery {
        Delivery::Queue(N_QUEUED)
    }

    fn clients(&self) -> Option<Clients> {
        Some(Arc::clone(&self.health))
    }

    fn frame(&mut self, frame: &LiveFrame) -> Result<(), AnyError> {
        let has_clients = {
            let mut hub = self.hub();
            hub.accept();
            !hub.clients.is_empty()
        };
        if has_clients {
            frame_line(self.limb.as_deref(), frame, &mut self.line)?;
            self.hub().send(&self.line);
        }
        Ok(())
    }

    fn event(&mut self, event: &LiveEvent) -> Result<(), AnyError> {
        let has_line = event_line(self.limb.as_deref(), event, &mut self.line)?;
        let mut hub = self.hub();
        hub.accept();
        if has_line {
            hub.send(&self.line);
        }
        hub.publish_health(&self.health);
        Ok(())
    }
}

impl Client {
    /// Lets a line wait; where there is no room it is left out and counted.
    fn add(&mut self, line: &[u8]) {
        if self.n_left_out > 0 && self.waiting.len() < MAX_WAITING / 2 {
            let n = std::mem::take(&mut self.n_left_out);
            let event = format!("{{\"event\":\"left_out\",\"text\":\"{n} lines\"}}\n");
            self.waiting.extend_from_slice(event.as_bytes());
        }
        let has_room = self.n_left_out == 0 && self.waiting.len() + line.len() <= MAX_WAITING;
        if has_room {
            self.waiting.extend_from_slice(line);
        } else {
            self.n_left_out += 1;
            self.health.n_left_out += 1;
        }
    }

    /// Sends what goes without waiting; false if the client is gone.
    fn send(&mut self) -> bool {
        let mut n_sent = 0;
        let is_there = loop {
            if n_sent == self.waiting.len() {
                break true;
            }
            match self.stream.write(&self.waiting[n_sent..]) {
                Ok(0) => break false,
                Ok(n) => n_sent += n,
                Err(e) if e.kind() == ErrorKind::WouldBlock => break true,
                Err(e) if e.kind() == ErrorKind::Interrupted => {}
                Err(_) => break false,
            }
        };
        self.waiting.drain(..n_sent);
        is_there
    }
}

impl Listener {
    fn bind(address: &str) -> std::io::Result<Self> {
        if let Some(address) = address.strip_prefix("tcp:") {
            let listener = TcpListener::bind(address)?;
            listener.set_nonblocking(true)?;
            return Ok(Self::Tcp(listener));
        }
        #[cfg(unix)]
        if let Some(path) = address.strip_prefix("unix:") {
            let listener = UnixListener::bind(path)?;
            listener.set_nonblocking(true)?;
            return Ok(Self::Unix(listener, path.into()));
        }
        let message = "not an address";
        Err(std::io::Error::new(ErrorKind::InvalidInput, message))
    }

    fn address(&self) -> Option<String> {
        match self {
            Self::Tcp(listener) => Some(format!("tcp:{}", listener.local_addr().ok()?)),
            #[cfg(unix)]
            Self::Unix(_, path) => Some(format!("unix:{}", path.display())),
        }
    }

    fn accept(&self) -> Option<(Box<dyn Write + Send>, String)> {
        match self {
            Self::Tcp(listener) => {
                let (stream, from) = listener.accept().ok()?;
                stream.set_nonblocking(true).ok()?;
                stream.set_nodelay(true).ok()?;
                Some((Box::new(stream), from.to_string()))
            }
            #[cfg(unix)]
            Self::Unix(listener, path) => {
                let (stream, _) = listener.accept().ok()?;
                stream.set_nonblocking(true).ok()?;
                Some((Box::new(stream), format!("a client of {}", path.display())))
            }
        }
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        #[cfg(unix)]
        if let Self::Unix(_, path) = self {
            // only a name is left behind otherwise
            let _ = std::fs::remove_file(path);
        }
    }
}
