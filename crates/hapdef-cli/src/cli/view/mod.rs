//! `hapdef live --view`: contacts on the live page, recordings and snapshots from it, replays that it
//! steers, and the virtual rig that it can press.

mod first_paint;
mod opener;
mod page_session;
mod picture;
mod robot_page;
mod show;
mod sink;
mod snapshots;
mod virtual_press;

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, OnceLock};

use anyhow::{Result, ensure};
use clap::Args;
use hapdef::scene::Scene;
use hapdef::{ComplianceTable, Limb, Run};
use hapdef_daq::record::PlayerControl;
use hapdef_live::{Bundle, LiveControl};
use hapdef_view::{
    DeviceState, LimbPicture, Offers, PressOffer, Token, ViewHandle, ViewParams, ViewServer,
};

use super::live_record::LiveRecorder;
use super::network::check_reach;
pub(crate) use first_paint::{FirstPaint, FirstPaintParams};
use opener::PageOpener;
pub(crate) use page_session::PageSession;
use page_session::{Attendant, Pace};
use picture::Surface;
pub(crate) use robot_page::RobotPage;
use show::Show;
pub(crate) use sink::ViewSink;
use sink::{Newest, lock};
use snapshots::Snapshots;
pub(crate) use virtual_press::Sim;
use virtual_press::VirtualPress;

/// What may happen to a page that is served beyond this machine.
const PAGE_IS_READ: &str = "the page is not encrypted: whoever reads on the way learns its token, sees \
    everything and can command";

/// The page, and what stands in for a device.
#[derive(Args, Clone)]
pub(crate) struct ViewArgs {
    /// Show the live page; its address is printed. With --sim the limb can be pressed there.
    #[arg(long)]
    view: bool,
    /// Port of the page; 0 takes any free one.
    #[arg(long, default_value_t = 7717, value_name = "PORT")]
    view_port: u16,
    /// Address of this machine that the page is served at; beyond 127.0.0.1 with --insecure-bind only.
    #[arg(long, default_value_t = Ipv4Addr::LOCALHOST.into(), value_name = "ADDRESS")]
    view_bind: IpAddr,
    /// Further name of this machine, without port, that browsers may ask for; needed where the page
    /// is served at every address, such as 0.0.0.0.
    #[arg(long = "view-host", value_name = "NAME", requires = "view")]
    view_hosts: Vec<String>,
    /// Folder for recordings and snapshots that the page asks for; RESULTS/<scene>/live if not given.
    #[arg(long, value_name = "FOLDER", requires = "view")]
    view_out: Option<PathBuf>,
    /// Program that is started with a file that leads to the page, such as xdg-open.
    #[arg(long, value_name = "PROGRAM", requires = "view")]
    view_with: Option<PathBuf>,
    /// Token of the page, 32 hexadecimal digits; a new one if not given. Give it by the variable where
    /// others use the machine: they may read a command line.
    #[arg(long, env = "HAPDEF_VIEW_TOKEN", hide_env_values = true)]
    view_token: Option<Token>,
    /// Measure when the page first drew a contact.
    #[arg(long, hide = true, requires = "view")]
    view_first: bool,
}

/// The page that is served, before frames come.
pub(crate) struct View {
    handle: ViewHandle,
    surface: Surface,
    snapshots: Snapshots,
    opener: Option<PageOpener>,
    shared: Arc<Shared>,
    /// What lines on the terminal begin with.
    begin: String,
}

/// Where a limb's page is, and what it is of.
pub(crate) struct Place<'a> {
    pub(crate) origin: Origin,
    /// Folder of results.
    pub(crate) out: &'a Path,
    /// The robot's page that it is part of, and the limb's name there.
    pub(crate) robot: Option<(&'a RobotPage, &'a str)>,
}

/// Where frames come from, and what the page can do with that.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Origin {
    /// A device.
    Device,
    /// The virtual rig, which can be pressed.
    Sim,
    /// A recording.
    Recording,
}

/// What the page reaches beside the runtime.
pub(crate) struct Reach {
    pub(crate) sim: Option<Sim>,
    pub(crate) recorder: Option<LiveRecorder>,
    pub(crate) player: Option<PlayerControl>,
}

/// What the page's thread and the sink's have in common.
#[derive(Default)]
struct Shared {
    is_tared: AtomicBool,
    table: OnceLock<ComplianceTable>,
    newest: Mutex<Newest>,
}

impl ViewArgs {
    pub(crate) fn is_wanted(&self) -> bool {
        self.view
    }

    /// Refuses a page beyond this machine, unless that is wanted and its name is known.
    pub(crate) fn check_reach(&self, is_wanted: bool) -> Result<()> {
        let address = SocketAddr::from((self.view_bind, self.view_port));
        check_reach("--view-bind", address, PAGE_IS_READ, is_wanted)?;
        ensure!(
            !self.view_bind.is_unspecified() || !self.view_hosts.is_empty(),
            "--view-bind {address}: say by --view-host how browsers name this machine"
        );
        Ok(())
    }

    /// Whether it is measured when the page first drew a contact.
    pub(crate) fn is_first_measured(&self) -> bool {
        self.view_first
    }

