//! An estimator, a sink and a device that a test can look into.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use hapdef_daq::source::{FrameSource, SourceStats, SourceStatus};
use hapdef_daq::{Frame, Message};
use hapdef_live::touch::{Touch, TouchEstimator, TouchFrame, TouchWanted};
use hapdef_live::{AnyError, Delivery, LiveError, LiveEvent, LiveFrame, Sink, Wants};

use crate::support::{Collected, N_GAUGES, hello};

/// Counts what it is asked for.
#[derive(Clone, Default)]
pub(crate) struct Asked {
    pub(crate) n: Arc<AtomicUsize>,
    pub(crate) n_over: Arc<AtomicUsize>,
    pub(crate) wanted: Arc<Mutex<Vec<TouchWanted>>>,
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
        Ok(())
    }

    fn start_over(&mut self) {
        self.n_over.fetch_add(1, Ordering::Relaxed);
    }
}

type OnFrame = dyn FnMut(&LiveFrame) -> Result<(), AnyError> + Send;

/// A sink that does what a test wants and keeps what it is told.
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

/// A device at 1 kHz that never ends.
pub(crate) struct Endless {
    pub(crate) n: u32,
    start: Instant,
}

impl Endless {
    pub(crate) fn new() -> Self {
        Self {
            n: 0,
            start: Instant::now(),
        }
    }
}

impl FrameSource for Endless {
    fn poll(&mut self, _: Duration, sink: &mut dyn FnMut(Message)) -> SourceStatus {
        std::thread::sleep(Duration::from_micros(500));
        if self.n == 0 {
            sink(Message::Hello(Arc::new(hello(N_GAUGES))));
        }
        while self.start.elapsed() > Duration::from_millis(u64::from(self.n)) {
            let counts = (0..N_GAUGES as i32).map(|g| g * 100 + (self.n % 7) as i32);
            let format = hapdef_daq::hdp1::SampleFormat::I32;
            sink(Message::Frame(Frame::new(self.n, format, counts)));
            self.n += 1;
        }
        SourceStatus::Open
    }

    fn stats(&self) -> SourceStats {
        SourceStats::default()
    }

    fn name(&self) -> String {
        "endless".to_owned()
    }
}
