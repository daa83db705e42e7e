//! `hapdef calibrate --live`: guided presses from a port, or from the virtual rig's prober.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Result, bail, ensure};
use hapdef::session::{CalibrationSession, SessionEvent, SessionParams, write_press_table};
use hapdef::touch::{Calibration, PressQuality};
use hapdef::{Limb, Run, SourceArg, VirtualRigParams, live_limb, virtual_device};
use hapdef_cli::shown;
use hapdef_daq::hdp1::{Channel, Hello, MAX_CHANNELS, Status};
use hapdef_daq::source::{FrameSource, ReplaySource, SourceStatus, StreamParams, StreamSource};
use hapdef_daq::{Frame, Message};
use hapdef_inverse::{CalibrationInfo, LEAST_PRESSES};
use hapdef_live::gauge_channels;
use hapdef_rig::live::{PressHandle, Pressed, RigLink, RunParams};

use super::backlog::Backlog;
use super::calibrate_args::{CalibrateArgs, PressSource};
use super::calibrate_words::say;

/// Longest wait for bytes, so that Ctrl-C is seen.
const POLL: Duration = Duration::from_millis(20);

/// Frames, and who presses.
struct Feed {
    source: Box<dyn FrameSource>,
    /// The virtual rig's prober.
    prober: Option<PressHandle>,
    hello: Option<Arc<Hello>>,
    /// Channel of each gauge.
    channels: Vec<usize>,
    /// What the device said last of itself.
    status: Status,
    /// See [`SessionParams::rails_ue`].
    rails_ue: Vec<(f64, f64)>,
    /// What was sent while presses were fitted, of presses that nobody asked for.
    backlog: Backlog,
}

/// Guides through the presses, writes the table, and calibrates.
pub(super) fn calibrate_live(
    args: &CalibrateArgs,
    source: &PressSource,
    run: &Run,
    limb: &Limb,
) -> Result<(Calibration, CalibrationInfo)> {
    let (n_presses, force_n) = (args.live.presses, args.live.force_n);
    ensure!(
        n_presses >= LEAST_PRESSES,
        "--presses: expected at least {LEAST_PRESSES}, without which there is no calibration, found {n_presses}"
    );
    ensure!(force_n > 0.0, "--force-n: expected a force above 0, found {force_n}");
    let table = &args.table;
    ensure!(
        !table.exists(),
        "{}: is there already, and the presses would overwrite it: name a new table, or calibrate \
         with that one, without --live",
        shown(table)
    );
    let mut feed = Feed::open(source, run, limb)?;
    run.say(&format!("waiting for {}", feed.source.name()));
    let hello = feed.hello(run)?;
    let rate_hz = feed.rate_hz(run, &hello)?;
    let quality = PressQuality {
        noise_ue: args.noise_ue,
        position_sd_m: args.position_sd_mm * 1e-3,
        force_sd_n: args.force_sd_n,
    };
    let steps = feed.channels.iter().map(|&i| hello.channels[i].scale);
    let params = SessionParams {
        step_ue: steps.map(|scale| f64::from(scale).abs()).collect(),
        rails_ue: feed.rails_ue.clone(),
        ..SessionParams::new(n_presses, force_n, rate_hz, quality)
    };
    let mut session = CalibrationSession::new(run, limb, params)?;
    if let PressSource::Device(device) = source {
        feed.open_again(device, run, limb)?;
        feed.backlog = Backlog::new(rate_hz);
    }
    run.say("taking the tare in a second: don't touch the limb");
    if !feed.guide(run, &mut session, table)? {
        let n = session.rows().len();
        ensure!(n > 0, "stopped before the first press was kept");
        let table = shown(table);
        bail!("stopped after {n} presses; {table} has them: calibrate with it, without --live");
    }
    run.say(&format!("presses: {}", shown(table)));
    Ok(session.finish(run, limb)?)
}

