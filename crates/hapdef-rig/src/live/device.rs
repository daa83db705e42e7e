//! The virtual limb as a device that speaks HDP1: what it says, without any port.

use std::sync::Arc;

use hapdef_daq::hdp1::{
    Channel, ChannelKind, Command, Decoder, Encoder, Event, FrameFlags, Hello, MINOR_VERSION, Pong,
    SampleFormat, Status,
};

use nalgebra::Vector3;

use super::electronics::LiveElectronics;
use super::limb::LiveLimb;
use super::loads::LoadHandle;
use super::play::Play;
use super::press::{PressHandle, Pressed, TruthFrame};
use super::sensors::{LoadSensorParams, LoadSensors};
use crate::error::RigError;

/// Counts of the temperature channel per °C.
const TEMPERATURE_PER_C: f64 = 100.0;

/// The device around the limb.
#[derive(Clone, Debug, PartialEq)]
pub struct RigDeviceParams {
    /// Frames per second by the device's own clock.
    pub rate_hz: f64,
    /// How much faster than true the device's clock runs, parts per million.
    pub drift_ppm: f64,
    /// Device time of the first frame, µs.
    pub clock_offset_us: u64,
    /// Number of this start of the device; a reset adds 1.
    pub boot_id: u32,
    /// Names of the gauges `[n_gauges]`, of which four characters are sent; G0, G1, … if empty.
    pub names: Vec<String>,
    /// Adds a channel with the temperature, 0.01 °C a count.
    pub has_temperature: bool,
    /// Adds channels that measure the loads on the whole limb.
    pub load_sensors: Option<LoadSensorParams>,
}

/// The device: limb, electronics, what presses, and HDP1. It does no input or output; a port, a link
/// or a test drives it.
pub struct RigDevice {
    limb: Arc<LiveLimb>,
    play: Option<Play>,
    press: PressHandle,
    loads: LoadHandle,
    electronics: LiveElectronics,
    load_sensors: Option<LoadSensors>,
    params: RigDeviceParams,
    hello: Hello,
    encoder: Encoder,
    decoder: Decoder,
    status: Status,
    is_running: bool,
    /// Samples since the play began, and of these before the last reset.
    n_samples: u64,
    n_before_boot: u64,
    next_flags: FrameFlags,
    truth: TruthFrame,
    pressed: Vec<Pressed>,
    strain_ue: Vec<f64>,
    codes: Vec<i32>,
}

impl Default for RigDeviceParams {
    /// 1 kHz by a true clock from 0, first start, no temperature.
    fn default() -> Self {
        Self {
            rate_hz: 1000.0,
            drift_ppm: 0.0,
            clock_offset_us: 0,
            boot_id: 1,
            names: Vec::new(),
            has_temperature: false,
            load_sensors: None,
        }
    }
}

impl RigDevice {
    /// A device on which `script` is played; more may be pressed by [`Self::press_handle`].
    ///
    /// # Errors
    /// [`RigError::Parameter`] for a rate outside 1 Hz to 100 kHz, a drift of 1 % or more, or
    /// electronics of another number of gauges; [`RigError::Daq`] for what HELLO has no room for.
    pub fn new(
        limb: Arc<LiveLimb>,
        script: Option<Play>,
        electronics: LiveElectronics,
        params: RigDeviceParams,
    ) -> Result<Self, RigError> {
        check(&limb, &electronics, &params)?;
        let new = |params| LoadSensors::new(limb.loads(), params);
        let load_sensors = params.load_sensors.as_ref().map(new);
        let hello = hello(&electronics, load_sensors.as_ref(), &params);
        let mut encoder = Encoder::new();
        encoder.hello(&hello, 0, &mut Vec::new())?;
        let (n, n_channels) = (limb.n_gauges(), hello.channels.len());
        let mut device = Self {
            limb,
            play: script,
            press: PressHandle::new(),
            loads: LoadHandle::default(),
            electronics,
            load_sensors,
            hello,
            encoder,
            decoder: Decoder::new(),
            status: Status::default(),
            is_running: true,
            n_samples: 0,
            n_before_boot: 0,
            next_flags: FrameFlags::FIRST_AFTER_BOOT,
            truth: TruthFrame::default(),
            pressed: Vec::new(),
            strain_ue: vec![0.0; n],
            codes: vec![0; n_channels],
            params,
        };
        device.status.supply_mv = 3300;
        Ok(device)
    }

    /// What presses by hand, on top of the script.
    #[must_use]
    pub fn press_handle(&self) -> PressHandle {
        self.press.clone()
    }

    /// What loads the whole limb by hand, in place of its waves.
    #[must_use]
    pub fn load_handle(&self) -> LoadHandle {
        self.loads.clone()
    }

    /// The limb.
    #[must_use]
    pub fn limb(&self) -> &Arc<LiveLimb> {
        &self.limb
    }

