//! The messages of a topic of ROS 2 as they come: frames, with what is missing between them.

use std::sync::Arc;

use super::cdr::Ros2Type;
use super::find::{Found, numbers};
use super::frames::{check_n, frame, hello};
use super::same_as_first;
use crate::clock::ClockMap;
use crate::hdp1::FrameFlags;
use crate::source::pace::{ClockWords, Rate};
use crate::source::{LinkState, SourceStats, TopicFault};
use crate::{DaqError, Frame, Message};

/// While the publisher that is followed was heard no longer ago than this, no other one is.
const TAKEOVER_NS: u64 = 1_000_000_000;
/// What was said of messages that are refused is said again after so long.
const PAUSE_NS: u64 = 10_000_000_000;

/// Makes frames of a topic's messages, as a device with a channel for each number would send them: quarter
/// bridges, µε.
///
/// Messages are those that [`super::NumbersTopic`] reads of a file. A frame's time is that of its message's
/// header, else of its sending, mapped to the host's clock by the fastest of them, else of its arrival.
pub struct TopicReader {
    topic: String,
    field: Option<String>,
    message: Ros2Type,
    n_gauges: Option<usize>,
    /// What the first message has.
    first: Option<Found>,
    followed: Option<Followed>,
    /// Messages lost since the last frame.
    n_lost: u32,
    map: ClockMap,
    clock: ClockWords,
    rate: Rate,
    /// What was said last of messages that are refused, and when, ns.
    said: Option<(TopicFault, u64)>,
    stats: SourceStats,
}

/// A message as it came.
#[derive(Clone, Copy, Debug)]
pub struct Arrived<'a> {
    /// What its publisher says of it; none where that says nothing.
    pub numbered: Option<Numbered>,
    /// When it came, ns on the host's monotonic clock.
    pub arrival_ns: u64,
    /// CDR, with the four bytes that say how it is written.
    pub bytes: &'a [u8],
}

/// What a publisher says of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Numbered {
    /// Who it is.
    pub publisher: [u8; 16],
    /// Number of the message, one more for each.
    pub number: i64,
    /// When it was sent, ns since 1970 UTC.
    pub sent_ns: u64,
}

/// The publisher whose messages are read.
#[derive(Clone, Copy, Debug)]
struct Followed {
    publisher: [u8; 16],
    /// Number of the last message.
    number: i64,
    /// When that came, ns.
    heard_ns: u64,
}

impl TopicReader {
    /// A reader of messages of type `type_name`, whose definition is written as in an MCAP file (`ros2msg`).
    /// `topic` may name the list of numbers behind a point, `/joint_states.effort`; `n_gauges` is how many
    /// numbers without names there have to be.
    ///
    /// # Errors
    /// [`DaqError::NoDefinition`] for a definition that can't be read.
    pub fn new(
        topic: &str,
        type_name: &str,
        definition: &str,
        n_gauges: Option<usize>,
    ) -> Result<Self, DaqError> {
        let (name, field) = topic.split_once('.').map_or((topic, None), |(t, f)| (t, Some(f)));
        let message = Ros2Type::parse(type_name, definition).map_err(|message| {
            DaqError::NoDefinition { type_name: type_name.to_owned(), message }
        })?;
        Ok(Self {
            topic: name.to_owned(),
            field: field.map(str::to_owned),
            message,
            n_gauges,
            first: None,
            followed: None,
            n_lost: 0,
            map: ClockMap::new(),
            clock: ClockWords::default(),
            rate: Rate::default(),
            said: None,
            stats: SourceStats::default(),
        })
    }

    /// Takes a message: HELLO before the first frame, and the frame. What another publisher sends, and a message
    /// that is unlike the first, is left out, counted and now and then reported.
    ///
    /// # Errors
    /// The first message has no numbers for these gauges, so that no later one will.
    pub fn take(
        &mut self,
        arrived: &Arrived<'_>,
        sink: &mut dyn FnMut(Message),
    ) -> Result<(), TopicFault> {
        self.stats.n_bytes += arrived.bytes.len() as u64;
        if !self.follows(arrived, sink) {
            return Ok(());
        }
        let is_first = self.first.is_none();
        match self.read(arrived.bytes) {
            Ok((values, stamp_ns)) => {
                if is_first {
                    self.begin(sink)?;
                }
                let sent_ns = arrived.numbered.map(|numbered| numbered.sent_ns);
                let stamp_ns = stamp_ns.or(sent_ns.filter(|ns| *ns > 0));
                self.hand_out(&values, stamp_ns, arrived, sink);
                Ok(())
            }
            Err(message) if is_first => {
                Err(TopicFault::NoNumbers { topic: self.topic.clone(), message })
            }
            Err(message) => {
                self.leave_out(message, arrived.arrival_ns, sink);
                Ok(())
            }
        }
    }

    /// Counts a message that can't be read as lost, and says why, now and then.
    pub fn leave_out(&mut self, why: String, arrival_ns: u64, sink: &mut dyn FnMut(Message)) {
        self.n_lost = self.n_lost.saturating_add(1);
        self.stats.rejected.n_malformed += 1;
        let topic = self.topic.clone();
        self.say(TopicFault::Unlike { topic, message: why }, arrival_ns, sink);
    }