impl Feed {
    fn open(source: &PressSource, run: &Run, limb: &Limb) -> Result<Self> {
        let mut prober = None;
        let source = match source {
            PressSource::Device(source) => source.open_for(limb.gauges.len())?,
            PressSource::Virtual => {
                let rig = Arc::new(live_limb(run, limb)?);
                let device = virtual_device(&run.scene, rig, &VirtualRigParams::default())?;
                prober = Some(device.press_handle());
                let link = RigLink::new(device, &RunParams::default(), |_| {})?;
                let clock = link.clock();
                let params = StreamParams { clock, ..StreamParams::default() };
                Box::new(StreamSource::new(link, params))
            }
        };
        Ok(Self {
            source,
            prober,
            hello: None,
            channels: Vec::new(),
            status: Status::default(),
            rails_ue: Vec::new(),
            backlog: Backlog::default(),
        })
    }

    /// Opens a device anew, so that what it sent while nobody read is gone.
    fn open_again(&mut self, device: &SourceArg, run: &Run, limb: &Limb) -> Result<()> {
        let nobody = ReplaySource::new("nobody", std::iter::empty(), 1.0);
        // A port has one reader.
        drop(std::mem::replace(&mut self.source, Box::new(nobody)));
        self.source = device.open_for(limb.gauges.len())?;
        let before = self.hello.take();
        let now = self.hello(run)?;
        self.hello = before;
        self.is_the_same(&now)
    }

    /// Waits for what the device says about itself, and finds the gauges among its channels.
    fn hello(&mut self, run: &Run) -> Result<Arc<Hello>> {
        loop {
            let mut said = None;
            run.check_stop("the calibration")?;
            self.poll(&mut |message| match message {
                Message::Hello(hello) => said = Some(hello),
                Message::Link(state) => run.say(&state.to_string()),
                _ => {}
            })?;
            let Some(hello) = said else { continue };
            let sites = &run.scene.gauges.sites;
            let names = sites.iter().map(|site| site.name.as_str());
            self.channels = gauge_channels(&hello.channels, names, Some(sites.len()))?;
            self.rails_ue = rails_ue(&hello, &self.channels);
            self.hello = Some(Arc::clone(&hello));
            return Ok(hello);
        }
    }

    /// Frames per second: as announced, or as they come from a device that announces none.
    fn rate_hz(&mut self, run: &Run, hello: &Hello) -> Result<f64> {
        if hello.rate_mhz > 0 {
            return Ok(f64::from(hello.rate_mhz) * 1e-3);
        }
        run.say("measuring the rate, which the device does not announce");
        loop {
            run.check_stop("the calibration")?;
            self.poll(&mut |_| {})?;
            let rate_hz = self.source.stats().rate_hz;
            if rate_hz > 0.0 {
                run.say(&format!("{rate_hz:.1} frames per second"));
                return Ok(rate_hz);
            }
        }
    }

    /// Guides to the end, the table written after each press; false when the person stops it.
    fn guide(&mut self, run: &Run, session: &mut CalibrationSession, table: &Path) -> Result<bool> {
        let mut messages = Vec::new();
        while !run.stopping() {
            self.poll(&mut |message| messages.push(message))?;
            self.backlog.read(&messages);
            for message in messages.drain(..) {
                if self.backlog.has(&message) {
                    continue;
                }
                let start = Instant::now();
                let Some(event) = self.take(run, session, message)? else {
                    continue;
                };
                self.backlog.grow(start.elapsed());
                say(run, &event);
                self.probe(&event);
                match event {
                    SessionEvent::Held(_) => write_press_table(table, &session.rows())?,
                    SessionEvent::Done => return Ok(true),
                    _ => {}
                }
            }
        }
        Ok(false)
    }

    fn take(
        &mut self,
        run: &Run,
        session: &mut CalibrationSession,
        message: Message,
    ) -> Result<Option<SessionEvent>> {
        match message {
            Message::Frame(frame) => {
                let mut readings = [0.0; MAX_CHANNELS];
                let readings = &mut readings[..self.channels.len()];
                if self.read(&frame, readings) {
                    return Ok(session.frame(readings)?);
                }
            }
            Message::Hello(hello) => self.is_the_same(&hello)?,
            Message::Status(status) => self.status = status,
            Message::Restarted => {
                run.say("the device started anew: don't touch the limb");
                session.restart();
            }
            Message::Link(state) => run.say(&state.to_string()),
            _ => {}
        }
        Ok(None)
    }

