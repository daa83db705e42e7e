//! The stop signal: a short line to a controller whenever what it is to do changes, and so often that silence is
//! noticed.

use std::io::{ErrorKind, Write};
use std::time::Duration;

use hapdef_contact::TouchPhase;

use crate::alert::{Alert, AlertLevel};
use crate::error::AnyError;
use crate::frame::LiveFrame;
use crate::sink::{Delivery, LiveEvent, Sink, Wants};

/// Writes what a controller is to do, within the computing thread, to what must not wait: a serial port or a
/// socket that says at once that it has no room. A line is the level's letter, the strongest force in N and the host
/// time of the sample instant in ns: `S 5.214 81273645123456`.
pub struct AlertSink<W> {
    out: W,
    alert: Alert,
    /// The level is repeated so often.
    repeat_ns: u64,
    written: Option<Written>,
    /// Half a line may have been written last.
    is_broken: bool,
    line: Vec<u8>,
}

/// What was written last.
#[derive(Clone, Copy)]
struct Written {
    level: AlertLevel,
    t_ns: u64,
}

impl<W: Write + Send> AlertSink<W> {
    /// A sink that writes to `out` what `alert` says, each time that it changes and every `repeat`.
    pub fn new(out: W, alert: Alert, repeat: Duration) -> Self {
        let repeat_ns = u64::try_from(repeat.as_nanos()).unwrap_or(u64::MAX);
        let line = Vec::with_capacity(64);
        Self { out, alert, repeat_ns, written: None, is_broken: false, line }
    }

    /// Writes if there is something to say; what finds no room now is said with the next frame.
    fn put(
        &mut self,
        level: AlertLevel,
        force_n: f64,
        sampled_ns: u64,
        now_ns: u64,
    ) -> Result<(), AnyError> {
        let is_said = self.written.is_some_and(|written| {
            written.level == level && now_ns.saturating_sub(written.t_ns) < self.repeat_ns
        });
        if is_said {
            return Ok(());
        }
        self.line.clear();
        if self.is_broken {
            self.line.push(b'\n');
        }
        writeln!(self.line, "{} {force_n:.3} {sampled_ns}", level.letter())?;
        match self.out.write(&self.line) {
            Ok(n) => self.is_broken = n < self.line.len(),
            Err(error) if has_no_room(error.kind()) => return Ok(()),
            Err(error) => return Err(error.into()),
        }
        if !self.is_broken {
            self.written = Some(Written { level, t_ns: now_ns });
        }
        Ok(())
    }

    /// What is said where no frame says it.
    fn put_unknown(&mut self) -> Result<(), AnyError> {
        let t_ns = self.written.map_or(0, |written| written.t_ns);
        let (level, force_n) = self.alert.follow(&[], TouchPhase::Taring);
        self.put(level, force_n, t_ns, t_ns.saturating_add(self.repeat_ns))
    }
}

impl<W: Write + Send> Sink for AlertSink<W> {
    fn name(&self) -> String {
        "alert".to_owned()
    }

    fn wants(&self) -> Wants {
        Wants::CONTACTS
    }

    fn delivery(&self) -> Delivery {
        Delivery::Direct
    }

    fn frame(&mut self, frame: &LiveFrame) -> Result<(), AnyError> {
        // Contacts of an earlier frame have been followed already.
        let contacts = if frame.is_stale { &[] } else { &frame.touch.contacts[..] };
        let (level, force_n) = self.alert.follow(contacts, frame.phase);
        self.put(level, force_n, frame.t_host_ns, frame.t_done_ns)
    }

    fn event(&mut self, event: &LiveEvent) -> Result<(), AnyError> {
        match event {
            LiveEvent::Phase(status) if status.is_stale || !status.phase.is_known() => {
                self.put_unknown()
            }
            _ => Ok(()),
        }
    }

    fn finish(&mut self) -> Result<(), AnyError> {
        self.put_unknown()
    }
}

/// Nobody listens at the other end yet, or no longer; or what was written before still waits.
fn has_no_room(kind: ErrorKind) -> bool {
    use ErrorKind as K;
    matches!(kind, K::WouldBlock | K::TimedOut | K::Interrupted | K::ConnectionRefused)
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use hapdef_contact::Contact;
    use nalgebra::Point3;

    use super::*;
    use crate::alert::AlertParams;
    use crate::sink::PhaseStatus;

    /// Takes so many bytes of each line; none has no room.
    #[derive(Clone, Default)]
    struct Wire {
        taken: Arc<Mutex<Vec<u8>>>,
        room: Arc<Mutex<Option<usize>>>,
    }

    impl Write for Wire {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            let room = self.room.lock().unwrap().ok_or(ErrorKind::WouldBlock)?;
            let n = room.min(bytes.len());
            self.taken.lock().unwrap().extend(&bytes[..n]);
            Ok(n)
        }

        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    fn frame(t_ms: u64, force_n: f64) -> LiveFrame {
        let mut frame = LiveFrame::new(1);
        frame.phase = TouchPhase::Touched;
        frame.touch.contacts.push(Contact::new(Point3::origin(), force_n));
        (frame.t_host_ns, frame.t_done_ns) = (t_ms * 1_000_000, t_ms * 1_000_000);
        frame
    }

    #[test]
    fn changes_are_said_at_once_and_the_rest_is_repeated() {
        let wire = Wire::default();
        *wire.room.lock().unwrap() = Some(100);
        let alert = Alert::new(AlertParams::default()).unwrap();
        let mut sink = AlertSink::new(wire.clone(), alert, Duration::from_millis(10));
        for (t_ms, force_n) in [(1, 0.0), (2, 0.0), (3, 2.0), (4, 2.5), (13, 3.0), (14, 3.0)] {
            sink.frame(&frame(t_ms, force_n)).unwrap();
        }
        let said = String::from_utf8(std::mem::take(&mut wire.taken.lock().unwrap())).unwrap();
        assert_eq!(said, "C 0.000 1000000\nS 2.000 3000000\nS 3.000 13000000\n");
        sink.frame(&frame(15, 0.1)).unwrap();
        let stalled = PhaseStatus {
            phase: TouchPhase::Untouched,
            is_stale: true,
            n_contacts: 0,
            silent_s: 0.1,
        };
        sink.event(&LiveEvent::Phase(stalled)).unwrap();
        let said = String::from_utf8(wire.taken.lock().unwrap().clone()).unwrap();
        assert_eq!(said, "C 0.100 15000000\nU 0.000 15000000\n");
    }

    #[test]
    fn a_stop_that_finds_no_room_is_said_with_the_next_frame() {
        let wire = Wire::default();
        let alert = Alert::new(AlertParams::default()).unwrap();
        let mut sink = AlertSink::new(wire.clone(), alert, Duration::from_secs(1));
        for (t_ms, room) in [(1, None), (2, Some(3)), (3, Some(100)), (4, Some(100))] {
            *wire.room.lock().unwrap() = room;
            sink.frame(&frame(t_ms, 2.0)).unwrap();
        }
        let said = String::from_utf8(wire.taken.lock().unwrap().clone()).unwrap();
        assert_eq!(said, "S 2\nS 2.000 3000000\n");
    }
}
