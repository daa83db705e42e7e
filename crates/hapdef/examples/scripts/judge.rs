//! What was seen beside what pressed.

use std::fmt::{self, Display, Formatter};

use hapdef_bench::stats;
use hapdef_live::{LiveFrame, TouchPhase, UnknownReason};
use hapdef_rig::live::TrueContact;
use nalgebra::Point3;

use crate::causes::{BEGUN_N, Causes, Diagnosis, NEAR_M};

/// Presses that are gone sooner than this are hits, whose lag is not asked, ms.
const LEAST_MS: u64 = 200;

/// Frames and lags of scripts; a frame is a millisecond.
#[derive(Clone, Debug, Default)]
pub(crate) struct Seen {
    pub(crate) n_frames: u64,
    /// Frames with a contact beyond the range.
    pub(crate) n_beyond: u64,
    /// Frames that no contacts explain.
    n_misfit: u64,
    pub(crate) longest_misfit_ms: u64,
    /// From when a press begins until it is reported.
    pub(crate) detect_ms: Samples,
    /// From when it is over until nothing is reported there.
    pub(crate) let_go_ms: Samples,
    /// From each contact that is reported to the nearest press, mm.
    pub(crate) off_mm: Samples,
    /// Contacts that are reported of more than a press begins with, and farther than one is taken for from any.
    n_ghosts: u64,
    /// Why frames are misfits.
    pub(crate) causes: Causes,
}

/// Numbers; the lag of what never ended is infinite.
#[derive(Clone, Debug, Default)]
pub(crate) struct Samples(Vec<f64>);

/// Judges the frames of one script.
pub(crate) struct Judge {
    range_n: f64,
    seen: Seen,
    misfit_ms: u64,
    presses: Vec<Press>,
    diagnosis: Diagnosis,
}

/// A press that is there, or whose end is waited for.
struct Press {
    id: u32,
    place: Point3<f64>,
    begun_ms: u64,
    /// When it was reported.
    lag_ms: Option<u64>,
    over_ms: Option<u64>,
}

impl Judge {
    pub(crate) fn new(range_n: f64) -> Self {
        let (seen, diagnosis) = (Seen::default(), Diagnosis::default());
        Self { range_n, seen, misfit_ms: 0, presses: Vec::new(), diagnosis }
    }

    /// Takes a frame and what presses in it.
    pub(crate) fn take(&mut self, pressed: &[TrueContact], frame: &LiveFrame) {
        if frame.phase == TouchPhase::Taring {
            return;
        }
        let seen = &mut self.seen;
        seen.n_frames += 1;
        let is_beyond = frame.touch.contacts.iter().any(|c| c.force_n > self.range_n);
        seen.n_beyond += u64::from(is_beyond);
        let is_misfit = frame.phase == TouchPhase::Unknown(UnknownReason::Misfit);
        seen.n_misfit += u64::from(is_misfit);
        self.misfit_ms = if is_misfit { self.misfit_ms + 1 } else { 0 };
        seen.longest_misfit_ms = seen.longest_misfit_ms.max(self.misfit_ms);
        self.diagnosis.take(seen.n_frames, pressed, frame, is_misfit);
        let strong =
            frame.known_contacts().unwrap_or_default().iter().filter(|c| c.force_n > BEGUN_N);
        for contact in strong {
            let far = pressed.iter().map(|p| (p.position_m - contact.position_m).norm());
            let off_m = far.fold(f64::INFINITY, f64::min);
            seen.n_ghosts += u64::from(off_m > NEAR_M);
            seen.off_mm.add(off_m * 1e3);
        }
        self.follow(pressed, frame);
    }

