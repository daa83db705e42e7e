//! What a device measures beside its gauges of how the whole limb is loaded: motion, and what the next joint passes on.

use std::fmt::{self, Display, Formatter};
use std::str::FromStr;

use hapdef_daq::hdp1::{Channel, ChannelKind};

use crate::error::LiveError;

/// Angular accelerations are slopes of angular rates, smoothed over so long, s: noise of a gyroscope of 2 mrad/s is
/// 3 rad/s² from frame to frame at 1 kHz, a hundredth of that smoothed.
const SLOPE_S: f64 = 0.01;

/// One number of a frame that a load on the whole limb may be proportional to. Axes are those of the device that
/// measures it, in the order of its channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LoadSignal {
    /// Of an accelerometer, m/s²: acceleration less gravity.
    Acceleration(usize),
    /// Slope of a gyroscope's rate, rad/s².
    AngularAcceleration(usize),
    /// Product of two rates of a gyroscope, rad²/s²: what is centrifugal.
    AngularRates(usize, usize),
    /// Of a sensor of force, N.
    Force(usize),
    /// Of a sensor of torque, as of a joint, N m.
    Torque(usize),
}

/// Loads that are measured: what each gauge reads for one unit of each signal.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GivenLoads {
    /// The signals `[n_signals]`.
    pub signals: Vec<LoadSignal>,
    /// `[n_signals, n_gauges]`, µε per unit.
    pub response_ue: Vec<f64>,
}

/// The channels of a device that carry signals, and what is kept of the frame before.
#[derive(Clone, Debug)]
pub(crate) struct SignalReader {
    accelerations: Vec<usize>,
    /// Of a gyroscope: all three, or none.
    rates: Option<[usize; 3]>,
    forces: Vec<usize>,
    torques: Vec<usize>,
    last: Option<LastRates>,
}

#[derive(Clone, Copy, Debug)]
struct LastRates {
    t_us: u64,
    rad_s: [f64; 3],
    slope_rad_s2: [f64; 3],
}

/// A word that names no signal.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{found:?}: expected a signal such as acceleration_0, angular_rates_01 or torque_2")]
pub struct UnknownSignal {
    found: String,
}

impl Display for LoadSignal {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Acceleration(i) => write!(f, "acceleration_{i}"),
            Self::AngularAcceleration(i) => write!(f, "angular_acceleration_{i}"),
            Self::AngularRates(i, j) => write!(f, "angular_rates_{i}{j}"),
            Self::Force(i) => write!(f, "force_{i}"),
            Self::Torque(i) => write!(f, "torque_{i}"),
        }
    }
}

impl FromStr for LoadSignal {
    type Err = UnknownSignal;

    fn from_str(text: &str) -> Result<Self, UnknownSignal> {
        let found = || {
            let (word, axes) = text.rsplit_once('_')?;
            Some(match word {
                "acceleration" => Self::Acceleration(axes.parse().ok()?),
                "angular_acceleration" => Self::AngularAcceleration(axes.parse().ok()?),
                "force" => Self::Force(axes.parse().ok()?),
                "torque" => Self::Torque(axes.parse().ok()?),
                "angular_rates" => {
                    let mut digits = axes.chars().map(|c| c.to_digit(3));
                    match (digits.next()??, digits.next()??, digits.next()) {
                        (i, j, None) => Self::AngularRates(i as usize, j as usize),
                        _ => return None,
                    }
                }
                _ => return None,
            })
        };
        found().ok_or_else(|| UnknownSignal { found: text.to_owned() })
    }
}

impl GivenLoads {
    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.signals.is_empty()
    }

    /// What the gauges read for `signals` `[n_signals]`, into `into_ue` `[n_gauges]`, µε.
    pub(crate) fn read(&self, signals: &[(LoadSignal, f64)], into_ue: &mut [f64]) {
        into_ue.fill(0.0);
        let rows = self.response_ue.chunks_exact(into_ue.len().max(1));
        for (row, (_, amount)) in rows.zip(signals) {
            into_ue.iter_mut().zip(row).for_each(|(sum, unit)| *sum += amount * unit);
        }
    }

    /// # Errors
    /// [`LiveError::FrameLength`] for another number of gauges, [`LiveError::Parameter`] for a number that is not
    /// finite.
    pub(crate) fn check(&self, n_gauges: usize) -> Result<(), LiveError> {
        let (expected, found) = (self.signals.len() * n_gauges, self.response_ue.len());
        if expected != found {
            return Err(LiveError::FrameLength { expected, found });
        }
        match self.response_ue.iter().find(|v| !v.is_finite()) {
            Some(&found) => {
                let (what, expected) = ("a measured load's response", "finite");
                Err(LiveError::Parameter { what, found, expected })
            }
            None => Ok(()),
        }
    }
}

impl SignalReader {
    /// Finds the channels by their kinds. A gyroscope has three axes; another number of them can't be used.
    pub(crate) fn new(channels: &[Channel]) -> Self {
        let of_kind = |kind| (0..channels.len()).filter(|&i| channels[i].kind == kind).collect();
        let rates: Vec<usize> = of_kind(ChannelKind::AngularRate);
        Self {
            accelerations: of_kind(ChannelKind::Acceleration),
            rates: rates.try_into().ok(),
            forces: of_kind(ChannelKind::Force),
            torques: of_kind(ChannelKind::Torque),
            last: None,
        }
    }

