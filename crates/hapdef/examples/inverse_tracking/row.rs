//! One row of the table.

use hapdef::ScoringError;
use hapdef_inverse::{Skin, TrackedFrame};

use crate::script::Script;
use crate::shared::{matched, mean, percent, quantile};

/// A contact is found if it is this near, mm.
const FOUND_MM: f64 = 10.0;

/// Frames after a contact comes or goes before its count is judged.
const SETTLED: usize = 50;

#[derive(Default)]
pub(crate) struct Row {
    /// When all contacts are there, and at the end.
    judged: [Judged; 2],
    delays: Vec<f64>,
    n_right_frames: usize,
    n_settled_frames: usize,
    pub(crate) n_searches: usize,
    times_us: Vec<f64>,
    n_onsets: usize,
}

#[derive(Default)]
struct Judged {
    near_mm: Vec<f64>,
    misses_n: Vec<f64>,
    n_true: usize,
    n_scenes: usize,
    n_right: usize,
}

impl Row {
    pub(crate) const HEAD: &str = "                 | all there: mm  median     p90      N   found  count | at the end: mm     N   found  count | frames  delay ms  searches | p50 µs   p99  99.99%     max";

    pub(crate) fn frame(
        &mut self,
        skin: &Skin,
        script: &Script,
        index: usize,
        frame: &TrackedFrame,
    ) -> Result<(), ScoringError> {
        let begun: Vec<_> = script.presses.iter().filter(|p| p.start < index).collect();
        if index <= script.all_there && self.n_onsets < begun.len() {
            let n_new = begun.len() - self.n_onsets;
            let oldest = begun.iter().map(|p| p.start).max().unwrap_or(0);
            if frame.contacts.len() >= begun.len() {
                self.delays.extend(vec![(index - oldest) as f64; n_new]);
                self.n_onsets = begun.len();
            } else if index - oldest > 140 {
                self.n_onsets = begun.len();
            }
        }
        let n_true = script.pressing(index).count();
        if script.is_settled(index, SETTLED) {
            self.n_settled_frames += 1;
            self.n_right_frames += usize::from(frame.contacts.len() == n_true);
        }
        let is_end = index + 1 == script.n_frames;
        if index + 1 == script.all_there {
            self.judged[0].judge(skin, script, index, frame)?;
        }
        if is_end {
            self.judged[1].judge(skin, script, index, frame)?;
        }
        Ok(())
    }

    pub(crate) fn end(&mut self, times_us: &[f64]) {
        self.times_us.extend(times_us);
        self.n_onsets = 0;
    }

    pub(crate) fn text(&mut self) -> String {
        let [there, end] = &mut self.judged;
        format!(
            "{:>14.2} {:>7.2} {:>7.2} {:>6.2} {:>6.1}% {:>5.1}% | {:>14.2} {:>5.2} {:>6.1}% {:>5.1}% | {:>5.1}% {:>9.0} {:>9} | {:>6.1} {:>5.0} {:>7.0} {:>7.0}",
            mean(&there.near_mm),
            quantile(&mut there.near_mm, 0.5),
            quantile(&mut there.near_mm, 0.9),
            mean(&there.misses_n),
            percent(there.near_mm.len(), there.n_true),
            percent(there.n_right, there.n_scenes),
            mean(&end.near_mm),
            mean(&end.misses_n),
            percent(end.near_mm.len(), end.n_true),
            percent(end.n_right, end.n_scenes),
            percent(self.n_right_frames, self.n_settled_frames),
            quantile(&mut self.delays, 0.5),
            self.n_searches,
            quantile(&mut self.times_us, 0.5),
            quantile(&mut self.times_us, 0.99),
            quantile(&mut self.times_us, 0.9999),
            quantile(&mut self.times_us, 1.0),
        )
    }
}

impl Judged {
    fn judge(
        &mut self,
        skin: &Skin,
        script: &Script,
        index: usize,
        frame: &TrackedFrame,
    ) -> Result<(), ScoringError> {
        let pressing = script.pressing(index);
        let truth = pressing.map(|p| (skin.position(&p.point(skin, index)), p.force_n(index)));
        let found = frame.contacts.iter().map(|c| &c.contact);
        let matched = matched(truth, found.map(|c| (c.position_m, c.force_n)))?;
        for pair in &matched.pairs {
            let mm = pair.position_error_m * 1e3;
            if mm <= FOUND_MM {
                self.near_mm.push(mm);
                self.misses_n.push(pair.force_error_n.abs());
            }
        }
        let n_true = matched.pairs.len() + matched.missed.len();
        self.n_true += n_true;
        self.n_scenes += 1;
        self.n_right += usize::from(frame.contacts.len() == n_true);
        Ok(())
    }
}
