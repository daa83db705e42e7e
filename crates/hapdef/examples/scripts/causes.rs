//! Why frames are misfits: what of the contacts believed is wrong in them.

use std::fmt::{self, Display, Formatter};

use hapdef_live::{Contact, LiveFrame};
use hapdef_rig::live::TrueContact;

/// A contact that is reported this near to a press is it, m.
pub(crate) const NEAR_M: f64 = 0.015;

/// A press has begun, or is over, at this force, N: it is born with more, and let go below it.
pub(crate) const BEGUN_N: f64 = 0.5;

/// A press that began less than this ago may still be looked for, ms: two decisions of a detection window.
const NEW_MS: u64 = 8;
/// A place that is off by more than this is wrong, though it is the press', m.
const OFF_M: f64 = 3e-3;
/// A press that moves faster slides, m/s.
const SLIDES_M_PER_S: f64 = 5e-3;

/// What is wrong in a frame, the first that holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Cause {
    /// A press has just begun.
    New,
    /// Two and more have, within twice that time.
    NewTogether,
    /// A press that lasts is not reported.
    Missing,
    /// A contact is reported where nothing presses.
    Ghost,
    /// A press is reported in a place that is off, and slides.
    OffSliding,
    /// The same, and it does not slide.
    Off,
    /// All are where they press, one of them slides.
    Sliding,
    /// All are where they press.
    Right,
}

const CAUSES: [(Cause, &str); 8] = [
    (Cause::New, "a press began within 8 ms"),
    (Cause::NewTogether, "two began within 16 ms"),
    (Cause::Missing, "a press is missing"),
    (Cause::Ghost, "a contact is none"),
    (Cause::OffSliding, "a sliding press is 3 mm off"),
    (Cause::Off, "a press is 3 mm off"),
    (Cause::Sliding, "all right, one slides"),
    (Cause::Right, "all right"),
];

/// Misfit frames by cause.
#[derive(Clone, Debug, Default)]
pub(crate) struct Causes {
    n_frames: [u64; CAUSES.len()],
    /// Misfits in a row, by the cause of the first.
    n_rows: [u64; CAUSES.len()],
    /// The longest of them, ms.
    longest_ms: [u64; CAUSES.len()],
}

/// Tells causes, frame after frame.
#[derive(Clone, Debug, Default)]
pub(crate) struct Diagnosis {
    before: Vec<(TrueContact, u64)>,
    row: Option<(usize, u64)>,
    causes: Causes,
}

impl Diagnosis {
    /// Takes frame `now_ms`, what presses in it, and whether it is a misfit.
    pub(crate) fn take(
        &mut self,
        now_ms: u64,
        pressed: &[TrueContact],
        frame: &LiveFrame,
        is_misfit: bool,
    ) {
        let begun = |p: &TrueContact| {
            let known = self.before.iter().find(|(old, _)| old.id == p.id);
            known.map_or(
                now_ms,
                |(old, begun)| if old.force_n < 0.5 * BEGUN_N { now_ms } else { *begun },
            )
        };
        let now: Vec<(TrueContact, u64)> = pressed.iter().map(|p| (*p, begun(p))).collect();
        if is_misfit {
            let cause = self.cause(now_ms, &now, &frame.touch.contacts);
            let i = CAUSES.iter().position(|(c, _)| *c == cause).unwrap_or_default();
            self.causes.n_frames[i] += 1;
            let (first, n) = self.row.map_or((i, 1), |(first, n)| (first, n + 1));
            self.row = Some((first, n));
            self.causes.n_rows[first] += u64::from(n == 1);
            self.causes.longest_ms[first] = self.causes.longest_ms[first].max(n);
        } else {
            self.row = None;
        }
        self.before = now;
    }

    fn cause(&self, now_ms: u64, pressed: &[(TrueContact, u64)], found: &[Contact]) -> Cause {
        let off = |p: &TrueContact| {
            let far = found.iter().map(|c| (c.position_m - p.position_m).norm());
            far.fold(f64::INFINITY, f64::min)
        };
        let strong = || pressed.iter().filter(|(p, _)| p.force_n >= 0.5 * BEGUN_N);
        let missing = || strong().filter(|(p, _)| off(p) > NEAR_M);
        let n_new = |ms| strong().filter(|(_, begun)| now_ms - begun < ms).count();
        if missing().any(|(_, begun)| now_ms - begun < 2 * NEW_MS) && n_new(2 * NEW_MS) > 1 {
            return Cause::NewTogether;
        }
        if missing().any(|(_, begun)| now_ms - begun < NEW_MS) {
            return Cause::New;
        }
        if missing().next().is_some() {
            return Cause::Missing;
        }
        let is_ghost = |c: &Contact| {
            pressed.iter().all(|(p, _)| (p.position_m - c.position_m).norm() > NEAR_M)
        };
        if found.iter().any(|c| c.force_n > BEGUN_N && is_ghost(c)) {
            return Cause::Ghost;
        }
        let slides = |p: &TrueContact| {
            let old = self.before.iter().find(|(old, _)| old.id == p.id);
            old.is_some_and(|(old, _)| {
                (old.position_m - p.position_m).norm() > SLIDES_M_PER_S * 1e-3
            })
        };
        let is_sliding = pressed.iter().any(|(p, _)| slides(p));
        match (strong().any(|(p, _)| off(p) > OFF_M), is_sliding) {
            (true, true) => Cause::OffSliding,
            (true, false) => Cause::Off,
            (false, true) => Cause::Sliding,
            (false, false) => Cause::Right,
        }
    }

    /// All that was seen.
    pub(crate) fn end(&mut self) -> Causes {
        std::mem::take(&mut self.causes)
    }
}

impl Causes {
    /// Adds those of another script or limb.
    pub(crate) fn add(&mut self, more: &Self) {
        for i in 0..CAUSES.len() {
            self.n_frames[i] += more.n_frames[i];
            self.n_rows[i] += more.n_rows[i];
            self.longest_ms[i] = self.longest_ms[i].max(more.longest_ms[i]);
        }
    }
}

impl Display for Causes {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "{:<30} {:>7} {:>6} {:>10}", "misfits", "frames", "rows", "longest ms")?;
        for (i, (_, name)) in CAUSES.iter().enumerate() {
            let (frames, rows, ms) = (self.n_frames[i], self.n_rows[i], self.longest_ms[i]);
            writeln!(f, "{name:<30} {frames:>7} {rows:>6} {ms:>10}")?;
        }
        Ok(())
    }
}
