//! At what rates work is done: as recorded by earlier runs in the same folder, else as assumed.

use std::collections::BTreeMap;

use hapdef_bench::stats;

use crate::cache::Cache;
use crate::work::{DoneWork, Work, WorkKind};

/// Rates of the kinds of work, in their amounts per second.
#[derive(Clone, Debug, PartialEq)]
pub struct Rates {
    recorded: BTreeMap<WorkKind, f64>,
    /// How fast this machine is against the assumed rates: the median over what is recorded.
    machine: f64,
}

impl Default for Rates {
    /// Those that count where nothing is recorded.
    fn default() -> Self {
        Self { recorded: BTreeMap::new(), machine: 1.0 }
    }
}

impl Rates {
    /// Rates of the work that was done with as many threads by the runs whose results `cache` has.
    #[must_use]
    pub fn recorded(cache: &Cache, threads: usize) -> Self {
        let mut sums = BTreeMap::<WorkKind, [f64; 2]>::new();
        for record in cache.records() {
            let done = serde_json::from_value::<DoneWork>(record.info["work"].clone());
            if let Ok(DoneWork { work, threads: by }) = done
                && (by, work.amount > 0.0) == (threads, true)
            {
                let sum = sums.entry(work.kind).or_default();
                *sum = [sum[0] + work.amount, sum[1] + record.elapsed_s];
            }
        }
        let rate = |(kind, [amount, s]): (WorkKind, [f64; 2])| (kind, amount / s.max(f64::EPSILON));
        let recorded: BTreeMap<WorkKind, f64> = sums.into_iter().map(rate).collect();
        if recorded.is_empty() {
            return Self::default();
        }
        let ratios = recorded.iter().map(|(kind, rate)| rate / assumed_per_s(*kind));
        Self { machine: stats::median(ratios), recorded }
    }

    /// Expected time, s; none where no rule is known.
    pub(super) fn seconds(&self, work: &Work) -> Option<f64> {
        let recorded = self.recorded.get(&work.kind).copied();
        let rate = recorded.unwrap_or_else(|| self.machine * assumed_per_s(work.kind));
        (work.amount > 0.0).then_some(work.amount / rate)
    }
}

/// Rates on two cores of an AMD EPYC, which count until something is recorded.
fn assumed_per_s(kind: WorkKind) -> f64 {
    match kind {
        WorkKind::Compliance | WorkKind::Rig | WorkKind::Response | WorkKind::Calibration => 1.7e10,
        WorkKind::Samples => 4.5e8,
        WorkKind::Transfer | WorkKind::Sensitivity | WorkKind::Direct => 5e10,
        WorkKind::Reconstruction => 4e10,
        WorkKind::Pass => 1.1e10,
        WorkKind::Kmax => 1.6e8,
        WorkKind::Test => 3.8e8,
        WorkKind::Followed | WorkKind::Single => 1.2e9,
        WorkKind::Pair => 2.5e9,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cache::StageRecord;

    fn record(cache: &Cache, stage: &str, work: Work, threads: usize, elapsed_s: f64) {
        let info = serde_json::json!({ "work": work.done(threads) });
        let (stage, inputs) = (stage.into(), serde_json::Value::Null);
        cache.keep(&StageRecord { stage, inputs, info, elapsed_s }).unwrap();
    }

    #[test]
    fn recorded_times_take_the_place_of_what_is_assumed() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::new(folder.path());
        let [test, pass, samples] = [Work::test(10), Work::pass(1000), Work::samples(10, 1, 50)];
        let seconds = |work: &Work| Rates::recorded(&cache, 2).seconds(work).unwrap();
        let assumed_s = [test, pass, samples].map(|work| seconds(&work));
        assert_eq!(assumed_s[0], test.amount / assumed_per_s(WorkKind::Test));
        record(&cache, "a", test, 1, 7.0);
        assert_eq!([test, pass, samples].map(|work| seconds(&work)), assumed_s);
        record(&cache, "b", test, 2, 3.0 * assumed_s[0]);
        record(&cache, "c", Work { amount: 3.0 * test.amount, ..test }, 2, 5.0 * assumed_s[0]);
        let ratio = |work: &Work, assumed_s: f64| seconds(work) / assumed_s;
        assert!((ratio(&test, assumed_s[0]) - 2.0).abs() < 1e-12);
        assert!((ratio(&pass, assumed_s[1]) - 2.0).abs() < 1e-12, "a slower machine");
        record(&cache, "d", samples, 2, 8.0 * assumed_s[2]);
        assert!((ratio(&samples, assumed_s[2]) - 8.0).abs() < 1e-12);
        assert!((ratio(&test, assumed_s[0]) - 2.0).abs() < 1e-12);
    }
}
