//! The device at a port: paced by the clock, or as fast as it goes.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::device::RigDevice;
use super::events::{Event, Events};
use super::faults::{RigFault, Wires};
use super::port::{DevicePort, PortState};
use super::press::{PressHandle, TruthFrame};
use crate::error::RigError;

/// Bytes that the device keeps while the port takes none, as the firmware does.
const QUEUE_LEN: usize = 32 << 10;
/// A device kept from running for longer leaves samples out instead of making up for them.
const WORST_LATE: Duration = Duration::from_millis(500);

/// How a device is run.
#[derive(Clone, Debug, PartialEq)]
pub struct RunParams {
    /// Frames come when they are due; otherwise one after the other.
    pub is_real_time: bool,
    /// End of the run, s of the play; until it is stopped if `None`.
    pub duration_s: Option<f64>,
    /// What goes wrong on the wire and with the plug.
    pub faults: Vec<RigFault>,
    /// Seed of the damage.
    pub fault_seed: u64,
}

/// What a run has done.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RunInfo {
    /// Frames sampled.
    pub n_frames: u64,
    /// DATA packets that the device dropped as its queue was full or no host was there.
    pub n_dropped: u64,
    /// Frames left out because the program was kept from running for half a second.
    pub n_skipped: u64,
    /// Times that damage hit what was sent.
    pub n_hit: u64,
    /// Longest that a frame was late, s.
    pub worst_late_s: f64,
}

/// A device that runs on a thread of its own. Dropping it stops the thread.
pub struct RunningRig {
    stop: Arc<AtomicBool>,
    press: PressHandle,
    thread: Option<JoinHandle<RunInfo>>,
}

impl Default for RunParams {
    /// In real time without end, nothing goes wrong.
    fn default() -> Self {
        Self { is_real_time: true, duration_s: None, faults: Vec::new(), fault_seed: 1 }
    }
}

/// Runs a device at a port until its time is over or `stop` is set; every frame's truth goes to
/// `truth`.
pub fn run_rig(
    mut device: RigDevice,
    mut port: impl DevicePort,
    params: &RunParams,
    stop: &AtomicBool,
    mut truth: impl FnMut(&TruthFrame),
) -> RunInfo {
    let mut run = Run::new(params);
    let start = Instant::now();
    while !stop.load(Ordering::Acquire) && !run.is_over(device.next_t_s()) {
        if params.is_real_time {
            run.wait(&mut device, start);
        }
        run.step(&mut device, &mut port);
        truth(device.truth());
    }
    run.info.n_hit = run.wires.n_hit();
    run.info
}

/// The same on a thread of its own.
///
/// # Errors
/// [`RigError::Port`] when the operating system has no thread left.
pub fn spawn_rig(
    device: RigDevice,
    port: impl DevicePort + 'static,
    params: RunParams,
    truth: impl FnMut(&TruthFrame) + Send + 'static,
) -> Result<RunningRig, RigError> {
    let stop = Arc::new(AtomicBool::new(false));
    let theirs = Arc::clone(&stop);
    let press = device.press_handle();
    let thread = std::thread::Builder::new()
        .name("hapdef-rig".to_owned())
        .spawn(move || run_rig(device, port, &params, &theirs, truth))
        .map_err(|source| super::port::port_error("thread", source))?;
    let thread = Some(thread);
    Ok(RunningRig { stop, press, thread })
}

impl RunningRig {
    /// What presses by hand.
    #[must_use]
    pub fn press_handle(&self) -> PressHandle {
        self.press.clone()
    }

    /// True once its time is over.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Stops it and waits for it.
    #[must_use]
    pub fn stop(mut self) -> RunInfo {
        self.join()
    }

    fn join(&mut self) -> RunInfo {
        self.stop.store(true, Ordering::Release);
        let joined = self.thread.take().map(JoinHandle::join);
        joined.and_then(Result::ok).unwrap_or_default()
    }
}

impl Drop for RunningRig {
    fn drop(&mut self) {
        self.join();
    }
}

struct Run {
    events: Events,
    wires: Wires,
    duration_s: Option<f64>,
    is_plugged: bool,
    was_open: bool,
    from_host: Vec<u8>,
    packet: Vec<u8>,
    queue: Vec<u8>,
    info: RunInfo,
}

impl Run {
    fn new(params: &RunParams) -> Self {
        Self {
            events: Events::new(&params.faults),
            wires: Wires::new(&params.faults, params.fault_seed),
            duration_s: params.duration_s,
            is_plugged: true,
            was_open: false,
            from_host: Vec::new(),
            packet: Vec::new(),
            queue: Vec::with_capacity(QUEUE_LEN),
            info: RunInfo::default(),
        }
    }

    fn is_over(&self, t_s: f64) -> bool {
        self.duration_s.is_some_and(|duration_s| t_s >= duration_s)
    }

    /// Waits until the next frame is due.
    fn wait(&mut self, device: &mut RigDevice, start: Instant) {
        let due = start + Duration::from_secs_f64(device.next_t_s());
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
        let late = due.elapsed();
        self.info.worst_late_s = self.info.worst_late_s.max(late.as_secs_f64());
        if late > WORST_LATE {
            let before_s = device.next_t_s();
            let now_s = start.elapsed().as_secs_f64();
            device.skip_to(now_s);
            let rate_hz = f64::from(device.hello().rate_mhz) * 1e-3;
            self.info.n_skipped += ((device.next_t_s() - before_s) * rate_hz).round() as u64;
        }
    }

    fn step(&mut self, device: &mut RigDevice, port: &mut impl DevicePort) {
        let t_s = device.next_t_s();
        while let Some(event) = self.events.due(t_s) {
            self.happen(event, device, port);
        }
        self.from_host.clear();
        let is_open = self.is_plugged && port.look(&mut self.from_host) == PortState::Open;
        if is_open && !self.was_open {
            self.queue.clear();
            device.opened(&mut self.packet);
        }
        self.was_open = is_open;
        if !self.from_host.is_empty() {
            device.answer(&self.from_host, t_s, &mut self.packet);
        }
        let room = if is_open {
            QUEUE_LEN.saturating_sub(self.queue.len() + self.packet.len())
        } else {
            self.packet.clear();
            0
        };
        let n_before = device.status().n_tx_dropped;
        device.tick(room, &mut self.packet);
        let n_dropped = device.status().n_tx_dropped.wrapping_sub(n_before);
        self.info.n_dropped += u64::from(n_dropped);
        self.info.n_frames += 1;
        self.wires.pass(&mut self.packet, &mut self.queue);
        self.packet.clear();
        if is_open {
            let n = port.send(&self.queue);
            self.queue.drain(..n);
        }
    }

    fn happen(&mut self, event: Event, device: &mut RigDevice, port: &mut impl DevicePort) {
        match event {
            Event::Unplug => {
                port.unplug();
                (self.is_plugged, self.was_open) = (false, false);
                self.queue.clear();
            }
            Event::Replug => {
                self.is_plugged = port.replug().is_ok();
                if !self.is_plugged {
                    self.events.again(event, device.next_t_s());
                }
            }
            Event::Reset => device.reset(&mut self.packet),
        }
    }
}
