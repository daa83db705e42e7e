//! How fast zeros may drift: limits along the directions that drift has.

use crate::conditioning::params::ConditionerParams;

/// Limits of drift per second: all gauges together, as temperature moves them; one gauge more than the others,
/// as its creep does; every gauge in any direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DriftLimits {
    common: f64,
    single: f64,
    each: f64,
}

impl DriftLimits {
    pub(crate) fn new(params: &ConditionerParams) -> Self {
        let ConditionerParams { common_drift_limit, single_drift_limit, drift_limit, .. } = *params;
        Self { common: common_drift_limit, single: single_drift_limit, each: drift_limit }
    }

    /// Variance of a rate of which only the limit is known.
    pub(crate) fn rate_variance(self) -> f64 {
        self.each * self.each / 3.0
    }

    /// The same in any direction, and without end for all gauges together and for one more than the others: where it
    /// is not a rate that tells drift, but its pattern.
    pub(crate) fn of_any_amount(self) -> Self {
        Self { common: f64::INFINITY, single: f64::INFINITY, ..self }
    }

    /// What of `v` `[n_gauges]`, moved within `time_s`, is beyond drift, into `beyond`. The common part is the
    /// median, so that a contact on few gauges leaves it alone; it is tried without it, too, and what leaves
    /// less counts.
    pub(crate) fn beyond(&self, v: &[f64], time_s: f64, sorted: &mut [f64], beyond: &mut [f64]) {
        sorted.copy_from_slice(v);
        sorted.sort_unstable_by(f64::total_cmp);
        let most = self.common * time_s;
        let median = sorted[v.len() / 2].clamp(-most, most);
        let (single, each) = (self.single * time_s, self.each * time_s);
        let left = |common: f64, gauge: usize, of_single: usize| {
            let off = v[gauge] - common;
            let most = if gauge == of_single { single.max(each) } else { each };
            off - off.clamp(-most, most)
        };
        let of_single = |common: f64| {
            let off = |gauge: &usize| (v[*gauge] - common).abs();
            (0..v.len()).max_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(0)
        };
        let square = |common: f64| {
            let of_single = of_single(common);
            (0..v.len()).map(|gauge| left(common, gauge, of_single).powi(2)).sum::<f64>()
        };
        let common = if square(median) < square(0.0) { median } else { 0.0 };
        let of_single = of_single(common);
        for (gauge, beyond) in beyond.iter_mut().enumerate() {
            *beyond = left(common, gauge, of_single);
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::DriftLimits;

    proptest! {
        /// Any direction within the limit is drift, with a common part and one gauge's on top, too.
        #[test]
        fn what_is_within_the_limits_is_drift(
            v in prop::collection::vec(-1.0_f64..1.0, 10),
            common in -2.0_f64..2.0,
            gauge in 0_usize..10,
        ) {
            let limits = DriftLimits { common: 3.0, single: 3.0, each: 1.0 };
            let (mut sorted, mut beyond) = ([0.0; 10], [0.0; 10]);
            limits.beyond(&v, 1.0, &mut sorted, &mut beyond);
            prop_assert_eq!(beyond, [0.0; 10]);
            let mut one = [common; 10];
            one[gauge] += 2.9;
            limits.beyond(&one, 1.0, &mut sorted, &mut beyond);
            prop_assert!(beyond.iter().all(|b| b.abs() < 1e-12), "{:?}", beyond);
            one[(gauge + 5) % 10] -= 4.0;
            limits.beyond(&one, 1.0, &mut sorted, &mut beyond);
            prop_assert!(beyond.iter().any(|b| b.abs() > 0.5), "{:?}", beyond);
        }
    }
}
