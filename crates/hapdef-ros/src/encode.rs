//! Plain structs to messages of all topics.

use hapdef_contact::{Touch, UnknownReason, printable};
use nalgebra::Point3;
use serde::Serialize;

use crate::cdr::to_cdr;
use crate::error::RosError;
use crate::frames::frame_of;
use crate::input::{Health, Known, Readings};
use crate::markers::markers;
use crate::msg::{
    Alternative, Contact, Contacts, DiagnosticArray, DiagnosticStatus, Gauges, Header, KeyValue,
    Status, TfMessage, Time, Transform, TransformStamped, Wrench, WrenchStamped,
};
use crate::robot_board::RobotBoard;
use crate::sink::MessageSink;
use crate::slots::{Slot, Slots};
use crate::topics::{RosParams, TopicKind};

/// Makes messages and hands them to a sink; messages of topics that the sink does not want are not
/// made.
pub struct RosEncoder<S> {
    params: RosParams,
    sink: S,
    slots: Slots,
    /// Slots whose last markers show a contact.
    drawn: Vec<bool>,
    next_markers_ns: u64,
    /// Where the contacts of all limbs are, and this limb's number there.
    board: Option<(RobotBoard, usize)>,
}

impl<S: MessageSink> RosEncoder<S> {
    /// # Errors
    /// A parameter that is out of range.
    pub fn new(params: RosParams, sink: S) -> Result<Self, RosError> {
        params.check()?;
        Ok(Self {
            slots: Slots::new(params.n_slots),
            drawn: vec![false; params.n_slots],
            params,
            sink,
            next_markers_ns: 0,
            board: None,
        })
    }

    /// The same for limb number `limb` of a robot, whose other limbs leave their contacts on the same board: with
    /// [`RosParams::robot`] the topic of all limbs is said, too, by whichever limb has a reading when it is time.
    #[must_use]
    pub fn beside(self, board: RobotBoard, limb: usize) -> Self {
        Self { board: Some((board, limb)), ..self }
    }

    /// A reading, on the topic of gauges.
    ///
    /// # Errors
    /// It can't be encoded.
    pub fn readings(&mut self, readings: &Readings<'_>) -> Result<(), RosError> {
        self.put(TopicKind::Gauges, readings.stamp_ns, |this| Gauges {
            header: this.header(readings.stamp_ns),
            seq: readings.seq,
            lost_before: readings.n_lost_before,
            microstrain: readings.microstrain.to_vec(),
        })
    }

    /// The contacts behind reading `seq` of the instant `stamp_ns`, ns since 1970 UTC: as such, as
    /// wrenches, frames and, so often a second as the parameters say, markers. A contact whose normal is
    /// not known has no wrench, frame and markers.
    ///
    /// # Errors
    /// They can't be encoded.
    pub fn contacts(&mut self, stamp_ns: u64, seq: u32, touch: &Touch) -> Result<(), RosError> {
        self.put(TopicKind::Contacts, stamp_ns, |this| this.list(stamp_ns, seq, touch))?;
        self.of_all(stamp_ns, seq, touch)?;
        self.held(stamp_ns, touch)
    }

    /// The net wrench of contacts that a controller may act on, about the origin of the limb's frame and about its
    /// mount. Contacts of which one has no known normal have none.
    ///
    /// # Errors
    /// It can't be encoded.
    pub fn net_wrench(
        &mut self,
        stamp_ns: u64,
        contacts: &[hapdef_contact::Contact],
    ) -> Result<(), RosError> {
        let Some(net) = hapdef_contact::Wrench::of(contacts, Point3::origin()) else {
            return Ok(());
        };
        self.put(TopicKind::NetWrench, stamp_ns, |this| WrenchStamped {
            header: this.header(stamp_ns),
            wrench: net.into(),
        })?;
        let Some(mount_m) = self.params.mount_m else {
            return Ok(());
        };
        if !contacts.is_empty() {
            self.put(TopicKind::Transforms, stamp_ns, |this| TfMessage {
                transforms: vec![TransformStamped {
                    header: this.header(stamp_ns),
                    child_frame_id: this.params.mount_frame(),
                    transform: Transform { translation: mount_m.into(), ..Transform::default() },
                }],
            })?;
        }
        self.put(TopicKind::MountWrench, stamp_ns, |this| WrenchStamped {
            header: Header { frame_id: this.params.mount_frame(), ..this.header(stamp_ns) },
            wrench: net.about(mount_m.into()).into(),
        })
    }