    /// What the device says about itself.
    #[must_use]
    pub fn hello(&self) -> &Hello {
        &self.hello
    }

    /// Its counts since the last start.
    #[must_use]
    pub fn status(&self) -> &Status {
        &self.status
    }

    /// Ground truth of the last frame.
    #[must_use]
    pub fn truth(&self) -> &TruthFrame {
        &self.truth
    }

    /// True time of the next frame since the play began, s.
    #[must_use]
    pub fn next_t_s(&self) -> f64 {
        self.n_samples as f64 / self.true_rate_hz()
    }

    /// What it says when a host opens its port: the end of whatever was there, and HELLO.
    pub fn opened(&mut self, out: &mut Vec<u8>) {
        out.push(0);
        self.say_hello(out);
    }

    /// Starts anew: numbers and time begin again, with another boot id. Truth, wear and weather of the
    /// limb and its electronics go on.
    pub fn reset(&mut self, out: &mut Vec<u8>) {
        self.params.boot_id = self.params.boot_id.wrapping_add(1);
        self.hello.boot_id = self.params.boot_id;
        self.encoder = Encoder::new();
        self.decoder = Decoder::new();
        self.status = Status { supply_mv: self.status.supply_mv, ..Status::default() };
        self.is_running = true;
        self.n_before_boot = self.n_samples;
        self.next_flags = FrameFlags::FIRST_AFTER_BOOT;
        self.opened(out);
    }

    /// Takes what the host says and answers it at the true time `t_s`.
    pub fn answer(&mut self, bytes: &[u8], t_s: f64, out: &mut Vec<u8>) {
        let mut commands = Vec::new();
        let before = self.decoder.rejected().n_damaged;
        self.decoder.push(bytes, &mut |event| {
            if let Event::Command(command) = event {
                commands.push(command);
            }
        });
        let n_bad = self.decoder.rejected().n_damaged - before;
        self.status.n_rx_crc_errors = self.status.n_rx_crc_errors.wrapping_add(n_bad as u32);
        let since_boot_s = t_s - self.n_before_boot as f64 / self.true_rate_hz();
        let speed = 1.0 + self.params.drift_ppm * 1e-6;
        let t_us = self.params.clock_offset_us + (since_boot_s.max(0.0) * 1e6 * speed) as u64;
        for command in commands {
            match command {
                Command::GetHello => self.say_hello(out),
                Command::Start => self.is_running = true,
                Command::Stop => self.is_running = false,
                Command::Ping { host_ns } => {
                    let pong = Pong { host_ns, t_rx_us: t_us, t_us };
                    self.encoder.pong(pong, out);
                }
            }
        }
    }

    /// Takes the next sample and appends its packet to `out`, with HELLO and STATUS once a second. A
    /// packet for which `room` bytes are not enough is dropped and counted, as the firmware does; its
    /// number is missing then.
    pub fn tick(&mut self, room: usize, out: &mut Vec<u8>) {
        let start = out.len();
        self.sample();
        let n = self.n_samples - self.n_before_boot;
        if n > 0 && (n as f64 % self.params.rate_hz) < 1.0 {
            self.say_hello(out);
            self.say_status(out);
            if out.len() - start > room {
                out.truncate(start);
            } else {
                self.status.saturated = 0;
            }
        }
        self.n_samples += 1;
        if !self.is_running {
            return;
        }
        let mut flags = std::mem::take(&mut self.next_flags);
        if self.electronics.saturated() != 0 {
            flags = flags.union(FrameFlags::SATURATED);
        }
        let before = out.len();
        let t_us = self.truth.t_device_us;
        let made = self.encoder.data(&self.hello, t_us, flags, &self.codes, out);
        debug_assert!(made.is_ok(), "{made:?}");
        if out.len() - start > room {
            out.truncate(before);
            self.status.n_tx_dropped = self.status.n_tx_dropped.wrapping_add(1);
        } else {
            self.status.n_sent = self.status.n_sent.wrapping_add(1);
        }
    }

    /// Leaves out the samples before the true time `t_s`, as a converter does that was not read in
    /// time; the next packet says so.
    pub fn skip_to(&mut self, t_s: f64) {
        let n = (t_s * self.true_rate_hz()).floor().max(0.0) as u64;
        if n > self.n_samples {
            self.n_samples = n;
            self.status.n_adc_overruns = self.status.n_adc_overruns.wrapping_add(1);
            self.next_flags = self.next_flags.union(FrameFlags::OVERRUN);
        }
    }

    fn true_rate_hz(&self) -> f64 {
        self.params.rate_hz * (1.0 + self.params.drift_ppm * 1e-6)
    }

    fn t_device_us(&self) -> u64 {
        let n = self.n_samples - self.n_before_boot;
        self.params.clock_offset_us + (n as f64 * 1e6 / self.params.rate_hz).round() as u64
    }