    /// What came so far.
    #[must_use]
    pub fn stats(&self) -> SourceStats {
        SourceStats {
            drift_ppm: self.map.drift_ppm().unwrap_or(0.0),
            clock_residual_us: self.map.residual_us(),
            ..self.stats
        }
    }

    /// Whether the message is the next one, or a later one, of the publisher that is followed.
    fn follows(&mut self, arrived: &Arrived<'_>, sink: &mut dyn FnMut(Message)) -> bool {
        let Some(Numbered { publisher, number, .. }) = arrived.numbered else {
            return true;
        };
        let now = Followed { publisher, number, heard_ns: arrived.arrival_ns };
        match self.followed {
            None => self.followed = Some(now),
            Some(before) if before.publisher == publisher => {
                let Some(n_missing) = missing(before.number, number) else {
                    self.count_old(before.number == number);
                    return false;
                };
                self.n_lost = self.n_lost.saturating_add(n_missing);
                self.followed = Some(now);
            }
            Some(before) if arrived.arrival_ns < before.heard_ns.saturating_add(TAKEOVER_NS) => {
                self.stats.rejected.n_schema += 1;
                let topic = self.topic.clone();
                self.say(TopicFault::Several { topic }, arrived.arrival_ns, sink);
                return false;
            }
            Some(_) => {
                self.followed = Some(now);
                self.map.restart();
                self.stats.losses.n_restarts += 1;
                sink(Message::Restarted);
            }
        }
        true
    }

    fn count_old(&mut self, is_repeat: bool) {
        let rejected = &mut self.stats.rejected;
        let count = if is_repeat { &mut rejected.n_repeats } else { &mut rejected.n_backwards };
        *count += 1;
    }

    /// The numbers of a message, and the time in its header, ns since 1970 UTC.
    fn read(&mut self, bytes: &[u8]) -> Result<(Vec<f64>, Option<u64>), String> {
        let message = self.message.read(bytes)?;
        let found = numbers(&message, self.field.as_deref())?;
        check_n(found.values.len())?;
        Ok((same_as_first(&mut self.first, found)?, message.stamp_ns()))
    }

    /// Says what the device is, where it has these gauges.
    fn begin(&self, sink: &mut dyn FnMut(Message)) -> Result<(), TopicFault> {
        let found = self.first.as_ref().map_or(0, |first| first.values.len());
        let has_names = self.first.as_ref().is_some_and(|first| first.names.is_some());
        // By their names gauges may be some of the numbers.
        let is_other = |expected: &usize| found < *expected || (found > *expected && !has_names);
        if let Some(expected) = self.n_gauges.filter(is_other) {
            return Err(TopicFault::OtherChannels { topic: self.topic.clone(), expected, found });
        }
        sink(Message::Hello(Arc::new(hello(self.first.as_ref(), 0))));
        Ok(())
    }

    fn hand_out(
        &mut self,
        values: &[f64],
        stamp_ns: Option<u64>,
        arrived: &Arrived<'_>,
        sink: &mut dyn FnMut(Message),
    ) {
        let n_frames = self.stats.n_frames;
        let number = arrived.numbered.map_or(n_frames.cast_signed(), |numbered| numbered.number);
        let mut frame = frame(number as u32, values);
        frame.n_lost_before = std::mem::take(&mut self.n_lost);
        self.time(&mut frame, stamp_ns, arrived.arrival_ns, sink);
        self.stats.n_frames += 1;
        self.stats.losses.n_delivered += 1;
        self.stats.losses.n_lost += u64::from(frame.n_lost_before);
        if let Some(rate_hz) = self.rate.count(self.stats.n_frames, arrived.arrival_ns) {
            self.stats.rate_hz = rate_hz;
        }
        sink(Message::Frame(frame));
    }

    fn time(
        &mut self,
        frame: &mut Frame,
        stamp_ns: Option<u64>,
        arrival_ns: u64,
        sink: &mut dyn FnMut(Message),
    ) {
        let Some(stamp_ns) = stamp_ns else {
            (frame.t_device_us, frame.t_host_ns) = (arrival_ns / 1000, arrival_ns);
            return;
        };
        frame.t_device_us = stamp_ns / 1000;
        frame.t_host_ns = self.map.map(frame.t_device_us, arrival_ns);
        self.clock.complain(&self.map, arrival_ns, sink);
        if self.map.fault().is_some() {
            frame.flags = frame.flags.union(FrameFlags::HOST_TIME);
            self.stats.n_host_time += 1;
        }
    }

    /// Says why messages are refused, now and then.
    fn say(&mut self, fault: TopicFault, now_ns: u64, sink: &mut dyn FnMut(Message)) {
        let kind = std::mem::discriminant(&fault);
        let is_said = self.said.as_ref().is_some_and(|(before, at_ns)| {
            std::mem::discriminant(before) == kind && now_ns.saturating_sub(*at_ns) < PAUSE_NS
        });
        if !is_said {
            self.said = Some((fault.clone(), now_ns));
            sink(Message::Link(LinkState::Topic(fault)));
        }
    }
}

/// Messages between two numbers; none where the second does not come after the first.
fn missing(before: i64, number: i64) -> Option<u32> {
    let step = number.checked_sub(before).filter(|step| *step > 0)?;
    Some(u32::try_from(step - 1).unwrap_or(u32::MAX))
}
