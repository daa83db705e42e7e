//! The server: one thread of its own.

use std::collections::VecDeque;
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::JoinHandle;
use std::time::Duration;

use axum::Router;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::sync::oneshot;
use tokio::task::AbortHandle;
use tokio::time::{interval, sleep, timeout};

use crate::client_stats::ClientInfo;
use crate::command::ViewCommand;
use crate::device::DeviceState;
use crate::error::ViewError;
use crate::feed::Feed;
use crate::frame::ViewFrame;
use crate::guard::{self, Guard};
use crate::offers::Offers;
use crate::params::ViewParams;
use crate::picture::LimbPicture;
use crate::site::{Site, router};
use crate::token::Token;

/// Time that a connection has for the head of a request, its first or a further one.
const HEAD_TIME: Duration = Duration::from_secs(5);
/// Time that a connection has until it is a page's: slow readers of a file go, too.
const PLAIN_TIME: Duration = Duration::from_secs(60);
/// Connections that are no page's yet: a browser opens six at a time. Where one more comes the oldest goes, so
/// that those that never ask for anything keep nobody out.
const MAX_PLAIN: usize = 64;
/// Pause after a connection that could not be accepted, as where no file handle is left.
const ACCEPT_PAUSE: Duration = Duration::from_millis(50);
/// Between looks for a release that found no room.
const SETTLE_TIME: Duration = Duration::from_millis(50);
/// Commands that wait for the program.
const MAX_COMMANDS: usize = 256;

/// The live page's server.
pub struct ViewServer;

/// A page that is served until this is dropped; a limb's page of several as long as any handle of them is there.
pub struct ViewHandle {
    pusher: ViewPusher,
    commands: Receiver<ViewCommand>,
    server: Arc<Running>,
}

/// The page of a robot: its limbs side by side, each with a page of its own, which [`Self::limb`] begins. It is
/// served until this and the handles of its limbs are dropped.
pub struct RobotView {
    server: Arc<Running>,
}

/// Hands on frames, from any thread.
#[derive(Clone)]
pub struct ViewPusher {
    feed: Arc<Feed>,
}

/// A server with its thread, which ends when this is dropped.
struct Running {
    site: Arc<Site>,
    patience: Duration,
    token: Token,
    address: SocketAddr,
    url: String,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl ViewServer {
    /// Listens and serves the page of one limb from a thread of its own.
    ///
    /// # Errors
    /// [`ViewError`] when the address cannot be used, the parameters or the picture are refused, or the
    /// system has neither randomness nor a thread to give.
    pub fn start(params: ViewParams, picture: LimbPicture) -> Result<ViewHandle, ViewError> {
        params.check()?;
        picture.check()?;
        let offers = params.offers.clone();
        let server = Arc::new(Running::start(params, Site::of_limb)?);
        server.limb("", offers, picture)
    }

    /// Listens and serves the page of a robot: at `/` its `limbs` side by side, at `/limb/NAME/` each by itself.
    /// A limb's page waits until [`RobotView::limb`] begins it. What pages can ask for is said there, limb by limb, not
    /// by `params`.
    ///
    /// # Errors
    /// As [`Self::start`]; [`ViewError::LimbName`] for a limb whose name is no word of letters, digits and _, or that is
    /// there twice.
    pub fn start_robot(
        params: ViewParams,
        robot: &str,
        limbs: &[String],
    ) -> Result<RobotView, ViewError> {
        params.check()?;
        check_names(limbs)?;
        let server = Running::start(params, |guard| Site::of_robot(guard, robot, limbs))?;
        Ok(RobotView { server: Arc::new(server) })
    }
}

impl RobotView {
    /// Begins the page of a limb that [`ViewServer::start_robot`] was told of.
    ///
    /// # Errors
    /// The picture or what it offers is refused; [`ViewError::NoSuchLimb`] for another limb, or one whose page is there.
    pub fn limb(
        &self,
        name: &str,
        offers: Offers,
        picture: LimbPicture,
    ) -> Result<ViewHandle, ViewError> {
        offers.check()?;
        picture.check()?;
        self.server.limb(name, offers, picture)
    }

    /// Where it listens.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.server.address
    }

    /// The robot's page's address with the token: for the person who started it, nobody else.
    #[must_use]
    pub fn url(&self) -> &str {
        &self.server.url
    }
}

impl ViewHandle {
    /// Hands on a frame: each page gets the newest when it is ready for one. Never waits for a page;
    /// costs a copy of the frame. Its number, by which [`ClientInfo::last_drawn`] reports that it was drawn.
    ///
    /// # Errors
    /// [`ViewError::FrameShape`], [`ViewError::ContactNumber`] when the frame does not fit the picture.
    pub fn push(&self, frame: &ViewFrame) -> Result<u64, ViewError> {
        self.pusher.push(frame)
    }

    /// Something that pushes from another thread.
    #[must_use]
    pub fn pusher(&self) -> ViewPusher {
        self.pusher.clone()
    }

    /// Says something to the people at the page, who see the latest only.
    pub fn say(&self, text: &str) {
        self.pusher.say(text);
    }

    /// Sends the device's state: to pages that are open, and those that come later.
    pub fn set_device(&self, state: &DeviceState) {
        self.pusher.feed.set_device(state);
    }

