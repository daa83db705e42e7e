//! Frames that were recorded, or made up, at any speed.

use std::time::{Duration, Instant};

use super::{FrameSource, SourceStats, SourceStatus};
use crate::Message;

/// Frames handed out in one turn at most, so that whoever polls stays in control.
const N_AT_ONCE: u64 = 256;

/// Hands out messages at the pace of their frames' host times.
pub struct ReplaySource<I> {
    name: String,
    messages: I,
    next: Option<Message>,
    speed: f64,
    /// Moment and host time of the first frame.
    start: Option<(Instant, u64)>,
    stats: SourceStats,
}

impl<I: Iterator<Item = Message> + Send> ReplaySource<I> {
    /// A replay at `speed` times the original; infinite, or anything that is not above 0, is as
    /// fast as it goes.
    pub fn new(name: &str, messages: I, speed: f64) -> Self {
        Self {
            name: name.to_owned(),
            messages,
            next: None,
            speed,
            start: None,
            stats: SourceStats::default(),
        }
    }

    /// Time until a message is due.
    fn wait(&mut self, message: &Message) -> Duration {
        let Message::Frame(frame) = message else {
            return Duration::ZERO;
        };
        if !(self.speed > 0.0 && self.speed.is_finite()) {
            return Duration::ZERO;
        }
        let now = Instant::now();
        let (start, first_ns) = *self.start.get_or_insert((now, frame.t_host_ns));
        let after_s = frame.t_host_ns.saturating_sub(first_ns) as f64 * 1e-9 / self.speed;
        let due = Duration::try_from_secs_f64(after_s).unwrap_or(Duration::MAX);
        due.saturating_sub(now - start)
    }

    fn hand_out(&mut self, message: Message, sink: &mut dyn FnMut(Message)) {
        if let Message::Frame(frame) = &message {
            self.stats.n_frames += 1;
            self.stats.losses.n_delivered += 1;
            self.stats.losses.n_lost += u64::from(frame.n_lost_before);
        }
        sink(message);
    }
}

impl<I: Iterator<Item = Message> + Send> FrameSource for ReplaySource<I> {
    fn poll(&mut self, timeout: Duration, sink: &mut dyn FnMut(Message)) -> SourceStatus {
        let deadline = Instant::now() + timeout;
        for _ in 0..N_AT_ONCE {
            let Some(message) = self.next.take().or_else(|| self.messages.next()) else {
                return SourceStatus::Ended;
            };
            let wait = self.wait(&message);
            let left = deadline.saturating_duration_since(Instant::now());
            if wait > left {
                self.next = Some(message);
                std::thread::sleep(left);
                return SourceStatus::Open;
            }
            if !wait.is_zero() {
                std::thread::sleep(wait);
            }
            self.hand_out(message, sink);
        }
        SourceStatus::Open
    }

    fn stats(&self) -> SourceStats {
        self.stats
    }

    fn name(&self) -> String {
        self.name.clone()
    }
}