    fn sample(&mut self) {
        let t_s = self.next_t_s();
        let rate_rad_s = self.load(t_s);
        let contacts = &mut self.truth.contacts;
        contacts.clear();
        if let Some(play) = &self.play {
            play.at(t_s, &self.limb, contacts);
        }
        self.press.read_into(&mut self.pressed);
        contacts.extend(self.pressed.iter().filter_map(|p| p.on(&self.limb)));
        self.strain_ue.fill(0.0);
        self.limb.loads().add_strain_ue(&self.truth.loads, &mut self.strain_ue);
        for contact in contacts.iter() {
            let force = contact.force_vector_n();
            self.limb.add_strain_ue(&contact.point, &force, &mut self.strain_ue);
        }
        let n = self.electronics.n_channels();
        self.electronics.sample(t_s, &self.strain_ue, &mut self.codes[..n]);
        let celsius = self.electronics.temperature_at(t_s);
        if self.params.has_temperature {
            self.codes[n] = (celsius * TEMPERATURE_PER_C).round() as i32;
        }
        if let Some(sensors) = &mut self.load_sensors {
            let codes = &mut self.codes[n + usize::from(self.params.has_temperature)..];
            sensors.sample(&self.truth.loads, &rate_rad_s, codes);
        }
        self.truth.boot_id = self.params.boot_id;
        self.truth.seq = self.encoder.seq();
        self.truth.t_device_us = self.t_device_us();
        self.truth.t_s = t_s;
        // STATUS reports those since the last one.
        self.status.saturated |= self.electronics.saturated();
        self.status.temperature_centi_c = (celsius * 100.0).round() as i16;
        let uptime_s = (self.n_samples - self.n_before_boot) as f64 / self.params.rate_hz;
        self.status.uptime_s = uptime_s as u32;
    }

    /// Takes over how much there is of each load: what was set by hand, or the waves. The limb's angular rate.
    fn load(&mut self, t_s: f64) -> Vector3<f64> {
        let (waves, amounts) = (self.limb.loads(), &mut self.truth.loads);
        amounts.clear();
        match self.loads.get() {
            Some(by_hand) => {
                amounts.extend(waves.loads().iter().map(|load| by_hand.amount(*load)));
                by_hand.angular_rate_rad_s
            }
            None => {
                amounts.extend(waves.amounts(t_s));
                Vector3::from_fn(|i, _| waves.rate_rad_s(i, t_s))
            }
        }
    }

    fn say_hello(&mut self, out: &mut Vec<u8>) {
        let said = self.encoder.hello(&self.hello, self.t_device_us(), out);
        debug_assert!(said.is_ok(), "{said:?}");
    }

    fn say_status(&mut self, out: &mut Vec<u8>) {
        let t_us = self.t_device_us();
        self.encoder.status(self.status, t_us, out);
    }
}

fn check(
    limb: &LiveLimb,
    electronics: &LiveElectronics,
    params: &RigDeviceParams,
) -> Result<(), RigError> {
    let require = |ok: bool, name, expected, found| {
        if ok {
            return Ok(());
        }
        Err(RigError::Parameter { name, expected, found })
    };
    let rate_hz = params.rate_hz;
    require((1.0..=1e5).contains(&rate_hz), "rate_hz", "1 to 100000", rate_hz)?;
    let ppm = params.drift_ppm;
    require(ppm.abs() < 1e4, "drift_ppm", "less than 1 % either way", ppm)?;
    let n = electronics.n_channels();
    let expected = "one channel for each gauge of the limb";
    require(n == limb.n_gauges(), "electronics", expected, n as f64)
}

fn hello(
    electronics: &LiveElectronics,
    load_sensors: Option<&LoadSensors>,
    params: &RigDeviceParams,
) -> Hello {
    let format = match electronics.adc_bits() {
        ..=16 => SampleFormat::I16,
        17..=24 => SampleFormat::I24,
        _ => SampleFormat::I32,
    };
    let n = electronics.n_channels();
    let channel = |i: usize| {
        let name = params.names.get(i).map_or(format!("G{i}"), Clone::clone);
        Channel::quarter_bridge(&name, electronics.resolution_ue(i) as f32)
    };
    let temperature = params.has_temperature.then(|| Channel {
        kind: ChannelKind::Temperature,
        ..Channel::quarter_bridge("TEMP", (1.0 / TEMPERATURE_PER_C) as f32)
    });
    let mut hello = Hello {
        minor: MINOR_VERSION,
        format,
        n_scans: 1,
        rate_mhz: (params.rate_hz * 1e3).round() as u32,
        uid: Hello::RIG_UID,
        boot_id: params.boot_id,
        firmware: 1,
        channels: (0..n)
            .map(channel)
            .chain(temperature)
            .chain(load_sensors.into_iter().flat_map(LoadSensors::channels))
            .collect(),
        schema_crc: 0,
    };
    hello.seal();
    hello
}