    fn follow(&mut self, pressed: &[TrueContact], frame: &LiveFrame) {
        let now_ms = self.seen.n_frames;
        let is_strong = |c: &&TrueContact| c.force_n >= BEGUN_N;
        for contact in pressed.iter().filter(is_strong) {
            let known = self.presses.iter_mut().find(|p| p.id == contact.id && p.over_ms.is_none());
            match known {
                Some(press) => press.place = contact.position_m,
                None => self.presses.push(Press {
                    id: contact.id,
                    place: contact.position_m,
                    begun_ms: now_ms,
                    lag_ms: None,
                    over_ms: None,
                }),
            }
        }
        let found = frame.known_contacts().ok();
        let is_there = |place: &Point3<f64>| {
            let near = |c: &hapdef_live::Contact| (c.position_m - place).norm() < NEAR_M;
            found.map(|found| found.iter().any(near))
        };
        let places: Vec<Point3<f64>> = pressed.iter().map(|c| c.position_m).collect();
        let seen = &mut self.seen;
        self.presses.retain_mut(|press| {
            let is_there = is_there(&press.place);
            if press.lag_ms.is_none() && is_there == Some(true) {
                press.lag_ms = Some(now_ms - press.begun_ms);
            }
            let is_pressed = pressed.iter().any(|c| c.id == press.id && c.force_n >= BEGUN_N);
            if is_pressed {
                return true;
            }
            let over_ms = *press.over_ms.get_or_insert(now_ms);
            let is_hit = over_ms - press.begun_ms < LEAST_MS;
            let is_covered = places.iter().any(|x| (x - press.place).norm() < 2.0 * NEAR_M);
            if is_there == Some(false) || is_hit || (is_covered && now_ms > over_ms + LEAST_MS) {
                if !is_hit {
                    seen.detect_ms.0.push(press.lag_ms.map_or(f64::INFINITY, |lag| lag as f64));
                    if !is_covered {
                        seen.let_go_ms.0.push((now_ms - over_ms) as f64);
                    }
                }
                return false;
            }
            true
        });
    }

    /// All that was seen; what should be gone by now and is reported was never let go.
    pub(crate) fn end(&mut self) -> Seen {
        let mut seen = std::mem::take(&mut self.seen);
        seen.causes = self.diagnosis.end();
        let now_ms = seen.n_frames;
        let is_stuck = |press: &&Press| press.over_ms.is_some_and(|over| now_ms > over + 1000);
        let n_stuck = self.presses.iter().filter(is_stuck).count();
        seen.let_go_ms.0.extend(std::iter::repeat_n(f64::INFINITY, n_stuck));
        seen
    }
}

impl Seen {
    /// Adds what was seen of another script or limb.
    pub(crate) fn add(&mut self, more: Self) {
        let (n_frames, n_misfit) = (self.n_frames, self.n_misfit);
        self.n_frames = n_frames + more.n_frames;
        self.n_misfit = n_misfit + more.n_misfit;
        self.n_beyond += more.n_beyond;
        self.longest_misfit_ms = self.longest_misfit_ms.max(more.longest_misfit_ms);
        self.detect_ms.0.extend(more.detect_ms.0);
        self.let_go_ms.0.extend(more.let_go_ms.0);
        self.off_mm.0.extend(more.off_mm.0);
        self.n_ghosts += more.n_ghosts;
        self.causes.add(&more.causes);
    }

    /// Share of the contacts reported that are none, %.
    pub(crate) fn ghosts_pct(&self) -> f64 {
        100.0 * self.n_ghosts as f64 / self.off_mm.0.len().max(1) as f64
    }

    /// Share of the frames that no contacts explain, %.
    pub(crate) fn misfit_pct(&self) -> f64 {
        100.0 * self.n_misfit as f64 / self.n_frames.max(1) as f64
    }
}

impl Display for Seen {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let ([detect_50, detect_99], [go_50, go_99]) =
            (self.detect_ms.quantiles(), self.let_go_ms.quantiles());
        let [off_50, off_99] = self.off_mm.quantiles();
        write!(
            f,
            "{} frames, {} beyond the range, {:.3} % misfits, the longest {} ms; reported after {detect_50}, \
             99 % {detect_99} ms; let go after {go_50}, 99 % {go_99} ms of {} presses; contacts are {off_50:.2}, 99 % \
             {off_99:.2} mm off, {:.3} % are none",
            self.n_frames,
            self.n_beyond,
            self.misfit_pct(),
            self.longest_misfit_ms,
            self.detect_ms.0.len(),
            self.ghosts_pct(),
        )
    }
}

impl Samples {
    pub(crate) fn add(&mut self, lag_ms: f64) {
        self.0.push(lag_ms);
    }

    /// Share of at most so much, %.
    pub(crate) fn within_pct(&self, most: f64) -> f64 {
        let n = self.0.iter().filter(|number| **number <= most).count();
        100.0 * n as f64 / self.0.len().max(1) as f64
    }

    /// Median and 99 %.
    pub(crate) fn quantiles(&self) -> [f64; 2] {
        let rising = stats::sorted(self.0.iter().copied());
        [0.5, 0.99].map(|q| stats::quantile(&rising, q))
    }
}
