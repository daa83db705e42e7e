//! `hapdef live --view`: contacts on the live page, and the virtual rig that it can press.

mod hand;
mod picture;
mod sink;

use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use anyhow::Result;
use clap::Args;
use hapdef::{ComplianceTable, Limb, Run};
use hapdef_live::{Bundle, LiveControl};
use hapdef_view::{
    LimbPicture, Offers, PressOffer, ViewCommand, ViewHandle, ViewParams, ViewServer,
};

use hand::Hand;
pub(crate) use hand::Sim;
use picture::Surface;
pub(crate) use sink::ViewSink;

/// How often it looks for commands and presses anew.
const LOOK: Duration = Duration::from_millis(5);

/// The page, and what stands in for a device.
#[derive(Args)]
pub(crate) struct ViewArgs {
    /// Show the live page; its address is printed. With --sim the limb can be pressed there.
    #[arg(long)]
    view: bool,
    /// Port of the page; 0 takes any free one.
    #[arg(long, default_value_t = 7717, value_name = "PORT")]
    view_port: u16,
}

/// The page that is served, before frames come.
pub(crate) struct View {
    handle: ViewHandle,
    surface: Surface,
    shared: Arc<Shared>,
}

/// The page with frames; it ends when this is dropped.
pub(crate) struct Desk {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// What the page's thread and the sink's have in common.
#[derive(Default)]
struct Shared {
    is_tared: AtomicBool,
    table: OnceLock<ComplianceTable>,
}

impl ViewArgs {
    /// The page with a scene's limb, if it is wanted; `is_sim`: it can be pressed.
    pub(crate) fn of_scene(&self, run: &Run, limb: &Limb, is_sim: bool) -> Result<Option<View>> {
        let force_n = run.scene.contact.force_range_n[1];
        let press = is_sim.then_some(PressOffer {
            default_n: 0.4 * force_n,
            max_n: force_n,
        });
        let page = || View::start(self, picture::of_scene(&run.scene, limb, is_sim), press);
        self.view.then(page).transpose()
    }

    /// The page with a bundle's skin, if it is wanted.
    pub(crate) fn of_bundle(&self, bundle: &Bundle) -> Result<Option<View>> {
        let page = || View::start(self, picture::of_bundle(bundle), None);
        self.view.then(page).transpose()
    }
}

impl View {
    fn start(
        args: &ViewArgs,
        (picture, surface): (LimbPicture, Surface),
        press: Option<PressOffer>,
    ) -> Result<Self> {
        let mut params = ViewParams::default();
        params.bind.set_port(args.view_port);
        params.offers = Offers {
            tare: true,
            record: false,
            press,
        };
        let handle = ViewServer::start(params, picture)?;
        writeln!(std::io::stderr(), "live page: {}", handle.url())?;
        Ok(Self {
            handle,
            surface,
            shared: Arc::default(),
        })
    }

    /// Where frames go; those of a recording have no delay that could be told.
    pub(crate) fn sink(&self, is_recorded: bool) -> ViewSink {
        let shared = Arc::clone(&self.shared);
        ViewSink::new(
            self.handle.pusher(),
            self.surface.clone(),
            shared,
            is_recorded,
        )
    }

    /// Solves the limb's deformation, or reads it where it was solved, beside everything else; the
    /// page shows it from then on.
    pub(crate) fn solve_deformation(&self, run: Run, limb: Limb) {
        let (shared, pusher) = (Arc::clone(&self.shared), self.handle.pusher());
        std::thread::spawn(
            move || match hapdef::stages::compliance_table(&run, &limb) {
                Ok(table) => drop(shared.table.set(table)),
                Err(error) => pusher.say(&format!("no deformation: {error}")),
            },
        );
    }

    /// Listens to the page. The first picture's time is told: from `start`, and not on the standard
    /// output if that `is_taken`.
    pub(crate) fn attend(
        self,
        control: LiveControl,
        sim: Option<Sim>,
        (start, is_taken): (Instant, bool),
    ) -> Desk {
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let mut desk = Attendant {
            handle: self.handle,
            shared: self.shared,
            control,
            hand: sim.map(Hand::new),
            start,
            is_taken,
            has_shown: false,
        };
        let attend = move || {
            while !stopped.load(Ordering::Relaxed) {
                desk.step();
                std::thread::sleep(LOOK);
            }
        };
        Desk {
            stop,
            thread: Some(std::thread::spawn(attend)),
        }
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

struct Attendant {
    handle: ViewHandle,
    shared: Arc<Shared>,
    control: LiveControl,
    hand: Option<Hand>,
    start: Instant,
    is_taken: bool,
    has_shown: bool,
}

impl Attendant {
    fn step(&mut self) {
        let commands: Vec<ViewCommand> = self.handle.commands().try_iter().collect();
        for command in commands {
            self.obey(command);
        }
        if let Some(hand) = &mut self.hand {
            hand.step(self.shared.is_tared.load(Ordering::Relaxed));
        }
        if !self.has_shown && self.handle.clients().iter().any(|page| page.n_drawn > 0) {
            self.has_shown = true;
            self.tell_time();
        }
    }

    /// It is lost where nobody reads it any more.
    fn tell_time(&self) {
        let elapsed_s = self.start.elapsed().as_secs_f64();
        let line = format!("METRIC:view.first_picture_s:{elapsed_s:.2}:s");
        let _ = if self.is_taken {
            writeln!(std::io::stderr(), "{line}")
        } else {
            writeln!(std::io::stdout(), "{line}")
        };
    }

    fn obey(&mut self, command: ViewCommand) {
        match command {
            ViewCommand::Tare => {
                self.shared.is_tared.store(false, Ordering::Relaxed);
                self.control.tare();
                self.handle.say("Taring: touch nothing");
            }
            ViewCommand::Press {
                point_m, force_n, ..
            } => {
                if let Some(hand) = &mut self.hand {
                    hand.press(point_m, force_n);
                }
            }
            ViewCommand::Release => {
                if let Some(hand) = &mut self.hand {
                    hand.release();
                }
            }
            ViewCommand::Record(_)
            | ViewCommand::Snapshot
            | ViewCommand::Pause(_)
            | ViewCommand::Seek { .. } => {}
        }
    }
}
