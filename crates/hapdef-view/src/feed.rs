//! What the pusher and the clients share.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{SyncSender, TrySendError};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use arc_swap::{ArcSwap, ArcSwapOption};
use axum::body::Bytes;

use crate::client_stats::{ClientInfo, ClientStats};
use crate::command::ViewCommand;
use crate::device::DeviceState;
use crate::error::ViewError;
use crate::frame::ViewFrame;
use crate::offers::Offers;
use crate::picture::LimbPicture;
use crate::token::Token;
use crate::wire;

/// Most pages at a time.
pub(crate) const MAX_CLIENTS: usize = 8;

/// What the pusher and the clients share.
pub(crate) struct Feed {
    pub(crate) picture: LimbPicture,
    pub(crate) offers: Offers,
    pub(crate) token: Token,
    /// Whether nothing is shown without the token.
    pub(crate) token_always: bool,
    /// How long a page may answer nothing.
    pub(crate) patience: Duration,
    pub(crate) surface: Bytes,
    pub(crate) commands: SyncSender<ViewCommand>,
    latest: ArcSwapOption<Numbered<Bytes>>,
    notice: ArcSwapOption<Numbered<String>>,
    device: ArcSwap<Numbered<String>>,
    n_pushed: AtomicU64,
    n_clients: AtomicUsize,
    clients: Mutex<Vec<Arc<ClientStats>>>,
    pressed: Mutex<Pressed>,
}

/// Who presses the limb.
#[derive(Default)]
struct Pressed {
    by: Option<Arc<ClientStats>>,
    /// The press has ended, and could not be reported yet.
    owes_release: bool,
}

/// A value with its number, from 1.
pub(crate) struct Numbered<T> {
    pub(crate) seq: u64,
    pub(crate) value: T,
}

/// One of the places for clients, given back when dropped.
pub(crate) struct Place {
    pub(crate) feed: Arc<Feed>,
}

impl Feed {
    pub(crate) fn new(
        picture: LimbPicture,
        offers: Offers,
        token: Token,
        token_always: bool,
        patience: Duration,
        commands: SyncSender<ViewCommand>,
    ) -> Self {
        let device = Numbered { seq: 1, value: wire::device(&DeviceState::default()) };
        Self {
            surface: wire::surface(&picture).into(),
            picture,
            offers,
            token,
            token_always,
            patience,
            commands,
            latest: ArcSwapOption::empty(),
            notice: ArcSwapOption::empty(),
            device: ArcSwap::from_pointee(device),
            n_pushed: AtomicU64::new(0),
            n_clients: AtomicUsize::new(0),
            clients: Mutex::new(Vec::new()),
            pressed: Mutex::default(),
        }
    }

    /// Its number.
    pub(crate) fn push(&self, frame: &ViewFrame) -> Result<u64, ViewError> {
        frame.check(self.picture.vertices_m.len(), self.picture.gauges.len())?;
        let seq = self.n_pushed.fetch_add(1, Ordering::Relaxed) + 1;
        let value = wire::frame(frame, seq).into();
        self.latest.store(Some(Arc::new(Numbered { seq, value })));
        Ok(seq)
    }

    pub(crate) fn say(&self, text: &str) {
        self.notice.rcu(|before| {
            let seq = before.as_ref().map_or(0, |notice| notice.seq) + 1;
            let value = hapdef_contact::printable(text);
            Some(Arc::new(Numbered { seq, value }))
        });
    }

    pub(crate) fn set_device(&self, state: &DeviceState) {
        let before = self.device();
        let value = wire::device(state);
        if value != before.value {
            let seq = before.seq + 1;
            self.device.store(Arc::new(Numbered { seq, value }));
        }
    }

    /// What is known of the device.
    pub(crate) fn device(&self) -> Arc<Numbered<String>> {
        self.device.load_full()
    }

    /// The newest frame, unless it is number `seen`.
    pub(crate) fn frame_after(&self, seen: u64) -> Option<Arc<Numbered<Bytes>>> {
        self.latest.load_full().filter(|frame| frame.seq != seen)
    }

    /// The newest notice, unless it is number `seen`.
    pub(crate) fn notice_after(&self, seen: u64) -> Option<Arc<Numbered<String>>> {
        self.notice.load_full().filter(|notice| notice.seq != seen)
    }

    pub(crate) fn last_notice(&self) -> u64 {
        self.notice.load().as_ref().map_or(0, |notice| notice.seq)
    }

    pub(crate) fn n_pushed(&self) -> u64 {
        self.n_pushed.load(Ordering::Relaxed)
    }

    pub(crate) fn clients(&self) -> Vec<ClientInfo> {
        let clients = self.clients.lock().unwrap_or_else(PoisonError::into_inner);
        let n_pushed = self.n_pushed();
        clients.iter().map(|client| client.info(n_pushed)).collect()
    }

    pub(crate) fn enter(&self, client: &Arc<ClientStats>) {
        let mut clients = self.clients.lock().unwrap_or_else(PoisonError::into_inner);
        clients.push(Arc::clone(client));
    }

    pub(crate) fn leave(&self, client: &Arc<ClientStats>) {
        let mut clients = self.clients.lock().unwrap_or_else(PoisonError::into_inner);
        clients.retain(|other| !Arc::ptr_eq(other, client));
    }

    /// Hands on a press of a page, whose press it is from then on.
    pub(crate) fn press(
        &self,
        page: &Arc<ClientStats>,
        press: ViewCommand,
    ) -> Result<(), TrySendError<ViewCommand>> {
        let mut pressed = self.pressed();
        self.commands.try_send(press)?;
        *pressed = Pressed { by: Some(Arc::clone(page)), owes_release: false };
        Ok(())
    }

    /// Ends the press if it is this page's; where too many commands wait, as soon as there is room.
    pub(crate) fn end_press(&self, page: &Arc<ClientStats>) {
        let mut pressed = self.pressed();
        let is_its_own = |by: &mut Arc<ClientStats>| Arc::ptr_eq(by, page);
        if pressed.by.take_if(is_its_own).is_some() {
            pressed.owes_release = !self.release();
        }
    }

    /// Hands on a release that found no room.
    pub(crate) fn settle_press(&self) {
        let mut pressed = self.pressed();
        pressed.owes_release = pressed.owes_release && !self.release();
    }

    /// Whether the release has been reported.
    fn release(&self) -> bool {
        let sent = self.commands.try_send(ViewCommand::Release);
        !matches!(sent, Err(TrySendError::Full(_)))
    }

    fn pressed(&self) -> MutexGuard<'_, Pressed> {
        self.pressed.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A place for a client, `None` when all are taken.
    pub(crate) fn place(self: &Arc<Self>) -> Option<Place> {
        let more = |n: usize| (n < MAX_CLIENTS).then_some(n + 1);
        self.n_clients.fetch_update(Ordering::AcqRel, Ordering::Acquire, more).ok()?;
        Some(Place { feed: Arc::clone(self) })
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.feed.n_clients.fetch_sub(1, Ordering::AcqRel);
    }
}
