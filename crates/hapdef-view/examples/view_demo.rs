//! The live page with a made-up limb and made-up readings, to look at the page.
//!
//! `cargo run --release --example view_demo [PORT [SECONDS]]`
#![expect(clippy::print_stdout, reason = "says where the page is")]

#[path = "../tests/it/support/synthetic.rs"]
mod synthetic;

use std::error::Error;
use std::time::{Duration, Instant};

use hapdef_contact::GaugeHealth;
use hapdef_view::{
    Health, Offers, PressOffer, Recording, ViewCommand, ViewFrame, ViewHandle, ViewParams,
    ViewServer,
};
use synthetic::Touch;

const FRAME_TIME: Duration = Duration::from_millis(10);

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let mut params = ViewParams::default();
    if let Some(port) = args.next() {
        params.bind.set_port(port.parse()?);
    }
    let seconds: f64 = args.next().map_or(Ok(f64::INFINITY), |text| text.parse())?;
    params.offers = Offers {
        tare: true,
        record: true,
        press: Some(PressOffer { default_n: 5.0, max_n: 12.0 }),
    };
    let picture = synthetic::picture();
    let view = ViewServer::start(params, picture.clone())?;
    println!("Made-up limb, made-up readings: {}", view.url());
    let start = Instant::now();
    let mut demo = Demo::default();
    let mut frame = ViewFrame::default();
    while start.elapsed().as_secs_f64() < seconds {
        let t = start.elapsed().as_secs_f64();
        demo.listen(&view, t);
        let touches = match demo.pressed.as_slice() {
            [] => synthetic::wandering(t),
            pressed => pressed.to_vec(),
        };
        synthetic::show(&picture, &touches, t, &mut frame);
        demo.dress(&mut frame, t);
        view.push(&frame)?;
        std::thread::sleep(FRAME_TIME);
    }
    Ok(())
}

/// What the page asked for.
#[derive(Default)]
struct Demo {
    pressed: Vec<Touch>,
    recording_since: Option<f64>,
}

impl Demo {
    fn listen(&mut self, view: &ViewHandle, t: f64) {
        for command in view.commands().try_iter() {
            match command {
                ViewCommand::Press { finger, point_m, normal, force_n } => {
                    self.lift(finger);
                    self.pressed.push(Touch { id: 2 + finger, point_m, normal, force_n });
                }
                ViewCommand::Lift { finger } => self.lift(finger),
                ViewCommand::Release => self.pressed.clear(),
                ViewCommand::Record(on) => self.recording_since = on.then_some(t),
                ViewCommand::Tare => view.say("Tared"),
                ViewCommand::Snapshot { .. }
                | ViewCommand::Pause(_)
                | ViewCommand::Seek { .. }
                | ViewCommand::Random(_) => {}
            }
        }
    }

    fn lift(&mut self, finger: u32) {
        self.pressed.retain(|touch| touch.id != 2 + finger);
    }

    /// A dead gauge, a saturated one, another explanation, a rate.
    fn dress(&self, frame: &mut ViewFrame, t: f64) {
        frame.gauge_health[7] = GaugeHealth::Dead;
        for (reading, health) in frame.readings_ue.iter().zip(&mut frame.gauge_health) {
            if reading.abs() >= 200.0 {
                *health = GaugeHealth::Saturated;
            }
        }
        frame.alternatives.clear();
        if let [first, second] = frame.contacts.as_slice()
            && second.contact.force_n.powi(2) < 6.0
        {
            let (point_m, normal) = synthetic::on_limb(-0.3, 0.15);
            let merged = Touch { id: first.contact.number(0), point_m, normal, force_n: 5.5 };
            frame.alternatives.push((0.21, vec![synthetic::mark(&merged)]));
        }
        frame.health = Health {
            rate_hz: 1000.0,
            latency_p50_us: 412.0,
            latency_p99_us: 1180.0,
            clock_residual_us: 9.3,
            recording: self
                .recording_since
                .map_or(Recording::Off, |since| Recording::On { recorded_s: t - since }),
            ..Health::default()
        };
    }
}