    /// The page with a scene's limb.
    pub(crate) fn of_scene(&self, run: &Run, limb: &Limb, place: &Place<'_>) -> Result<View> {
        View::start(self, picture::of_scene(run, limb)?, press_offer(&run.scene), place)
    }

    /// The page with a bundle's skin.
    pub(crate) fn of_bundle(&self, bundle: &Bundle, place: &Place<'_>) -> Result<View> {
        let press = PressOffer { default_n: 1.0, max_n: 1.0 };
        View::start(self, picture::of_bundle(bundle), press, place)
    }

    /// Folder of what the page keeps; each limb of several has its own.
    fn folder(&self, place: &Place<'_>, scene: &str) -> PathBuf {
        match (&self.view_out, place.robot) {
            (Some(folder), None) => folder.clone(),
            (Some(folder), Some((_, limb))) => folder.join(limb),
            (None, None) => place.out.join(snapshots::stem(scene)).join("live"),
            (None, Some((robot, limb))) => place.out.join(robot.name()).join(limb).join("live"),
        }
    }

    /// Where it is served.
    fn params(&self, offers: Offers) -> ViewParams {
        ViewParams {
            bind: SocketAddr::from((self.view_bind, self.view_port)),
            allowed_hosts: self.view_hosts.clone(),
            token: self.view_token.clone(),
            offers,
            ..ViewParams::default()
        }
    }

    /// Tells where the page is, and opens it where that is wanted.
    fn tell(&self, url: &str, folder: &Path) -> Result<Option<PageOpener>> {
        eprintln!("live page: {url}");
        let open = |program: &PathBuf| -> Result<PageOpener> {
            let opener = PageOpener::new(folder, url)?;
            opener.open_with(program)?;
            Ok(opener)
        };
        self.view_with.as_ref().map(open).transpose()
    }
}

/// Presses of a scene's virtual limb.
pub(crate) fn press_offer(scene: &Scene) -> PressOffer {
    let force_n = scene.contact.force_range_n[1];
    PressOffer { default_n: 0.4 * force_n, max_n: force_n }
}

/// A scene's limb, as the page draws it.
pub(crate) fn scene_picture(run: &Run, limb: &Limb) -> Result<LimbPicture> {
    Ok(picture::of_scene(run, limb)?.0)
}

impl View {
    fn start(
        args: &ViewArgs,
        (mut picture, surface): (LimbPicture, Surface),
        press: PressOffer,
        place: &Place<'_>,
    ) -> Result<Self> {
        let origin = place.origin;
        let offers = Offers {
            tare: true,
            record: origin != Origin::Recording,
            press: (origin == Origin::Sim).then_some(press),
        };
        let scene = picture.title.clone();
        let folder = args.folder(place, &scene);
        let gauges = picture.gauges.iter().map(|site| site.name.clone());
        let snapshots = Snapshots::new(&folder, &scene, gauges.collect());
        let (handle, opener, begin) = match place.robot {
            Some((robot, name)) => {
                name.clone_into(&mut picture.title);
                (robot.limb(name, offers, picture)?, None, format!("{name}: "))
            }
            None => {
                let handle = ViewServer::start(args.params(offers), picture)?;
                let opener = args.tell(handle.url(), &folder)?;
                (handle, opener, String::new())
            }
        };
        let shared = Shared::default();
        let device = DeviceState { is_simulated: origin == Origin::Sim, fault: None };
        handle.set_device(&device);
        lock(&shared.newest).device = device;
        Ok(Self { handle, surface, snapshots, opener, shared: Arc::new(shared), begin })
    }

    /// Where frames go.
    pub(crate) fn sink(&self, is_recorded: bool) -> ViewSink {
        ViewSink { pusher: self.handle.pusher(), shared: Arc::clone(&self.shared), is_recorded }
    }

    /// Solves the limb's deformation, or reads it where it was solved, beside everything else; the
    /// page shows it from then on.
    pub(crate) fn solve_deformation(&self, run: Run, limb: Limb) {
        let (shared, pusher) = (Arc::clone(&self.shared), self.handle.pusher());
        std::thread::spawn(move || match hapdef::stages::compliance_table(&run, &limb) {
            Ok(table) => drop(shared.table.set(table)),
            Err(error) => pusher.say(&format!("no deformation: {error}")),
        });
    }

    /// Tells the page.
    pub(crate) fn say(&self, text: &str) {
        self.handle.pusher().say(text);
    }

    /// Shows frames, listens to the page and tells, if that is wanted, when it first drew a contact.
    pub(crate) fn attend(
        self,
        control: LiveControl,
        reach: Reach,
        first: Option<FirstPaint>,
    ) -> PageSession {
        let Reach { sim, recorder, player } = reach;
        let shared = Arc::clone(&self.shared);
        let show = Show::new(self.handle.pusher(), self.surface, shared, player.clone());
        PageSession::start(Attendant {
            handle: self.handle,
            shared: self.shared,
            show,
            snapshots: self.snapshots,
            control,
            virtual_press: sim.map(VirtualPress::new),
            recorder,
            player,
            first,
            pace: Pace::default(),
            begin: self.begin,
            _opener: self.opener,
        })
    }
}
