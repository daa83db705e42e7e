//! The runtime without threads: for programs that have none, as in a browser.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use hapdef_daq::AcquireStats;
use hapdef_daq::source::{FrameSource, SourceStats, SourceStatus};

use super::compute::Compute;
use super::outlet::{CalledSink, Outlet};
use super::{LiveBuilder, Shared};
use crate::error::LiveError;

/// A runtime that takes what its source says when it is asked to, and calls its sinks within that. It tells the time
/// by [`super::LiveParams::clock`] alone; with a source that does so, too, the same steps give the same frames.
pub struct LiveSteps {
    compute: Compute,
    source: Box<dyn FrameSource>,
    stats: Arc<Mutex<SourceStats>>,
}

impl LiveBuilder {
    /// Puts it together without threads. Full searches of the estimator are to be run within frames, by
    /// [`crate::estimator::SearchPlace::Here`].
    ///
    /// # Errors
    /// [`LiveError::Parameter`], [`LiveError::NoEstimator`], [`LiveError::FrameLength`] where gauges
    /// and estimator don't fit.
    pub fn in_steps(mut self) -> Result<LiveSteps, LiveError> {
        let sinks = std::mem::take(&mut self.sinks);
        let wants = self.wanted(&sinks)?;
        let outlet = |sink| -> Box<dyn Outlet> { Box::new(CalledSink::new(sink)) };
        let outlets = sinks.into_iter().map(outlet).collect();
        let (setup, source) = self.setup(wants)?;
        let stats = Arc::<Mutex<SourceStats>>::default();
        let theirs = Arc::clone(&stats);
        let tell = move || {
            let source = *theirs.lock().unwrap_or_else(PoisonError::into_inner);
            Arc::new(AcquireStats { source, ..AcquireStats::default() })
        };
        let compute = Compute::new(setup, Box::new(tell), outlets, Arc::new(Shared::new()));
        Ok(LiveSteps { compute, source, stats })
    }
}

impl LiveSteps {
    /// Polls the source once and computes what it says; false once it has said everything.
    pub fn step(&mut self) -> bool {
        let compute = &mut self.compute;
        let status = self.source.poll(Duration::ZERO, &mut |message| compute.take_in(message));
        *self.stats.lock().unwrap_or_else(PoisonError::into_inner) = self.source.stats();
        self.compute.turn();
        status == SourceStatus::Open
    }

    /// Takes a new tare of the next frames, which must be untouched.
    pub fn tare(&mut self) {
        self.compute.tare();
    }
}

impl Drop for LiveSteps {
    fn drop(&mut self) {
        self.compute.end();
    }
}