    /// Lets go what was held, without a reading: wrenches are zero and markers go; no list says that nothing
    /// touches.
    ///
    /// # Errors
    /// It can't be encoded.
    pub fn release(&mut self, stamp_ns: u64) -> Result<(), RosError> {
        self.leave();
        self.held(stamp_ns, &Touch::default())
    }

    /// The limb says no more for now: what is said of all limbs goes on without it.
    pub fn leave(&self) {
        if let Some((board, limb)) = &self.board {
            board.leave_out(*limb);
        }
    }

    /// What is known to touch at that reading, from a simulated rig.
    ///
    /// # Errors
    /// It can't be encoded.
    pub fn truth(&mut self, stamp_ns: u64, seq: u32, touch: &Touch) -> Result<(), RosError> {
        self.put(TopicKind::Truth, stamp_ns, |this| this.list(stamp_ns, seq, touch))
    }

    /// Whether contacts can be known.
    ///
    /// # Errors
    /// It can't be encoded.
    pub fn status(&mut self, known: &Known) -> Result<(), RosError> {
        let Known { stamp_ns, phase, is_stale, .. } = *known;
        self.put(TopicKind::Status, stamp_ns, |this| Status {
            header: this.header(stamp_ns),
            is_known: phase.is_known() && !is_stale,
            phase: phase.word().to_owned(),
            why_unknown: phase.why_unknown().map_or("", UnknownReason::word).to_owned(),
            is_stale,
            contacts: known.n_contacts as u32,
            smallest_seen_force: known.smallest_seen_n.unwrap_or(f64::NAN),
        })
    }

    /// How parts are doing: one message for all of them.
    ///
    /// # Errors
    /// It can't be encoded.
    pub fn health(&mut self, parts: &[Health]) -> Result<(), RosError> {
        let stamp_ns = parts.iter().map(|part| part.stamp_ns).max().unwrap_or(0);
        self.put(TopicKind::Diagnostics, stamp_ns, |this| DiagnosticArray {
            header: Header { frame_id: String::new(), ..this.header(stamp_ns) },
            status: parts.iter().map(status).collect(),
        })
    }

    /// The sink.
    pub fn sink(&mut self) -> &mut S {
        &mut self.sink
    }

    /// The contacts of all limbs of the robot, where it is one and it is time for them.
    fn of_all(&mut self, stamp_ns: u64, seq: u32, touch: &Touch) -> Result<(), RosError> {
        let Some((board, limb)) = &self.board else {
            return Ok(());
        };
        let Some(message) = board.put(*limb, stamp_ns, self.list(stamp_ns, seq, touch)) else {
            return Ok(());
        };
        self.put(TopicKind::RobotContacts(self.params.n_slots), stamp_ns, |_| message)
    }

    /// Frames, wrenches and markers of what is held.
    fn held(&mut self, stamp_ns: u64, touch: &Touch) -> Result<(), RosError> {
        let placed = self.slots.place(&touch.contacts);
        self.transforms(stamp_ns, &placed)?;
        for (slot, held) in placed.iter().enumerate() {
            self.wrench(stamp_ns, slot, held)?;
        }
        self.markers(stamp_ns, &placed)
    }

    fn put<T: Serialize>(
        &mut self,
        topic: TopicKind,
        stamp_ns: u64,
        message: impl FnOnce(&Self) -> T,
    ) -> Result<(), RosError> {
        if self.sink.wants(topic) {
            let bytes = to_cdr(&message(self))?;
            self.sink.put(topic, stamp_ns, &bytes);
        }
        Ok(())
    }

