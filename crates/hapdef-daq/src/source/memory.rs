//! A link within the program, for simulated devices and for tests.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

use super::{Link, LinkFault};

/// Bytes that wait to be read at most, in each direction; more are dropped, as a driver does.
const CAPACITY: usize = 1 << 16;

/// The host's end.
#[derive(Clone, Debug)]
pub struct MemoryLink {
    wire: Arc<Wire>,
}

/// The device's end.
#[derive(Clone, Debug)]
pub struct MemoryDevice {
    wire: Arc<Wire>,
}

#[derive(Debug, Default)]
struct Wire {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    to_host: VecDeque<u8>,
    to_device: VecDeque<u8>,
    is_plugged: bool,
    is_open: bool,
    has_ended: bool,
    n_dropped: u64,
}

/// Both ends of a link that is plugged in.
#[must_use]
pub fn memory_link() -> (MemoryLink, MemoryDevice) {
    let wire = Arc::new(Wire::default());
    let device = MemoryDevice { wire: Arc::clone(&wire) };
    device.replug();
    (MemoryLink { wire }, device)
}

impl MemoryDevice {
    /// Sends bytes; what the host doesn't read in time is dropped, as it is while the host has not
    /// opened the link.
    pub fn send(&self, bytes: &[u8]) {
        self.wire.with(|state| {
            let room = CAPACITY - state.to_host.len();
            let n = if state.is_open { bytes.len().min(room) } else { 0 };
            state.to_host.extend(&bytes[..n]);
            state.n_dropped += (bytes.len() - n) as u64;
        });
        self.wire.changed.notify_all();
    }

    /// What the host has sent.
    #[must_use]
    pub fn receive(&self) -> Vec<u8> {
        self.wire.with(|state| state.to_device.drain(..).collect())
    }

    /// True while the host has the link open.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.wire.with(|state| state.is_open)
    }

    /// Bytes that were sent and dropped.
    #[must_use]
    pub fn n_dropped(&self) -> u64 {
        self.wire.with(|state| state.n_dropped)
    }

    /// Pulls the plug; what was not read yet is lost.
    pub fn unplug(&self) {
        self.wire.with(|state| {
            state.is_plugged = false;
            state.is_open = false;
            state.to_host.clear();
            state.to_device.clear();
        });
        self.wire.changed.notify_all();
    }

    /// Plugs it in again.
    pub fn replug(&self) {
        self.wire.with(|state| state.is_plugged = true);
    }

    /// Says that nothing more will come; what was sent can still be read.
    pub fn end(&self) {
        self.wire.with(|state| state.has_ended = true);
        self.wire.changed.notify_all();
    }
}

impl Link for MemoryLink {
    fn open(&mut self) -> Result<(), LinkFault> {
        let name = self.name();
        self.wire.with(|state| {
            if !state.is_plugged {
                return Err(LinkFault::NotFound { name });
            }
            state.is_open = true;
            Ok(())
        })
    }

    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkFault> {
        let waiting = |s: &mut State| s.to_host.is_empty() && s.is_open && !s.has_ended;
        let state = self.wire.state.lock().unwrap_or_else(PoisonError::into_inner);
        let waited = self.wire.changed.wait_timeout_while(state, timeout, waiting);
        let (mut state, _) = waited.unwrap_or_else(PoisonError::into_inner);
        let name = "memory".to_owned();
        if !state.is_open {
            return Err(LinkFault::Disconnected { name });
        }
        let n = buffer.len().min(state.to_host.len());
        for (to, from) in buffer.iter_mut().zip(state.to_host.drain(..n)) {
            *to = from;
        }
        if n == 0 && state.has_ended {
            return Err(LinkFault::Ended { name });
        }
        Ok(n)
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), LinkFault> {
        self.wire.with(|state| {
            let room = CAPACITY - state.to_device.len();
            state.to_device.extend(&bytes[..bytes.len().min(room)]);
        });
        Ok(())
    }

    fn close(&mut self) {
        self.wire.with(|state| state.is_open = false);
    }

    fn name(&self) -> String {
        "memory".to_owned()
    }
}

impl Wire {
    fn with<T>(&self, use_it: impl FnOnce(&mut State) -> T) -> T {
        use_it(&mut self.state.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
