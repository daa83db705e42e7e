//! An estimator and a sink that a test can look into.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use hapdef_live::estimator::{TouchEstimator, TouchFrame, TouchWanted};
use hapdef_live::{AnyError, Delivery, LiveError, LiveEvent, LiveFrame, Sink, Touch, Wants};

use crate::support::{Collected, N_GAUGES};

/// Counts what it is asked for.
#[derive(Clone, Default)]
pub(crate) struct Asked {
    pub(crate) n: Arc<AtomicUsize>,
    pub(crate) n_over: Arc<AtomicUsize>,
    pub(crate) wanted: Arc<Mutex<Vec<TouchWanted>>>,
    /// Noise levels that it was given, µε.
    pub(crate) least_ue: Arc<Mutex<Vec<Vec<f64>>>>,
    /// How long it takes for a frame.
    pub(crate) takes: Duration,
}

impl TouchEstimator for Asked {
    fn name(&self) -> &'static str {
        "asked"
    }

    fn n_gauges(&self) -> usize {
        N_GAUGES
    }

    fn estimate_frame(
        &mut self,
        frame: &TouchFrame<'_>,
        touch: &mut Touch,
    ) -> Result<(), LiveError> {
        touch.clear();
        self.n.fetch_add(1, Ordering::Relaxed);
        self.wanted.lock().unwrap().push(frame.wanted);
        std::thread::sleep(self.takes);
        Ok(())
    }

    fn set_least_noise(&mut self, least_ue: &[f64]) -> Result<(), LiveError> {
        self.least_ue.lock().unwrap().push(least_ue.to_vec());
        Ok(())
    }

    fn start_over(&mut self) {
        self.n_over.fetch_add(1, Ordering::Relaxed);
    }
}

type OnFrame = dyn FnMut(&LiveFrame) -> Result<(), AnyError> + Send;

/// A sink that does what a test wants and keeps what it receives.
pub(crate) struct Probe {
    pub(crate) wants: Wants,
    pub(crate) delivery: Delivery,
    pub(crate) on_frame: Box<OnFrame>,
    pub(crate) events: Collected<LiveEvent>,
    pub(crate) is_finished: Arc<AtomicBool>,
}

impl Probe {
    pub(crate) fn new(
        delivery: Delivery,
        on_frame: impl FnMut(&LiveFrame) -> Result<(), AnyError> + Send + 'static,
    ) -> Self {
        Self {
            wants: Wants::RAW,
            delivery,
            on_frame: Box::new(on_frame),
            events: Collected::default(),
            is_finished: Arc::default(),
        }
    }
}

impl Sink for Probe {
    fn name(&self) -> String {
        "probe".to_owned()
    }

    fn wants(&self) -> Wants {
        self.wants
    }

    fn delivery(&self) -> Delivery {
        self.delivery
    }

    fn frame(&mut self, frame: &LiveFrame) -> Result<(), AnyError> {
        (self.on_frame)(frame)
    }

    fn event(&mut self, event: &LiveEvent) -> Result<(), AnyError> {
        self.events.lock().unwrap().push(event.clone());
        Ok(())
    }

    fn finish(&mut self) -> Result<(), AnyError> {
        self.is_finished.store(true, Ordering::Release);
        Ok(())
    }
}
