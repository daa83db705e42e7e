//! `hapdef calibrate --live`: guided presses from a port, or from the virtual rig's prober.

use std::sync::Arc;
use std::time::Duration;

use anyhow::{Result, bail, ensure};
use clap::Args;
use hapdef::session::{
    AskedPress, CalibrationSession, HeldPress, SessionEvent, SessionParams, write_press_table,
};
use hapdef::touch::{Calibration, PressQuality};
use hapdef::{Limb, Run, VirtualRigParams, live_limb, virtual_device};
use hapdef_daq::Message;
use hapdef_daq::hdp1::{ChannelKind, Hello};
use hapdef_daq::source::{
    FrameSource, SerialLink, SerialParams, SourceStatus, StreamParams, StreamSource, TcpLink,
};
use hapdef_inverse::CalibrationInfo;
use hapdef_rig::live::{PressHandle, Pressed, RigLink, RunParams};

use super::calibrate::CalibrateArgs;

/// Longest wait for bytes, so that Ctrl-C is seen.
const POLL: Duration = Duration::from_millis(20);

#[derive(Args)]
pub(crate) struct LiveArgs {
    /// Ask for presses and read them from a serial port, from `tcp:HOST:PORT`, or from `virtual`: the
    /// scene's simulated rig, pressed where it is asked for. The table is written then.
    #[arg(long, value_name = "PORT")]
    live: Option<String>,
    /// Presses to ask for.
    #[arg(long, default_value_t = 60, requires = "live")]
    presses: usize,
    /// Normal force to press with, N.
    #[arg(long, default_value_t = 10.0, requires = "live")]
    force_n: f64,
}

/// Frames, and who presses.
struct Feed {
    source: Box<dyn FrameSource>,
    /// The virtual rig's prober.
    prober: Option<PressHandle>,
    hello: Option<Arc<Hello>>,
}

impl LiveArgs {
    /// Whether presses come from a port instead of a table.
    pub(super) fn port(&self) -> Option<&str> {
        self.live.as_deref()
    }
}

/// Guides through the presses, writes the table, and calibrates.
pub(super) fn calibrate_live(
    args: &CalibrateArgs,
    port: &str,
    run: &Run,
    limb: &Limb,
) -> Result<(Calibration, CalibrationInfo)> {
    let (n_presses, force_n) = (args.live.presses, args.live.force_n);
    ensure!(n_presses > 0, "--presses: expected at least 1, found 0");
    ensure!(
        force_n > 0.0,
        "--force-n: expected a force above 0, found {force_n}"
    );
    let mut feed = Feed::open(port, run, limb)?;
    run.say(&format!("waiting for {}", feed.source.name()));
    let hello = feed.hello(run, limb.gauges.len())?;
    let quality = PressQuality {
        noise_ue: args.noise_ue,
        position_sd_m: args.position_sd_mm * 1e-3,
        force_sd_n: args.force_sd_n,
    };
    let rate_hz = f64::from(hello.rate_mhz) * 1e-3;
    run.say("solving the limb's response");
    let steps = hello.channels.iter().map(|c| f64::from(c.scale).abs());
    let params = SessionParams {
        step_ue: steps.take(limb.gauges.len()).collect(),
        ..SessionParams::new(n_presses, force_n, rate_hz, quality)
    };
    let mut session = CalibrationSession::new(run, limb, params)?;
    println!("taking the tare: don't touch the limb");
    feed.guide(run, &mut session, limb.gauges.len())?;
    write_press_table(&args.table, &session.rows())?;
    println!("{}", args.table.display());
    Ok(session.finish(run, limb)?)
}

impl Feed {
    fn open(port: &str, run: &Run, limb: &Limb) -> Result<Self> {
        let mut prober = None;
        let params = StreamParams::default();
        let source: Box<dyn FrameSource> = if port == "virtual" {
            let rig = Arc::new(live_limb(run, limb)?);
            let device = virtual_device(&run.scene, rig, &VirtualRigParams::default())?;
            prober = Some(device.press_handle());
            let link = RigLink::new(device, &RunParams::default(), |_| {})?;
            let clock = link.clock();
            Box::new(StreamSource::new(link, StreamParams { clock, ..params }))
        } else if let Some(address) = port.strip_prefix("tcp:") {
            Box::new(StreamSource::new(TcpLink::new(address), params))
        } else {
            let link = SerialLink::new(port, SerialParams::default());
            Box::new(StreamSource::new(link, params))
        };
        Ok(Self {
            source,
            prober,
            hello: None,
        })
    }

