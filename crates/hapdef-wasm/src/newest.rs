//! What the runtime says, for the session.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use hapdef_live::{AnyError, Health, LiveEvent, LiveFrame, Sink, TareOutcome, Wants};
use hapdef_rig::live::TruthFrame;
use hapdef_view::Ranges;

/// The newest of what came.
#[derive(Default)]
pub(crate) struct Newest {
    /// Frames so far.
    pub(crate) n_frames: u64,
    pub(crate) frame: Option<LiveFrame>,
    /// What pressed in the rig's newest frame.
    pub(crate) truth: TruthFrame,
    /// Of the frames that were not shown yet.
    pub(crate) ranges: Ranges,
    pub(crate) health: Option<Arc<Health>>,
    pub(crate) is_tared: bool,
    /// Words that were not said yet.
    pub(crate) notices: Vec<String>,
}

/// [`Newest`], shared with the runtime's sink and the rig.
#[derive(Clone, Default)]
pub(crate) struct SharedNewest(Arc<Mutex<Newest>>);

impl SharedNewest {
    pub(crate) fn lock(&self) -> MutexGuard<'_, Newest> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Sink for SharedNewest {
    fn name(&self) -> String {
        "page".to_owned()
    }

    fn wants(&self) -> Wants {
        Wants::ALL
    }

    fn frame(&mut self, frame: &LiveFrame) -> Result<(), AnyError> {
        let mut newest = self.lock();
        newest.n_frames += 1;
        newest.ranges.take(&frame.tared_ue, &frame.touch.contacts);
        let to = newest.frame.get_or_insert_with(|| LiveFrame::new(frame.raw_ue.len()));
        to.copy_from(frame);
        Ok(())
    }

    fn event(&mut self, event: &LiveEvent) -> Result<(), AnyError> {
        let mut newest = self.lock();
        match event {
            LiveEvent::Tared => {
                newest.is_tared = true;
                newest.notices.push("Tared".to_owned());
            }
            LiveEvent::TareFault(fault) => {
                // a tare that begins again needs the virtual hand away
                newest.is_tared = fault.outcome != TareOutcome::Again;
                newest.notices.push(fault.to_string());
            }
            LiveEvent::Health(health) => newest.health = Some(Arc::clone(health)),
            _ => {}
        }
        Ok(())
    }
}
