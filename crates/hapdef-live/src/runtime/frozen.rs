//! Readings that stand still although their noise should move them.

/// A run of equal readings is no chance if noise makes one as long or longer with a probability below
/// e to this, 10⁻¹²: once in thirty years of frames at 1 kHz.
const LN_CHANCE: f64 = -27.6;

/// A run is at least so long; a link or a device that hesitates repeats fewer.
const LEAST_RUN: usize = 20;

/// A run is so many times longer than the longest of the tare: a device may repeat each reading.
const TARE_RUNS: usize = 4;

/// Runs of equal readings, gauge by gauge and of the whole frame.
pub(super) struct Frozen {
    last_ue: Vec<f64>,
    gauges: Vec<Run>,
    whole: Run,
}

/// How long readings have been equal, and how long they may be.
#[derive(Clone, Copy, Default)]
struct Run {
    n_same: usize,
    longest_of_tare: usize,
    most: Option<usize>,
}

impl Frozen {
    pub(super) fn new(n_gauges: usize) -> Self {
        Self {
            last_ue: vec![f64::NAN; n_gauges],
            gauges: vec![Run::default(); n_gauges],
            whole: Run::default(),
        }
    }

    /// A tare begins.
    pub(super) fn start_over(&mut self) {
        *self = Self::new(self.gauges.len());
    }

    /// Takes a frame.
    pub(super) fn take(&mut self, raw_ue: &[f64]) {
        let mut is_whole = true;
        for ((last, raw), run) in self.last_ue.iter_mut().zip(raw_ue).zip(&mut self.gauges) {
            let is_same = last.total_cmp(raw).is_eq();
            is_whole &= is_same;
            run.take(is_same);
            *last = *raw;
        }
        self.whole.take(is_whole);
    }

    /// The tare is over: `noise_ue` is each gauge's noise and its converter's step, µε. Noise of standard
    /// deviation σ stays within one step h with a probability of at most √(1 − exp(−h²/(2 π σ²)))
    /// (Pólya, Berkeley Symposium 1949). A gauge that hardly moves within its steps is never known to
    /// stand still by itself.
    pub(super) fn end_tare(&mut self, noise_ue: impl Iterator<Item = (f64, f64)>) {
        let mut ln_whole = 0.0;
        for (run, (sd, step)) in self.gauges.iter_mut().zip(noise_ue) {
            let steps_2 = (step / sd).powi(2) / std::f64::consts::TAU;
            let ln = if sd > 0.0 { 0.5 * (-(-steps_2).exp_m1()).ln() } else { 0.0 };
            ln_whole += ln;
            run.end_tare(ln);
        }
        self.whole.end_tare(ln_whole);
    }

    /// Whether no gauge has moved for too long.
    pub(super) fn is_whole(&self) -> bool {
        self.whole.is_frozen()
    }

    /// Gauges that stand still.
    pub(super) fn gauges(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.gauges.len()).filter(|&gauge| self.gauges[gauge].is_frozen())
    }
}

impl Run {
    fn take(&mut self, is_same: bool) {
        self.n_same = if is_same { self.n_same + 1 } else { 0 };
        if self.most.is_none() {
            self.longest_of_tare = self.longest_of_tare.max(self.n_same);
        }
    }

    fn end_tare(&mut self, ln_same: f64) {
        let by_chance = (LN_CHANCE / ln_same.min(-f64::MIN_POSITIVE)).ceil() as usize;
        self.most = Some(by_chance.max(LEAST_RUN).max(TARE_RUNS * self.longest_of_tare));
    }

    fn is_frozen(&self) -> bool {
        self.most.is_some_and(|most| self.n_same >= most)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        /// Noise alone, in steps of any size up to four deviations and around any place within a step,
        /// never stands still; frames that are frozen all at once do, in a tenth of a second.
        #[test]
        fn frozen_frames_are_known_from_noise(
            steps in 0.0..4.0f64,
            places in prop::array::uniform10(-0.5..0.5f64),
            moved in prop::array::uniform10(-0.5..0.5f64),
            seed in 0..1000u64,
        ) {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut read = |places: &[f64; 10]| {
                places.map(|place| {
                    let z: f64 = StandardNormal.sample(&mut rng);
                    let ue = 40.0 + place * steps + z;
                    if steps > 0.0 { (ue / steps).round() * steps } else { ue }
                })
            };
            let mut frozen = Frozen::new(10);
            for _ in 0..1000 {
                frozen.take(&read(&places));
            }
            frozen.end_tare([(1.0, steps); 10].into_iter());
            for _ in 0..20_000 {
                frozen.take(&read(&moved));
                prop_assert!(!frozen.is_whole() && frozen.gauges().count() == 0);
            }
            let stuck = read(&moved);
            for _ in 0..100 {
                frozen.take(&stuck);
            }
            prop_assert!(frozen.is_whole());
        }
    }

    #[test]
    fn a_device_that_repeats_each_reading_or_has_no_noise_is_not_frozen() {
        let mut repeating = Frozen::new(2);
        let mut still = Frozen::new(2);
        for i in 0..1000u32 {
            let value = f64::from(i / 12);
            repeating.take(&[value, -value]);
            still.take(&[0.0; 2]);
        }
        repeating.end_tare([(1.0, 0.0); 2].into_iter());
        still.end_tare([(0.0, 0.0); 2].into_iter());
        for i in 0..1000u32 {
            let value = f64::from(i / 12);
            repeating.take(&[value, -value]);
            still.take(&[0.0; 2]);
            assert!(!repeating.is_whole() && !still.is_whole());
        }
    }
}