    /// The gauges' readings, µε, into `readings` `[n_gauges]`; false before the device has described
    /// itself. Gauges that it says are saturated are put at the end of their range: its converter may
    /// have fewer bits than its numbers.
    fn read(&self, frame: &Frame, readings: &mut [f64]) -> bool {
        let Some(hello) = &self.hello else {
            return false;
        };
        let mut scaled = [0.0; MAX_CHANNELS];
        frame.scaled(hello, &mut scaled);
        let saturated = frame.saturated(&self.status);
        for (gauge, (reading, &channel)) in readings.iter_mut().zip(&self.channels).enumerate() {
            *reading = scaled[channel];
            if saturated >> channel & 1 == 1 {
                let end = self.rails_ue.get(gauge);
                *reading = end.map_or(f64::NAN, |(_, high)| *high);
            }
        }
        true
    }

    /// Presses of two devices, or in two scales, make no calibration.
    fn is_the_same(&self, new: &Hello) -> Result<()> {
        let of = |hello: &Hello| {
            let uid: String = hello.uid.iter().map(|b| format!("{b:02x}")).collect();
            let (n, hz) = (hello.channels.len(), f64::from(hello.rate_mhz) * 1e-3);
            format!("device {uid}, {n} channels, {hz} Hz")
        };
        let Some(old) = &self.hello else {
            return Ok(());
        };
        let key = |hello: &Hello| (hello.uid, hello.schema_crc);
        ensure!(
            key(old) == key(new),
            "the presses began with {} and go on with {}, or with other scales: the table has those \
             that were held; calibrate with it, without --live, or begin again",
            of(old),
            of(new)
        );
        Ok(())
    }

    /// Presses the virtual rig as the session asks.
    fn probe(&self, event: &SessionEvent) {
        let Some(prober) = &self.prober else { return };
        match event {
            SessionEvent::Press(asked) => {
                let press = Pressed::normal(1, asked.position_m, asked.force_n);
                prober.set(vec![press]);
            }
            SessionEvent::Held(_) => prober.set(Vec::new()),
            _ => {}
        }
    }

    fn poll(&mut self, sink: &mut dyn FnMut(Message)) -> Result<()> {
        if self.source.poll(POLL, sink) == SourceStatus::Ended {
            bail!("{}: it has ended", self.source.name());
        }
        Ok(())
    }
}

/// Lowest and highest reading of each gauge, µε; empty where there are no limits.
fn rails_ue(hello: &Hello, channels: &[usize]) -> Vec<(f64, f64)> {
    let Some([low, high]) = hello.count_range() else {
        return Vec::new();
    };
    let channels = channels.iter().map(|&i| &hello.channels[i]);
    let ends = |c: &Channel| {
        let of = |count: f64| count * f64::from(c.scale) + f64::from(c.offset);
        (of(low).min(of(high)), of(low).max(of(high)))
    };
    channels.map(ends).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use hapdef_daq::hdp1::{FrameFlags, SampleFormat};

    #[test]
    fn each_gauge_reads_the_channel_of_its_name() {
        let hello = Hello::plain(4, SampleFormat::I16, 500);
        let names = ["g3", "g0", "g1"];
        let channels = gauge_channels(&hello.channels, names, Some(3)).unwrap();
        let mut feed = Feed {
            source: Box::new(ReplaySource::new("none", std::iter::empty(), 1.0)),
            prober: None,
            rails_ue: rails_ue(&hello, &channels),
            hello: None,
            channels,
            backlog: Backlog::default(),
            status: Status { saturated: 1 << 2 | 1 << 1, ..Status::default() },
        };
        let mut frame = Frame::new(0, SampleFormat::I16, [10, 20, 30, 40]);
        let mut readings = [0.0; 3];
        assert!(!feed.read(&frame, &mut readings));
        feed.hello = Some(Arc::new(hello));
        assert!(feed.read(&frame, &mut readings));
        assert_eq!(readings, [40.0, 10.0, 20.0]);
        frame.flags = FrameFlags::SATURATED;
        assert!(feed.read(&frame, &mut readings));
        assert_eq!(readings, [40.0, 10.0, 32767.0]);
    }
}
