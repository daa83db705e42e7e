//! What is not known of zeros while something touches, when they can't be followed.

/// Time in which a rate becomes another one, s: drift by temperature bends within minutes. Trusted for ever, a rate of
/// 1 µε/s was off by newtons after a contact of minutes.
const BEND_S: f64 = 60.0;

/// Variances of zeros that go on, during a contact, at the rates that they had `[n_gauges]`.
#[derive(Clone, Debug)]
pub(crate) struct Held {
    time_s: f64,
    /// Of the rate when the contact began, and of the zero then.
    of_rate: Vec<f64>,
    at_first: Vec<f64>,
    /// Of the zero now.
    pub(crate) variance: Vec<f64>,
}

impl Held {
    pub(crate) fn new(n_gauges: usize) -> Self {
        let zeros = || vec![0.0; n_gauges];
        Self { time_s: 0.0, of_rate: zeros(), at_first: zeros(), variance: zeros() }
    }

    /// The zero is known.
    pub(crate) fn start_over(&mut self) {
        self.variance.fill(0.0);
    }

    /// A contact begins; `of_rate` is the variance of each gauge's rate.
    pub(crate) fn begin(&mut self, of_rate: impl Iterator<Item = f64>) {
        self.time_s = 0.0;
        self.of_rate.iter_mut().zip(of_rate).for_each(|(to, variance)| *to = variance);
        self.at_first.copy_from_slice(&self.variance);
    }

    /// It lasts for `time_s` more, the zero going on at `rate`, which has bent meanwhile: by r t/τ after t, so that
    /// the zero is off by r t²/2τ.
    pub(crate) fn pass(&mut self, time_s: f64, rate: &[f64]) {
        self.time_s += time_s;
        let t = self.time_s;
        for (gauge, variance) in self.variance.iter_mut().enumerate() {
            let bent = rate[gauge] * t * t / (2.0 * BEND_S);
            *variance = self.at_first[gauge] + self.of_rate[gauge] * t * t + bent * bent;
        }
    }

    /// What of `miss`, a mean of variance `noise`, is the zero's (a Kalman filter's step); it is taken off there.
    pub(crate) fn learn(&mut self, gauge: usize, miss: &mut f64, noise: f64) -> f64 {
        let variance = &mut self.variance[gauge];
        let gain = *variance / (*variance + noise);
        if !miss.is_finite() || *variance == 0.0 {
            return 0.0;
        }
        *variance *= 1.0 - gain;
        let moved = gain * *miss;
        *miss -= moved;
        moved
    }
}

#[cfg(test)]
mod tests {
    use super::Held;

    /// 2 s at a rate known to 0.1 per s, then a minute at 1 per s that may bend.
    #[test]
    fn a_zero_is_known_less_the_longer_it_is_touched() {
        let mut held = Held::new(1);
        held.begin([0.01].into_iter());
        held.pass(2.0, &[0.0]);
        assert!((held.variance[0].sqrt() - 0.2).abs() < 1e-12);
        let mut miss = 0.4;
        let moved = held.learn(0, &mut miss, 0.04);
        assert!((moved - 0.2).abs() < 1e-12 && (miss - 0.2).abs() < 1e-12);
        assert!((held.variance[0] - 0.02).abs() < 1e-12);
        held.start_over();
        held.begin([0.0].into_iter());
        (0..60).for_each(|_| held.pass(1.0, &[1.0]));
        assert!((held.variance[0].sqrt() - 30.0).abs() < 1e-9);
    }
}
