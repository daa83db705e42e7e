//! The device as a link that is read directly: no thread, no waiting, the same bytes every time.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use hapdef_daq::clock::HostClock;
use hapdef_daq::source::{Link, LinkFault};

use super::device::RigDevice;
use super::events::{Event, Events};
use super::faults::{RigFault, Wires};
use super::press::TruthFrame;
use super::run::RunParams;
use crate::error::RigError;

/// Wall time at which every play begins: 2000-01-01 UTC, ns.
const WALL_START_NS: u64 = 946_684_800_000_000_000;

/// The device's end and the host's in one: every read makes the next frame, as fast as it is asked
/// for. Give the source [`RigLink::clock`], which tells the play's time, and the whole chain behind it
/// is deterministic.
pub struct RigLink {
    device: RigDevice,
    events: Events,
    wires: Wires,
    duration_s: Option<f64>,
    clock: RigClock,
    truth: Box<dyn FnMut(&TruthFrame) + Send>,
    packet: Vec<u8>,
    waiting: Vec<u8>,
}

/// The play's time as the host's clocks.
#[derive(Clone, Debug, Default)]
pub struct RigClock {
    now_ns: Arc<AtomicU64>,
}

impl RigLink {
    /// A link to `device`; every frame's truth goes to `truth`. Of `params` the pace is not used.
    ///
    /// # Errors
    /// [`RigError::Fault`] if the plug is to be pulled, which needs a port.
    pub fn new(
        device: RigDevice,
        params: &RunParams,
        truth: impl FnMut(&TruthFrame) + Send + 'static,
    ) -> Result<Self, RigError> {
        let is_unplug = |fault: &&RigFault| matches!(fault, RigFault::Unplug { .. });
        if let Some(fault) = params.faults.iter().find(is_unplug) {
            return Err(RigError::Fault {
                found: format!("{fault:?}"),
                expected: "no unplugging here: a link without a port has no plug",
            });
        }
        Ok(Self {
            device,
            events: Events::new(&params.faults),
            wires: Wires::new(&params.faults, params.fault_seed),
            duration_s: params.duration_s,
            clock: RigClock::default(),
            truth: Box::new(truth),
            packet: Vec::new(),
            waiting: Vec::new(),
        })
    }

    /// The play's time for the source that reads this.
    #[must_use]
    pub fn clock(&self) -> Arc<dyn HostClock> {
        Arc::new(self.clock.clone())
    }

    /// Whether the next read makes the next frame.
    #[must_use]
    pub fn is_read_out(&self) -> bool {
        self.waiting.is_empty()
    }

    fn step(&mut self) {
        let t_s = self.device.next_t_s();
        self.clock.set_s(t_s);
        while let Some(event) = self.events.due(t_s) {
            if event == Event::Reset {
                self.device.reset(&mut self.packet);
            }
        }
        self.device.tick(usize::MAX, &mut self.packet);
        (self.truth)(self.device.truth());
        self.wires.pass(&mut self.packet, &mut self.waiting);
        self.packet.clear();
    }
}

impl Link for RigLink {
    fn open(&mut self) -> Result<(), LinkFault> {
        self.device.opened(&mut self.packet);
        Ok(())
    }

    fn read(&mut self, buffer: &mut [u8], _timeout: Duration) -> Result<usize, LinkFault> {
        if self.waiting.is_empty() {
            let is_over = |end_s| self.device.next_t_s() >= end_s;
            if self.duration_s.is_some_and(is_over) {
                return Err(LinkFault::Ended { name: self.name() });
            }
            self.step();
        }
        let n = buffer.len().min(self.waiting.len());
        for (to, from) in buffer.iter_mut().zip(self.waiting.drain(..n)) {
            *to = from;
        }
        Ok(n)
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), LinkFault> {
        let t_s = self.device.next_t_s();
        self.device.answer(bytes, t_s, &mut self.packet);
        Ok(())
    }

    fn close(&mut self) {
        self.waiting.clear();
        self.packet.clear();
    }

    fn name(&self) -> String {
        "virtual rig".to_owned()
    }
}

impl RigClock {
    fn set_s(&self, t_s: f64) {
        self.now_ns.store((t_s * 1e9) as u64, Ordering::Release);
    }
}

impl HostClock for RigClock {
    fn now_ns(&self) -> u64 {
        self.now_ns.load(Ordering::Acquire)
    }

    fn wall_ns(&self) -> u64 {
        WALL_START_NS + self.now_ns()
    }
}
