//! One row of the table.

use hapdef_inverse::{Skin, TrackedFrame};
use nalgebra::Point3;

use crate::script::Script;

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
    ) {
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
            self.judged[0].judge(skin, script, index, frame);
        }
        if is_end {
            self.judged[1].judge(skin, script, index, frame);
        }
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
    fn judge(&mut self, skin: &Skin, script: &Script, index: usize, frame: &TrackedFrame) {
        let truth: Vec<_> = script
            .pressing(index)
            .map(|p| (skin.position(&p.point(skin, index)), p.force_n(index)))
            .collect();
        let places: Vec<_> = truth.iter().map(|t| t.0).collect();
        let found: Vec<_> = frame
            .contacts
            .iter()
            .map(|c| c.contact.position_m)
            .collect();
        let pairs = matched(&places, &found, &mut vec![false; found.len()]).1;
        for (i, j) in pairs.into_iter().enumerate() {
            let Some(j) = j else {
                continue;
            };
            let mm = (places[i] - found[j]).norm() * 1e3;
            let miss_n = (truth[i].1 - frame.contacts[j].contact.force_n).abs();
            if mm <= FOUND_MM {
                self.near_mm.push(mm);
                self.misses_n.push(miss_n);
            }
        }
        self.n_true += truth.len();
        self.n_scenes += 1;
        self.n_right += usize::from(found.len() == truth.len());
    }
}

/// The one-to-one matching with the least summed distance; a contact without a match costs 10 m.
fn matched(
    truth: &[Point3<f64>],
    found: &[Point3<f64>],
    used: &mut Vec<bool>,
) -> (f64, Vec<Option<usize>>) {
    let Some((first, rest)) = truth.split_first() else {
        return (0.0, Vec::new());
    };
    let (cost, after) = matched(rest, found, used);
    let mut best = (cost + 10.0, None, after);
    for j in 0..found.len() {
        if used[j] {
            continue;
        }
        used[j] = true;
        let (cost, after) = matched(rest, found, used);
        used[j] = false;
        let cost = cost + (first - found[j]).norm();
        if cost < best.0 {
            best = (cost, Some(j), after);
        }
    }
    let (cost, pair, after) = best;
    (cost, std::iter::once(pair).chain(after).collect())
}

fn mean(v: &[f64]) -> f64 {
    v.iter().sum::<f64>() / v.len().max(1) as f64
}

fn percent(n: usize, of: usize) -> f64 {
    n as f64 / of.max(1) as f64 * 100.0
}

fn quantile(values: &mut [f64], q: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1) as f64;
    let place = (last * q).round() as usize;
    values.get(place).copied().unwrap_or(f64::NAN)
}
