//! Frames that a device sent while nobody read.

use std::time::Duration;

use hapdef_daq::Message;

/// What is older than this when it is read is of a backlog.
const OLD: Duration = Duration::from_millis(20);

/// The frames of a backlog that are yet to come. The default is of a device whose time stands still while
/// nobody reads: it has none.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Backlog {
    rate_hz: f64,
    n_left: usize,
}

impl Backlog {
    /// That of a device that sends so many frames a second.
    pub(super) fn new(rate_hz: f64) -> Self {
        Self { rate_hz, n_left: 0 }
    }

    /// Nobody has read for that long.
    pub(super) fn grow(&mut self, blocked: Duration) {
        if blocked > OLD {
            self.n_left = (blocked.as_secs_f64() * self.rate_hz).ceil() as usize;
        }
    }

    /// A read brought these: where they are few, the next ones are new.
    pub(super) fn read(&mut self, messages: &[Message]) {
        let n_frames = messages.iter().filter(|m| is_frame(m)).count();
        if (n_frames as f64) < (OLD.as_secs_f64() * self.rate_hz).max(2.0) {
            self.n_left = 0;
        }
    }

    /// Whether a message is a frame of the backlog, which it leaves.
    pub(super) fn has(&mut self, message: &Message) -> bool {
        let is_old = self.n_left > 0 && is_frame(message);
        self.n_left -= usize::from(is_old);
        is_old
    }
}

fn is_frame(message: &Message) -> bool {
    matches!(message, Message::Frame(_))
}

#[cfg(test)]
mod tests {
    use hapdef_daq::Frame;
    use hapdef_daq::hdp1::SampleFormat;

    use super::*;

    fn n_new(backlog: &mut Backlog, n_read: u32) -> usize {
        let frame = |seq| Message::Frame(Frame::new(seq, SampleFormat::I16, [0]));
        let messages: Vec<Message> = (0..n_read).map(frame).collect();
        backlog.read(&messages);
        messages.iter().filter(|m| !backlog.has(m)).count()
    }

    #[test]
    fn what_came_while_nobody_read_is_left_out() {
        let mut backlog = Backlog::new(1000.0);
        backlog.grow(Duration::from_millis(5));
        assert_eq!(n_new(&mut backlog, 100), 100);
        backlog.grow(Duration::from_millis(150));
        assert!(!backlog.has(&Message::Restarted));
        assert_eq!(n_new(&mut backlog, 100), 0);
        assert_eq!(n_new(&mut backlog, 100), 50);
    }

    #[test]
    fn a_port_keeps_less_than_was_sent() {
        let mut backlog = Backlog::new(1000.0);
        backlog.grow(Duration::from_secs(10));
        assert_eq!(n_new(&mut backlog, 70), 0);
        assert_eq!(n_new(&mut backlog, 1), 1);
        assert_eq!(n_new(&mut backlog, 100), 100);
    }
}
