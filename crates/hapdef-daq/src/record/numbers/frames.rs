//! The numbers of a topic as a device that sends them.

use std::sync::Arc;

use super::find::Found;
use super::{NumbersRow, NumbersTopic};
use crate::hdp1::{Channel, Hello, MAX_CHANNELS, SampleFormat};
use crate::source::{LinkFault, LinkState};
use crate::{DaqError, Frame, Message};

/// Messages at the beginning that the rate is taken from.
const N_FOR_RATE: usize = 200;

/// [`Hello::uid`] of what stands for the device.
const TOPIC_UID: [u8; 16] = *b"numbers, a topic";

/// What the device would say; an iterator.
struct Messages {
    topic: NumbersTopic,
    /// What was read ahead.
    ahead: std::vec::IntoIter<NumbersRow>,
    hello: Option<Arc<Hello>>,
    /// Log time of the first message.
    first_ns: u64,
    last_ns: u64,
    is_over: bool,
}

impl NumbersTopic {
    /// The numbers as frames of a device whose channels are quarter bridges: µε, at the times of the
    /// messages since the first, at a rate that the first two hundred say. In the end [`Message::Link`] tells of
    /// a message that is no such numbers, or of a file that can't be read on.
    ///
    /// # Errors
    /// [`DaqError::NoNumbers`] for more than 64; as [`Self::next_row`] of the first two hundred.
    pub fn messages(mut self) -> Result<impl Iterator<Item = Message> + Send, DaqError> {
        if let Err(message) = check_n(self.n_values()) {
            return Err(DaqError::NoNumbers { path: self.path, topic: self.topic, message });
        }
        let mut ahead = Vec::with_capacity(N_FOR_RATE);
        while ahead.len() < N_FOR_RATE
            && let Some(row) = self.next_row()?
        {
            ahead.push(row);
        }
        let hello = self.hello(&ahead);
        let first_ns = ahead.first().map_or(0, |row| row.log_time_ns);
        let (hello, ahead) = (Some(Arc::new(hello)), ahead.into_iter());
        Ok(Messages { topic: self, ahead, hello, first_ns, last_ns: 0, is_over: false })
    }

    fn hello(&self, ahead: &[NumbersRow]) -> Hello {
        let steps =
            ahead.windows(2).map(|two| two[1].log_time_ns.saturating_sub(two[0].log_time_ns));
        let mut steps: Vec<u64> = steps.filter(|step| *step > 0).collect();
        steps.sort_unstable();
        let step_ns = steps.get(steps.len() / 2);
        let rate_mhz =
            step_ns.map_or(0, |step| u32::try_from(1_000_000_000_000 / step).unwrap_or(0));
        hello(self.first.as_ref(), rate_mhz)
    }
}

/// What the device would say of itself that sends such numbers: quarter bridges, µε. The rate is 0 where it is
/// not known.
pub(super) fn hello(first: Option<&Found>, rate_mhz: u32) -> Hello {
    let plain = Hello::plain(first.map_or(0, |first| first.values.len()), SampleFormat::F32, 0);
    let named =
        |names: &Vec<String>| names.iter().map(|name| Channel::quarter_bridge(name, 1.0)).collect();
    let names = first.and_then(|first| first.names.as_ref());
    let channels = names.map_or(plain.channels.clone(), named);
    let mut hello = Hello { uid: TOPIC_UID, rate_mhz, channels, ..plain };
    hello.seal();
    hello
}

/// The frame of a message's numbers, without its times.
pub(super) fn frame(seq: u32, values: &[f64]) -> Frame {
    let bits = values.iter().map(|value| (*value as f32).to_bits().cast_signed());
    Frame::new(seq, SampleFormat::F32, bits)
}

/// Numbers that are more than a device has channels.
pub(super) fn check_n(n: usize) -> Result<(), String> {
    match n {
        0..=MAX_CHANNELS => Ok(()),
        _ => Err(format!("{n} numbers a message: a device has at most {MAX_CHANNELS}")),
    }
}

impl Messages {
    fn frame(&mut self, row: &NumbersRow) -> Frame {
        // Numbers of packets begin anew after 2³² of them.
        let mut frame = frame((row.number - 1) as u32, &row.values);
        self.last_ns = self.last_ns.max(row.log_time_ns.saturating_sub(self.first_ns));
        (frame.t_host_ns, frame.t_device_us) = (self.last_ns, self.last_ns / 1000);
        frame
    }
}

impl Iterator for Messages {
    type Item = Message;

    fn next(&mut self) -> Option<Message> {
        if let Some(hello) = self.hello.take() {
            return Some(Message::Hello(hello));
        }
        if let Some(row) = self.ahead.next() {
            return Some(Message::Frame(self.frame(&row)));
        }
        if self.is_over {
            return None;
        }
        match self.topic.next_row() {
            Ok(row) => row.map(|row| Message::Frame(self.frame(&row))),
            Err(fault) => {
                self.is_over = true;
                let name = self.topic.path.display().to_string();
                let message = format!("can't be read on: {fault}");
                Some(Message::Link(LinkState::Away(LinkFault::Io { name, message })))
            }
        }
    }
}