    fn header(&self, stamp_ns: u64) -> Header {
        Header { stamp: Time::from_ns(stamp_ns), frame_id: self.params.frame_id.clone() }
    }

    fn list(&self, stamp_ns: u64, seq: u32, touch: &Touch) -> Contacts {
        let quality = touch.quality;
        Contacts {
            header: self.header(stamp_ns),
            seq,
            has_quality: quality.is_some(),
            is_identified: quality.is_some_and(|q| q.is_identified()),
            p_value: quality.map_or(0.0, |q| q.p_value),
            contacts: touch.contacts.iter().enumerate().map(Contact::of).collect(),
            alternatives: touch.alternatives.iter().map(Alternative::from).collect(),
        }
    }

    /// A contact's wrench in its own frame: it pushes against the normal. Zero, once, when it goes.
    fn wrench(&mut self, stamp_ns: u64, slot: usize, held: &Slot<'_>) -> Result<(), RosError> {
        let force_n = match held {
            Slot::Held(contact) => contact.force_n,
            Slot::Left => 0.0,
            Slot::Free => return Ok(()),
        };
        self.put(TopicKind::Wrench(slot), stamp_ns, |this| WrenchStamped {
            header: Header { frame_id: this.params.contact_frame(slot), ..this.header(stamp_ns) },
            wrench: Wrench { force: [0.0, 0.0, -force_n].into(), ..Wrench::default() },
        })
    }

    /// The frames of the contacts.
    fn transforms(&mut self, stamp_ns: u64, placed: &[Slot<'_>]) -> Result<(), RosError> {
        if !placed.iter().any(|slot| matches!(slot, Slot::Held(_))) {
            return Ok(());
        }
        self.put(TopicKind::Transforms, stamp_ns, |this| {
            let held = placed.iter().enumerate().filter_map(|(slot, held)| {
                let Slot::Held(contact) = held else {
                    return None;
                };
                let along = contact.uncertainty.map(|u| u.tangents[0]);
                let normal = contact.normal()?;
                Some(TransformStamped {
                    header: this.header(stamp_ns),
                    child_frame_id: this.params.contact_frame(slot),
                    transform: Transform {
                        translation: contact.position_m.coords.into(),
                        rotation: frame_of(normal, along).rotation(),
                    },
                })
            });
            TfMessage { transforms: held.collect() }
        })
    }

    fn markers(&mut self, stamp_ns: u64, placed: &[Slot<'_>]) -> Result<(), RosError> {
        let is_due = stamp_ns >= self.next_markers_ns;
        let held = |slot: &Slot<'_>| matches!(slot, Slot::Held(_));
        let drawn = self.drawn.iter().zip(placed);
        // What is gone is taken away at once, also where it went between two drawings.
        let gone: Vec<Slot<'_>> =
            drawn.map(|(&was, slot)| if was && !held(slot) { Slot::Left } else { *slot }).collect();
        let has_gone = gone.contains(&Slot::Left);
        let has_any = has_gone || placed.iter().any(held);
        if !has_any || !(is_due || has_gone) {
            return Ok(());
        }
        self.drawn = placed.iter().map(held).collect();
        self.next_markers_ns = stamp_ns + (1e9 / self.params.marker_hz) as u64;
        self.put(TopicKind::Markers, stamp_ns, |this| {
            markers(&this.params, &this.header(stamp_ns), &gone)
        })
    }
}

fn status(part: &Health) -> DiagnosticStatus {
    let values = part
        .values
        .iter()
        .map(|(key, value)| KeyValue { key: printable(key), value: printable(value) });
    DiagnosticStatus {
        level: part.level as u8,
        name: printable(&part.name),
        message: printable(&part.message),
        hardware_id: printable(&part.hardware_id),
        values: values.collect(),
    }
}