    /// Waits for what the device says about itself.
    fn hello(&mut self, run: &Run, n_gauges: usize) -> Result<Arc<Hello>> {
        loop {
            let mut said = None;
            self.poll(run, &mut |message| match message {
                Message::Hello(hello) => said = Some(hello),
                Message::Link(state) => run.say(&state.to_string()),
                _ => {}
            })?;
            let Some(hello) = said else { continue };
            let is_gauge = |kind| {
                use ChannelKind as K;
                matches!(kind, K::QuarterBridge | K::HalfBridge | K::FullBridge)
            };
            let leading = hello.channels.iter().take_while(|c| is_gauge(c.kind));
            let found = leading.count();
            ensure!(
                found == n_gauges,
                "the device has {found} bridges in front, the scene {n_gauges} gauges: expected \
                 the same number in the same order"
            );
            self.hello = Some(Arc::clone(&hello));
            return Ok(hello);
        }
    }

    fn guide(
        &mut self,
        run: &Run,
        session: &mut CalibrationSession,
        n_gauges: usize,
    ) -> Result<()> {
        let mut readings = [0.0; 64];
        let mut messages = Vec::new();
        loop {
            messages.clear();
            self.poll(run, &mut |message| messages.push(message))?;
            for message in messages.drain(..) {
                let frame = match message {
                    Message::Frame(frame) => frame,
                    Message::Hello(hello) => {
                        self.hello = Some(hello);
                        continue;
                    }
                    Message::Restarted => {
                        println!("the device started anew: don't touch the limb");
                        session.restart();
                        continue;
                    }
                    Message::Link(state) => {
                        println!("{state}");
                        continue;
                    }
                    _ => continue,
                };
                let Some(hello) = &self.hello else { continue };
                frame.scaled(hello, &mut readings);
                if let Some(event) = session.frame(&readings[..n_gauges])? {
                    say(&event);
                    self.probe(&event);
                    if event == SessionEvent::Done {
                        return Ok(());
                    }
                }
            }
        }
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

    fn poll(&mut self, run: &Run, sink: &mut dyn FnMut(Message)) -> Result<()> {
        run.check_stop("the calibration")?;
        if self.source.poll(POLL, sink) == SourceStatus::Ended {
            bail!("{}: it has ended", self.source.name());
        }
        Ok(())
    }
}

fn say(event: &SessionEvent) {
    match event {
        SessionEvent::Press(asked) => println!("{}", in_words(asked)),
        SessionEvent::Touched => println!("  hold still"),
        SessionEvent::LetGo => println!("  let go too early: press there again"),
        SessionEvent::GaugeOut(gauge) => {
            println!("  gauge {gauge} is saturated, stuck or jumping: press less, check its wires");
        }
        SessionEvent::Held(held) => println!("  let go; {}", held_in_words(held)),
        SessionEvent::Done => println!("done"),
    }
}

fn in_words(asked: &AskedPress) -> String {
    let [x, y, z] = (asked.position_m.coords * 1e3).into();
    let sd = asked.relative_sd.map_or(String::new(), |sd| {
        format!(", where the map is known to {:.1} %", sd * 100.0)
    });
    format!(
        "press {}: {} N at ({x:.1}, {y:.1}, {z:.1}) mm{sd}",
        asked.index + 1,
        asked.force_n
    )
}

fn held_in_words(held: &HeldPress) -> String {
    let progress = &held.progress;
    let map = progress.relative_error.map_or(String::new(), |e| {
        format!(", map good to {:.1} %", e * 100.0)
    });
    format!(
        "residual {:.1} %, {:.0} % of the skin covered{map}",
        held.residual * 100.0,
        progress.coverage * 100.0
    )
}
