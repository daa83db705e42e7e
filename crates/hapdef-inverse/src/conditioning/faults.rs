//! Gauges that can't be believed.

use hapdef_contact::GaugeHealth;

use crate::conditioning::conditioned::Conditioned;
use crate::conditioning::params::ConditionerParams;

/// One gauge's recent past.
#[derive(Clone, Debug)]
pub(crate) struct Watch {
    last: f64,
    n_same: usize,
    /// Others' readings moved since this one began to repeat.
    others_moved: bool,
    n_spike: usize,
    n_good: usize,
    pub(crate) health: GaugeHealth,
}

/// What is known of a gauge's converter.
#[derive(Clone, Copy)]
struct Converter<'a> {
    /// Its lowest and highest value.
    rail: Option<&'a (f64, f64)>,
    /// Whether its steps are larger than the gauge's noise.
    is_coarse: bool,
}

/// Masks the gauges that can't be believed by their `raw` values `[n_gauges]` and what `out` has of their readings.
pub(crate) fn find_faults(
    watches: &mut [Watch],
    raw: &[f64],
    params: &ConditionerParams,
    out: &mut Conditioned,
) {
    let sd = |gauge: usize, out: &Conditioned| params.gauge_sd[gauge].hypot(out.baseline_sd[gauge]);
    // the two largest, so that each gauge finds the largest of the others
    let (mut first, mut second, mut of_first) = (0.0, 0.0, usize::MAX);
    for (gauge, watch) in watches.iter().enumerate() {
        let z = (out.readings[gauge] / sd(gauge, out)).abs();
        let counts = watch.health == GaugeHealth::Good && z.is_finite();
        let z = if counts { z } else { 0.0 };
        if z > first {
            (second, first, of_first) = (first, z, gauge);
        } else if z > second {
            second = z;
        }
    }
    out.is_mask_new = false;
    for (gauge, watch) in watches.iter_mut().enumerate() {
        let others = if gauge == of_first { second } else { first };
        let converter = Converter {
            rail: params.rails.get(gauge),
            is_coarse: params.coarse.get(gauge).is_some_and(|&coarse| coarse),
        };
        let was_live = watch.health == GaugeHealth::Good;
        let own = out.readings[gauge] / sd(gauge, out);
        watch.judge(raw[gauge], converter, own, others, params);
        out.health[gauge] = watch.health;
        out.live[gauge] = watch.health == GaugeHealth::Good;
        out.is_mask_new |= out.live[gauge] != was_live;
        if !out.live[gauge] {
            out.readings[gauge] = 0.0;
        }
    }
}

impl Watch {
    pub(crate) fn new() -> Self {
        Self {
            last: f64::NAN,
            n_same: 0,
            others_moved: false,
            n_spike: 0,
            n_good: usize::MAX,
            health: GaugeHealth::Good,
        }
    }

    /// Judges a raw value; `z` is its reading over its standard deviation, `others_z` the largest of
    /// the other gauges'.
    fn judge(
        &mut self,
        raw: f64,
        converter: Converter<'_>,
        z: f64,
        others_z: f64,
        params: &ConditionerParams,
    ) {
        let fault = self.fault(raw, converter, z, others_z, params);
        self.last = raw;
        self.n_good = match fault {
            Some(_) => 0,
            None => self.n_good.saturating_add(1),
        };
        // a spike is over when it is over
        let waits = matches!(self.health, GaugeHealth::Spike | GaugeHealth::Good);
        self.health = match fault {
            Some(fault) => fault,
            None if waits || self.n_good >= params.recover_frames => GaugeHealth::Good,
            None => GaugeHealth::Recovering,
        };
    }

    fn fault(
        &mut self,
        raw: f64,
        converter: Converter<'_>,
        z: f64,
        others_z: f64,
        params: &ConditionerParams,
    ) -> Option<GaugeHealth> {
        if !raw.is_finite() {
            return Some(GaugeHealth::NotFinite);
        }
        if converter.rail.is_some_and(|(low, high)| raw <= *low || raw >= *high) {
            return Some(GaugeHealth::Saturated);
        }
        if raw.total_cmp(&self.last).is_eq() {
            self.n_same += 1;
            self.others_moved |= others_z > params.moved_sds;
        } else {
            (self.n_same, self.others_moved) = (0, false);
        }
        let is_stuck = self.n_same >= params.stuck_frames && self.others_moved;
        if is_stuck && !converter.is_coarse {
            return Some(GaugeHealth::Dead);
        }
        let is_alone = z.abs() > params.spike_sds && others_z < 0.5 * params.spike_sds;
        self.n_spike = if is_alone { self.n_spike + 1 } else { 0 };
        (is_alone && self.n_spike <= params.spike_frames).then_some(GaugeHealth::Spike)
    }
}
