//! A frame on its way: what was read, what it means.

use hapdef_contact::{Contact, GaugeHealth, Touch, TouchPhase, Wrench};
use hapdef_daq::hdp1::FrameFlags;
use nalgebra::Point3;

use crate::signals::LoadSignal;

/// One frame with everything that was found in it. What no sink wants is not computed and is as it
/// is in an empty frame.
#[derive(Clone, Debug, PartialEq)]
pub struct LiveFrame {
    /// Number of its packet.
    pub seq: u32,
    /// Its place in the packet.
    pub scan: u8,
    /// What the device says about its packet.
    pub flags: FrameFlags,
    /// Packets missing directly before it: lost on the link or dropped by the device.
    pub n_lost_before: u32,
    /// Frames directly before it that were dropped because the computing thread was too slow.
    pub n_dropped_before: u32,
    /// Frames directly before it that this sink was not shown because it was too slow.
    pub n_skipped_before: u32,
    /// Device time of the sample instant, µs.
    pub t_device_us: u64,
    /// Host time of the sample instant, ns, on the clock of [`hapdef_daq::clock::HostClock`].
    pub t_host_ns: u64,
    /// Host time when its contacts were ready, ns, on the same clock; of a recording the sample instant.
    pub t_done_ns: u64,
    /// Readings as they came `[n_gauges]`, µε.
    pub raw_ue: Vec<f64>,
    /// Readings less tare, drift, temperature and creep `[n_gauges]`, µε; 0 for gauges that don't
    /// count and while taring.
    pub tared_ue: Vec<f64>,
    /// Why gauges don't count `[n_gauges]`.
    pub gauges: Vec<GaugeHealth>,
    /// Whether it is taring, whether something touches, and whether that can be known.
    pub phase: TouchPhase,
    /// The contacts are not this frame's but the last ones that were explained, or the frame itself is old.
    pub is_stale: bool,
    /// The smallest force, N, that the gauges that count would show in one frame wherever it pressed, where
    /// the estimator knows; infinite where none would.
    pub smallest_seen_n: Option<f64>,
    /// Value of the first temperature channel, in its unit, where the device has one.
    pub temperature: Option<f64>,
    /// What else the device measures of how the whole limb is loaded, as it came.
    pub signals: Vec<(LoadSignal, f64)>,
    /// The contacts; none while taring, and in a frame that was refused.
    pub touch: Touch,
}

impl LiveFrame {
    /// The contacts, or none, where a controller may act on them; else the phase that says why not:
    /// taring, or unknown with its reason.
    ///
    /// # Errors
    /// The phase.
    pub fn known_contacts(&self) -> Result<&[Contact], TouchPhase> {
        if self.phase.is_known() && !self.is_stale {
            Ok(&self.touch.contacts)
        } else {
            Err(self.phase)
        }
    }

    /// The net wrench of the contacts about a point of the limb's frame, m; `None` where a contact's direction is not
    /// known.
    #[must_use]
    pub fn wrench(&self, about_m: Point3<f64>) -> Option<Wrench> {
        Wrench::of(&self.touch.contacts, about_m)
    }

    /// An empty frame of that many gauges.
    #[must_use]
    pub fn new(n_gauges: usize) -> Self {
        Self {
            seq: 0,
            scan: 0,
            flags: FrameFlags::default(),
            n_lost_before: 0,
            n_dropped_before: 0,
            n_skipped_before: 0,
            t_device_us: 0,
            t_host_ns: 0,
            t_done_ns: 0,
            raw_ue: vec![0.0; n_gauges],
            tared_ue: vec![0.0; n_gauges],
            gauges: vec![GaugeHealth::Good; n_gauges],
            phase: TouchPhase::Untouched,
            is_stale: false,
            smallest_seen_n: None,
            temperature: None,
            signals: Vec::new(),
            touch: Touch::with_room(),
        }
    }

    /// Takes over everything; allocates only to grow.
    pub fn copy_from(&mut self, from: &Self) {
        self.seq = from.seq;
        self.scan = from.scan;
        self.flags = from.flags;
        self.n_lost_before = from.n_lost_before;
        self.n_dropped_before = from.n_dropped_before;
        self.n_skipped_before = from.n_skipped_before;
        self.t_device_us = from.t_device_us;
        self.t_host_ns = from.t_host_ns;
        self.t_done_ns = from.t_done_ns;
        self.raw_ue.clone_from(&from.raw_ue);
        self.tared_ue.clone_from(&from.tared_ue);
        self.gauges.clone_from(&from.gauges);
        self.phase = from.phase;
        (self.is_stale, self.smallest_seen_n) = (from.is_stale, from.smallest_seen_n);
        self.temperature = from.temperature;
        self.signals.clone_from(&from.signals);
        self.touch.copy_from(&from.touch);
    }

    /// What a viewer misses that is not shown this frame.
    pub(crate) fn left_out(&self) -> Missed {
        Missed {
            n_lost: self.n_lost_before,
            n_dropped: self.n_dropped_before,
            n_skipped: self.n_skipped_before.saturating_add(1),
        }
    }

    /// Adds what was missed before it.
    pub(crate) fn add_missed(&mut self, missed: Missed) {
        self.n_lost_before = self.n_lost_before.saturating_add(missed.n_lost);
        self.n_dropped_before = self.n_dropped_before.saturating_add(missed.n_dropped);
        self.n_skipped_before = self.n_skipped_before.saturating_add(missed.n_skipped);
    }
}

/// Frames that a viewer does not see.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Missed {
    n_lost: u32,
    n_dropped: u32,
    n_skipped: u32,
}

impl Missed {
    /// Adds what else is missed.
    pub(crate) fn add(&mut self, more: Self) {
        self.n_lost = self.n_lost.saturating_add(more.n_lost);
        self.n_dropped = self.n_dropped.saturating_add(more.n_dropped);
        self.n_skipped = self.n_skipped.saturating_add(more.n_skipped);
    }
}
