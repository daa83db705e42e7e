//! A device that never ends.

use std::sync::Arc;
use std::time::{Duration, Instant};

use hapdef_daq::hdp1::{Hello, SampleFormat};
use hapdef_daq::source::{FrameSource, SourceStats, SourceStatus};
use hapdef_daq::{Frame, Message};

/// Sends at 1 kHz.
pub struct Endless {
    hello: Arc<Hello>,
    n_sent: u32,
    start: Instant,
}

impl Endless {
    pub fn new(n_channels: usize) -> Self {
        Self {
            hello: Arc::new(Hello::plain(n_channels, SampleFormat::I32, 1000)),
            n_sent: 0,
            start: Instant::now(),
        }
    }
}

impl FrameSource for Endless {
    fn poll(&mut self, _: Duration, sink: &mut dyn FnMut(Message)) -> SourceStatus {
        std::thread::sleep(Duration::from_micros(500));
        if self.n_sent == 0 {
            sink(Message::Hello(Arc::clone(&self.hello)));
        }
        while self.start.elapsed() > Duration::from_millis(u64::from(self.n_sent)) {
            let wave = |c: i32| 100_000 * c + (self.n_sent * 57 % 97) as i32;
            let counts = (0..self.hello.channels.len() as i32).map(wave);
            sink(Message::Frame(Frame::new(self.n_sent, SampleFormat::I32, counts)));
            self.n_sent += 1;
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