    /// Signals of a frame of the device time `t_us`, whose channels are `scaled`, into `signals`, in an order that
    /// stays.
    pub(crate) fn read(&mut self, scaled: &[f64], t_us: u64, signals: &mut Vec<(LoadSignal, f64)>) {
        signals.clear();
        let extend = |of: &[usize], signal: fn(usize) -> LoadSignal, to: &mut Vec<_>| {
            let numbered = of.iter().enumerate();
            to.extend(numbered.map(|(i, &channel)| (signal(i), scaled[channel])));
        };
        extend(&self.accelerations, LoadSignal::Acceleration, signals);
        if let Some(rates) = self.rates {
            let rad_s = rates.map(|channel| scaled[channel]);
            let slope = self.slope(rad_s, t_us);
            signals.extend((0..3).map(|i| (LoadSignal::AngularAcceleration(i), slope[i])));
            for i in 0..3 {
                signals
                    .extend((i..3).map(|j| (LoadSignal::AngularRates(i, j), rad_s[i] * rad_s[j])));
            }
        }
        extend(&self.forces, LoadSignal::Force, signals);
        extend(&self.torques, LoadSignal::Torque, signals);
    }

    /// Smoothed slopes of the rates, rad/s².
    fn slope(&mut self, rad_s: [f64; 3], t_us: u64) -> [f64; 3] {
        let slope_rad_s2 = match self.last {
            Some(last) if t_us > last.t_us => {
                let passed_s = (t_us - last.t_us) as f64 * 1e-6;
                let share = 1.0 - (-passed_s / SLOPE_S).exp();
                std::array::from_fn(|i| {
                    let now = (rad_s[i] - last.rad_s[i]) / passed_s;
                    let smooth = last.slope_rad_s2[i] + share * (now - last.slope_rad_s2[i]);
                    // one number that is none doesn't stay
                    if smooth.is_finite() || !rad_s[i].is_finite() { smooth } else { 0.0 }
                })
            }
            _ => [0.0; 3],
        };
        self.last = Some(LastRates { t_us, rad_s, slope_rad_s2 });
        slope_rad_s2
    }
}

#[cfg(test)]
mod tests {
    use hapdef_daq::hdp1::{Hello, SampleFormat};

    use super::*;

    fn channels(kinds: &[ChannelKind]) -> Vec<Channel> {
        let mut channels = Hello::plain(kinds.len(), SampleFormat::F32, 1000).channels;
        channels.iter_mut().zip(kinds).for_each(|(channel, kind)| channel.kind = *kind);
        channels
    }

    #[test]
    fn words_name_signals() {
        let all = [
            LoadSignal::Acceleration(2),
            LoadSignal::AngularAcceleration(0),
            LoadSignal::AngularRates(0, 2),
            LoadSignal::Force(1),
            LoadSignal::Torque(5),
        ];
        for signal in all {
            assert_eq!(signal.to_string().parse(), Ok(signal));
        }
        for word in
            ["", "acceleration", "angular_rates_0", "angular_rates_03", "force_x", "weight_0"]
        {
            assert!(word.parse::<LoadSignal>().is_err(), "{word}");
        }
    }

    #[test]
    fn a_gyroscope_gives_slopes_and_products() {
        use ChannelKind::{Acceleration, AngularRate, QuarterBridge, Torque};
        let kinds = [QuarterBridge, Torque, AngularRate, AngularRate, AngularRate, Acceleration];
        let mut reader = SignalReader::new(&channels(&kinds));
        let mut signals = Vec::new();
        // ω = (t, 2, −t²/2)
        for ms in 0..2000_u64 {
            let t_s = ms as f64 * 1e-3;
            let scaled = [0.0, 7.0, t_s, 2.0, -0.5 * t_s * t_s, 9.0];
            reader.read(&scaled, ms * 1000, &mut signals);
        }
        let value = |word: &str| {
            let signal = word.parse().unwrap();
            signals.iter().find(|(of, _)| *of == signal).unwrap().1
        };
        assert_eq!(signals.len(), 11);
        assert_eq!((value("acceleration_0"), value("torque_0")), (9.0, 7.0));
        assert!((value("angular_acceleration_0") - 1.0).abs() < 1e-9);
        assert!(value("angular_acceleration_1").abs() < 1e-9);
        // behind by the smoothing
        assert!((value("angular_acceleration_2") + 1.999 - SLOPE_S).abs() < 1e-3);
        assert!((value("angular_rates_01") - 2.0 * 1.999).abs() < 1e-9);
        assert!((value("angular_rates_11") - 4.0).abs() < 1e-9);
    }

    #[test]
    fn two_axes_are_no_gyroscope() {
        let kinds = [ChannelKind::AngularRate, ChannelKind::AngularRate, ChannelKind::Force];
        let mut signals = Vec::new();
        SignalReader::new(&channels(&kinds)).read(&[1.0, 2.0, 3.0], 0, &mut signals);
        assert_eq!(signals, [(LoadSignal::Force(0), 3.0)]);
    }

    #[test]
    fn measured_loads_read_what_they_strain() {
        let signals = vec![LoadSignal::Force(0), LoadSignal::Torque(0)];
        let given = GivenLoads { signals, response_ue: vec![1.0, 2.0, 10.0, 0.0] };
        let mut ue = [9.0; 2];
        given.read(&[(LoadSignal::Force(0), 3.0), (LoadSignal::Torque(0), -1.0)], &mut ue);
        assert_eq!(ue, [-7.0, 6.0]);
        assert!(given.check(2).is_ok() && given.check(3).is_err());
    }
}
