//! An inertial unit and a sensor of force and torque at the flange, as channels beside the gauges.

use hapdef_contact::LimbLoad;
use hapdef_daq::hdp1::{Channel, ChannelKind};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::loads::MovingLoads;

/// Counts to either side of zero.
const HALF_RANGE: f64 = 32_767.0;

/// How well loads are measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadSensorParams {
    /// Each channel's gain is off by up to this share.
    pub gain_error: f64,
    /// Noise of an accelerometer's axis in a frame, standard deviation, m/s².
    pub acceleration_noise_m_s2: f64,
    /// Of a gyroscope's, rad/s.
    pub rate_noise_rad_s: f64,
    /// Of a force at the flange, N.
    pub force_noise_n: f64,
    /// Of a moment at the flange, N m.
    pub moment_noise_nm: f64,
    /// Seed of gains and noise.
    pub seed: u64,
}

/// The sensors of the loads that a limb has.
#[derive(Clone, Debug)]
pub struct LoadSensors {
    axes: Vec<Axis>,
    rng: ChaCha8Rng,
}

/// One channel.
#[derive(Clone, Copy, Debug)]
struct Axis {
    kind: ChannelKind,
    of: Measured,
    name: [u8; 2],
    gain: f64,
    noise: f64,
}

#[derive(Clone, Copy, Debug)]
enum Measured {
    /// So many times the load of that place in the list.
    Load(usize, f64),
    /// The angular rate about that direction.
    Rate(usize),
}

impl LoadSensors {
    /// Sensors of what `loads` has: an accelerometer reads the acceleration less gravity, a gyroscope the rates, a
    /// sensor at the flange forces and moments.
    #[must_use]
    pub fn new(loads: &MovingLoads, params: &LoadSensorParams) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(params.seed);
        let mut axes = Vec::new();
        let mut add = |kind, of, letter: u8, axis: usize, noise| {
            let gain = 1.0 + params.gain_error * rng.random_range(-1.0..=1.0);
            axes.push(Axis { kind, of, name: [letter, b"xyz"[axis]], gain, noise });
        };
        for (place, load) in loads.loads().iter().enumerate() {
            match *load {
                LimbLoad::SpecificForce(i) => {
                    let noise = params.acceleration_noise_m_s2;
                    add(ChannelKind::Acceleration, Measured::Load(place, -1.0), b'a', i, noise);
                }
                LimbLoad::AngularRates(i, j) if i == j => {
                    add(
                        ChannelKind::AngularRate,
                        Measured::Rate(i),
                        b'w',
                        i,
                        params.rate_noise_rad_s,
                    );
                }
                LimbLoad::FlangeForce(i) => {
                    add(
                        ChannelKind::Force,
                        Measured::Load(place, 1.0),
                        b'f',
                        i,
                        params.force_noise_n,
                    );
                }
                LimbLoad::FlangeMoment(i) => {
                    let noise = params.moment_noise_nm;
                    add(ChannelKind::Torque, Measured::Load(place, 1.0), b'm', i, noise);
                }
                LimbLoad::AngularAcceleration(_)
                | LimbLoad::AngularRates(..)
                | LimbLoad::Temperature => {}
            }
        }
        Self { axes, rng }
    }

    /// The channels, behind those of the gauges.
    pub(super) fn channels(&self) -> impl Iterator<Item = Channel> + '_ {
        self.axes.iter().map(|axis| Channel {
            kind: axis.kind,
            name: [axis.name[0], axis.name[1], 0, 0],
            ..Channel::quarter_bridge("", scale(axis.kind) as f32)
        })
    }

    /// Counts of all channels for `amounts` `[n_loads]` and the limb's angular rate, into `codes` `[n_channels]`.
    pub(super) fn sample(&mut self, amounts: &[f64], rate_rad_s: &Vector3<f64>, codes: &mut [i32]) {
        for (axis, code) in self.axes.iter().zip(codes) {
            let value = match axis.of {
                Measured::Load(place, sign) => sign * amounts[place],
                Measured::Rate(direction) => rate_rad_s[direction],
            };
            let noise: f64 = self.rng.sample(StandardNormal);
            let read = axis.gain * value + axis.noise * noise;
            *code = (read / scale(axis.kind)).round().clamp(-HALF_RANGE, HALF_RANGE) as i32;
        }
    }
}

/// Unit per count, of ranges of ±16 g, ±2,000 °/s, ±200 N and ±20 N m.
fn scale(kind: ChannelKind) -> f64 {
    let range = match kind {
        ChannelKind::Acceleration => 16.0 * 9.806_65,
        ChannelKind::AngularRate => 2000.0_f64.to_radians(),
        ChannelKind::Force => 200.0,
        _ => 20.0,
    };
    range / HALF_RANGE
}

impl Default for LoadSensorParams {
    /// Gains off by up to 2 %; noise of a usual inertial unit and of a usual sensor of six axes at 1 kHz.
    fn default() -> Self {
        Self {
            gain_error: 0.02,
            acceleration_noise_m_s2: 0.05,
            rate_noise_rad_s: 0.003,
            force_noise_n: 0.1,
            moment_noise_nm: 0.005,
            seed: 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_read_what_loads_the_limb() {
        let kinds = vec![
            (LimbLoad::FlangeForce(2), 10.0),
            (LimbLoad::SpecificForce(0), 9.81),
            (LimbLoad::AngularAcceleration(1), 5.0),
            (LimbLoad::AngularRates(1, 1), 2.0),
            (LimbLoad::Temperature, 5.0),
        ];
        let loads = MovingLoads::new(kinds, vec![1.0; 5], 0.0, 3);
        let exact = LoadSensorParams {
            gain_error: 0.0,
            acceleration_noise_m_s2: 0.0,
            rate_noise_rad_s: 0.0,
            force_noise_n: 0.0,
            ..LoadSensorParams::default()
        };
        let mut sensors = LoadSensors::new(&loads, &exact);
        let channels: Vec<Channel> = sensors.channels().collect();
        let names: Vec<String> = channels.iter().map(Channel::name_text).collect();
        assert_eq!(names, ["fz", "ax", "wy"]);
        let t_s = 7.3;
        let amounts: Vec<f64> = loads.amounts(t_s).collect();
        let mut codes = [0; 3];
        let rate_rad_s = Vector3::from_fn(|i, _| loads.rate_rad_s(i, t_s));
        sensors.sample(&amounts, &rate_rad_s, &mut codes);
        let expected = [amounts[0], -amounts[1], loads.rate_rad_s(1, t_s)];
        for ((code, channel), expected) in codes.iter().zip(&channels).zip(expected) {
            let found = f64::from(*code) * f64::from(channel.scale);
            assert!((found - expected).abs() <= f64::from(channel.scale), "{found} {expected}");
        }
    }
}
