//! From frames of the runtime to frames of the page.

use std::sync::Arc;

use anyhow::Result;
use hapdef_daq::record::PlayerControl;
use hapdef_live::{Health, LiveFrame, PhaseStatus, Touch};
use hapdef_rig::live::TrueContact;
use hapdef_view::{
    ContactMark, Displacement, Ranges, Recording, ReplayPosition, ViewFrame, ViewPusher,
};

use super::Shared;
use super::picture::Surface;
use crate::cli::live_record::LiveRecorderState;

/// Delays that the shown quantiles come from.
const N_DELAYS: usize = 256;

/// Makes frames of the page and pushes them.
pub(super) struct Show {
    pusher: ViewPusher,
    surface: Surface,
    shared: Arc<Shared>,
    player: Option<PlayerControl>,
    shown: ViewFrame,
    is_paused: bool,
    first_ns: Option<u64>,
    delays_us: Vec<f64>,
    n_delays: usize,
    sum_m: Vec<[f32; 3]>,
}

impl Show {
    /// Frames of a recording have no delay that could be shown, but a place in it: `player` knows
    /// that.
    pub(super) fn new(
        pusher: ViewPusher,
        surface: Surface,
        shared: Arc<Shared>,
        player: Option<PlayerControl>,
    ) -> Self {
        Self {
            sum_m: vec![[0.0; 3]; surface.n_nodes()],
            pusher,
            surface,
            shared,
            player,
            shown: ViewFrame::default(),
            is_paused: false,
            first_ns: None,
            delays_us: Vec::with_capacity(N_DELAYS),
            n_delays: 0,
        }
    }

    /// Takes a frame, and the ranges of those since the one that was shown before; its time on the page, s.
    pub(super) fn take(&mut self, frame: &LiveFrame, ranges: &Ranges) -> f64 {
        self.take_time(frame);
        self.take_readings(frame);
        self.take_touch(&frame.touch);
        self.shown.show_ranges(ranges);
        self.take_phase(frame);
        self.deform(&frame.touch);
        self.take_delay(frame);
        self.shown.t_s
    }

    /// Takes what truly pressed when the frame was sampled.
    pub(super) fn take_truth(&mut self, contacts: &[TrueContact]) {
        self.shown.truths.clear();
        let mark = |contact: &TrueContact| {
            let contact = contact.contact();
            ContactMark::new(contact, self.surface.normal_at(&contact.position_m))
        };
        let marks = contacts.iter().map(mark);
        self.shown.truths.extend(marks);
    }

    /// Nothing is known any more of what was taken: the device is away.
    pub(super) fn lose(&mut self) {
        self.shown.readings_ue.fill(f64::NAN);
        self.shown.ranges_ue.clear();
        self.shown.truths.clear();
        self.take_touch(&Touch::default());
        self.deform(&Touch::default());
    }

    pub(super) fn take_health(&mut self, health: &Health) {
        self.shown.health.rate_hz = health.rate_hz;
        self.shown.health.n_lost = health.n_lost;
        self.shown.health.n_dropped = health.n_dropped;
        self.shown.health.n_crc_errors = health.source.rejected.n_damaged;
        let residual_us = health.source.clock_residual_us;
        self.shown.health.clock_residual_us = residual_us.unwrap_or(f64::NAN);
    }

    pub(super) fn take_recording(&mut self, state: &LiveRecorderState) {
        self.shown.health.recording = match *state {
            LiveRecorderState::Off => Recording::Off,
            LiveRecorderState::On { recorded_s } => Recording::On { recorded_s },
            LiveRecorderState::Failed { .. } => Recording::Failed,
        };
    }

    /// Whether the replay was stopped.
    pub(super) fn take_pause(&mut self, is_paused: bool) {
        self.is_paused = is_paused;
        if let Some(replay) = &mut self.shown.replay {
            replay.is_paused = is_paused;
        }
    }

    /// Whether there is a contact in what was taken, and whether the limb has its colours.
    pub(super) fn has_contact_and_colours(&self) -> (bool, bool) {
        let has_colours = self.shown.displacement != Displacement::None;
        (!self.shown.contacts.is_empty(), has_colours)
    }

    /// Shows what was taken; the frame's number.
    pub(super) fn push(&self) -> Result<u64> {
        Ok(self.pusher.push(&self.shown)?)
    }

    fn take_time(&mut self, frame: &LiveFrame) {
        let first_ns = *self.first_ns.get_or_insert(frame.t_host_ns);
        self.shown.t_s = frame.t_host_ns.saturating_sub(first_ns) as f64 * 1e-9;
        if let Some(player) = &self.player {
            let position_s = player.position_s(frame.t_host_ns);
            self.shown.t_s = position_s;
            self.shown.replay = Some(ReplayPosition {
                position_s,
                duration_s: player.duration_s(),
                is_paused: self.is_paused,
            });
        }
    }

    fn take_readings(&mut self, frame: &LiveFrame) {
        self.shown.readings_ue.clone_from(&frame.tared_ue);
        self.shown.gauge_health.clone_from(&frame.gauges);
    }

    fn take_phase(&mut self, frame: &LiveFrame) {
        self.shown.phase = frame.phase;
        self.shown.is_stale = frame.is_stale;
    }

    /// What is known while no frame comes.
    pub(super) fn take_silence(&mut self, status: PhaseStatus) {
        self.shown.phase = status.phase;
        self.shown.is_stale = status.is_stale;
        if status.n_contacts == 0 {
            self.take_touch(&Touch::default());
            self.deform(&Touch::default());
        }
    }

    fn take_touch(&mut self, touch: &Touch) {
        let surface = &self.surface;
        self.shown.show_touch(touch, |point| surface.normal_at(point));
    }

    fn deform(&mut self, touch: &Touch) {
        let Some(table) = self.shared.table.get() else {
            return;
        };
        self.sum_m.fill([0.0; 3]);
        for contact in &touch.contacts {
            for (node, weight) in self.surface.around(&contact.position_m) {
                table.add_displacement_m(node, weight * contact.force_n, &mut self.sum_m);
            }
        }
        if !matches!(self.shown.displacement, Displacement::Vector(_)) {
            self.shown.displacement = Displacement::Vector(Vec::new());
        }
        if let Displacement::Vector(shown) = &mut self.shown.displacement {
            self.surface.shown(&self.sum_m, shown);
        }
    }

    /// Quantiles of the delays from sample to contacts of the frames shown.
    fn take_delay(&mut self, frame: &LiveFrame) {
        if self.player.is_some() {
            return;
        }
        let delay_us = frame.t_done_ns.saturating_sub(frame.t_host_ns) as f64 * 1e-3;
        if self.delays_us.len() < N_DELAYS {
            self.delays_us.push(delay_us);
        } else {
            self.delays_us[self.n_delays % N_DELAYS] = delay_us;
        }
        self.n_delays += 1;
        let mut sorted = self.delays_us.clone();
        sorted.sort_by(f64::total_cmp);
        let at = |share: f64| sorted[((sorted.len() - 1) as f64 * share) as usize];
        self.shown.health.latency_p50_us = at(0.5);
        self.shown.health.latency_p99_us = at(0.99);
    }
}