    /// What people do on the page. Commands beyond 256 that wait are refused.
    #[must_use]
    pub fn commands(&self) -> &Receiver<ViewCommand> {
        &self.commands
    }

    /// What the pages that are connected were sent.
    #[must_use]
    pub fn clients(&self) -> Vec<ClientInfo> {
        self.pusher.feed.clients()
    }

    /// Where it listens.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.server.address
    }

    /// The page's address with the token: for the person who started it, nobody else.
    #[must_use]
    pub fn url(&self) -> &str {
        &self.server.url
    }
}

impl ViewPusher {
    /// As [`ViewHandle::push`].
    ///
    /// # Errors
    /// As [`ViewHandle::push`].
    pub fn push(&self, frame: &ViewFrame) -> Result<u64, ViewError> {
        self.feed.push(frame)
    }

    /// As [`ViewHandle::say`].
    pub fn say(&self, text: &str) {
        self.feed.say(text);
    }
}

impl Running {
    fn start(params: ViewParams, site: impl FnOnce(Guard) -> Site) -> Result<Self, ViewError> {
        let token = params.token.clone().map_or_else(Token::random, Ok)?;
        let unusable = |source| ViewError::Bind { address: params.bind, source };
        let listener = TcpListener::bind(params.bind).map_err(unusable)?;
        listener.set_nonblocking(true).map_err(unusable)?;
        let address = listener.local_addr().map_err(unusable)?;
        let url = url(address, &params.allowed_hosts, &token);
        let site = Arc::new(site(Guard::new(address, &params.allowed_hosts)));
        let (stop, stopped) = oneshot::channel();
        let thread = spawn(listener, Arc::clone(&site), stopped)?;
        Ok(Self {
            site,
            patience: params.patience,
            token,
            address,
            url,
            stop: Some(stop),
            thread: Some(thread),
        })
    }

    /// Begins a limb's page.
    fn limb(
        self: &Arc<Self>,
        name: &str,
        offers: Offers,
        picture: LimbPicture,
    ) -> Result<ViewHandle, ViewError> {
        let (sender, commands) = sync_channel(MAX_COMMANDS);
        let feed = Arc::new(Feed::new(
            picture,
            offers,
            self.token.clone(),
            !self.address.ip().is_loopback(),
            self.patience,
            sender,
        ));
        if !self.site.begin(name, Arc::clone(&feed)) {
            return Err(ViewError::NoSuchLimb { name: name.to_owned() });
        }
        Ok(ViewHandle { pusher: ViewPusher { feed }, commands, server: Arc::clone(self) })
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Refuses names that are no part of an address, or are there twice.
fn check_names(limbs: &[String]) -> Result<(), ViewError> {
    let is_word = |name: &str| {
        !name.is_empty() && name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_')
    };
    for (i, name) in limbs.iter().enumerate() {
        if !is_word(name) || limbs[..i].contains(name) {
            return Err(ViewError::LimbName { found: name.clone() });
        }
    }
    Ok(())
}

fn url(address: SocketAddr, allowed_hosts: &[String], token: &Token) -> String {
    let host = match allowed_hosts.first() {
        Some(name) if address.ip().is_unspecified() => name.clone(),
        _ => guard::host_of(address.ip()),
    };
    format!("http://{host}:{}/#token={token}", address.port())
}

fn spawn(
    listener: TcpListener,
    site: Arc<Site>,
    stopped: oneshot::Receiver<()>,
) -> Result<JoinHandle<()>, ViewError> {
    let failed = |source| ViewError::Thread { source };
    let runtime =
        tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(failed)?;
    let entered = runtime.enter();
    let listener = tokio::net::TcpListener::from_std(listener).map_err(failed)?;
    drop(entered);
    let serve = async move {
        tokio::select! {
            () = settle(Arc::clone(&site)) => {}
            () = accept(listener, router(site)) => {}
            _ = stopped => {}
        }
    };
    std::thread::Builder::new()
        .name("hapdef-view".to_owned())
        .spawn(move || runtime.block_on(serve))
        .map_err(failed)
}

/// Serves everybody who connects, for ever.
async fn accept(listener: tokio::net::TcpListener, router: Router) {
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(HEAD_TIME);
    let mut plain = VecDeque::<AbortHandle>::with_capacity(MAX_PLAIN);
    loop {
        let Ok((stream, _)) = listener.accept().await else {
            sleep(ACCEPT_PAUSE).await;
            continue;
        };
        plain.retain(|connection| !connection.is_finished());
        if plain.len() >= MAX_PLAIN
            && let Some(oldest) = plain.pop_front()
        {
            oldest.abort();
        }
        let service = TowerToHyperService::new(router.clone());
        let connection = http.serve_connection(TokioIo::new(stream), service).with_upgrades();
        // It ends when it becomes a page's, which goes on by itself.
        plain.push_back(tokio::spawn(timeout(PLAIN_TIME, connection)).abort_handle());
    }
}

/// Sees to it that a press ends whose release found no room among the commands.
async fn settle(site: Arc<Site>) {
    let mut ticks = interval(SETTLE_TIME);
    loop {
        ticks.tick().await;
        site.feeds().for_each(|feed| feed.settle_press());
    }
}
