//! The scene's simulated rig as a source in memory, at its own pace.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::{Duration, Instant};

use anyhow::Result;
use hapdef::{Limb, Run, VirtualRigParams, live_limb, random_presses, virtual_device};
use hapdef_daq::clock::HostClock;
use hapdef_daq::source::{FrameSource, Link, LinkFault, StreamParams, StreamSource};
use hapdef_rig::live::{RigLink, RunParams, TruthFrame};

/// Frames of ground truth that wait at most: 8 s at 1 kHz.
const TRUTH_LEN: usize = 8192;

/// A simulated source, and what presses it.
pub(super) type Simulated = (Box<dyn FrameSource>, Receiver<TruthFrame>);

/// Where a rig tells what presses it, and where that is read. What nobody reads is left out.
pub(super) fn truth_line() -> (impl FnMut(&TruthFrame) + Send, Receiver<TruthFrame>) {
    let (sender, frames) = sync_channel(TRUTH_LEN);
    let tell = move |frame: &TruthFrame| drop(sender.try_send(frame.clone()));
    (tell, frames)
}

/// Random presses on the scene's perturbed limb, 1,000 frames a second.
pub(super) fn simulated(run: &Run, limb: &Limb, seed: u64) -> Result<Simulated> {
    let real = Arc::new(live_limb(run, limb)?);
    let params = VirtualRigParams {
        script: Some(random_presses(&run.scene, &real, seed)),
        ..VirtualRigParams::default()
    };
    let device = virtual_device(&run.scene, real, &params)?;
    let (tell, truth) = truth_line();
    let link = RigLink::new(device, &RunParams::default(), tell)?;
    let paced = Paced { clock: link.clock(), link, start: None };
    let source = StreamSource::new(paced, StreamParams::default());
    Ok((Box::new(source), truth))
}

/// A link whose frames come when they are due.
struct Paced {
    link: RigLink,
    /// The play's time.
    clock: Arc<dyn HostClock>,
    /// Moment and play's time of the first read.
    start: Option<(Instant, u64)>,
}

impl Link for Paced {
    fn open(&mut self) -> Result<(), LinkFault> {
        self.link.open()
    }

    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkFault> {
        let played_ns = self.clock.now_ns();
        let (start, first_ns) = *self.start.get_or_insert((Instant::now(), played_ns));
        let due = Duration::from_nanos(played_ns - first_ns);
        let wait = due.saturating_sub(start.elapsed());
        std::thread::sleep(wait.min(timeout));
        if wait > timeout {
            return Ok(0);
        }
        self.link.read(buffer, timeout)
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), LinkFault> {
        self.link.write(bytes)
    }

    fn close(&mut self) {
        self.link.close();
    }

    fn name(&self) -> String {
        self.link.name()
    }
}
