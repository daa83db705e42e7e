//! Where frames go: the trait, and what a sink wants.

use std::sync::{Arc, Mutex};

use hapdef_contact::TouchPhase;
use hapdef_daq::hdp1::{Hello, Status};
use hapdef_daq::source::LinkState;

use crate::error::AnyError;
use crate::estimator::TouchWanted;
use crate::frame::LiveFrame;
use crate::health::{ClientHealth, Health};
use crate::tare_fault::TareFault;

/// Takes frames and events. It runs on a thread of its own, and a slow one loses frames, which are
/// counted, instead of holding up others.
pub trait Sink: Send {
    /// What it is, in words.
    fn name(&self) -> String;

    /// What it needs; what no sink needs is not computed. Asked once.
    fn wants(&self) -> Wants;

    /// How it is given frames. Asked once.
    fn delivery(&self) -> Delivery {
        Delivery::Latest
    }

    /// A frame.
    ///
    /// # Errors
    /// Whatever makes it useless to go on; the sink is given up then, and the others go on.
    fn frame(&mut self, frame: &LiveFrame) -> Result<(), AnyError>;

    /// Something else, about when it happened.
    ///
    /// # Errors
    /// As [`Sink::frame`].
    fn event(&mut self, _event: &LiveEvent) -> Result<(), AnyError> {
        Ok(())
    }

    /// How its clients are doing, where it has any. Asked once, before it runs; what is in there is
    /// looked at for each health record.
    fn clients(&self) -> Option<Clients> {
        None
    }

    /// There will be no more; called once, unless it failed.
    ///
    /// # Errors
    /// What could not be brought to its end.
    fn finish(&mut self) -> Result<(), AnyError> {
        Ok(())
    }
}

/// The clients of a sink, for the health line.
pub type Clients = Arc<Mutex<Vec<ClientHealth>>>;

/// How a sink is given frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Delivery {
    /// The latest one whenever it is ready for one: for people.
    Latest,
    /// All, of which so many may wait; the newest are left out where there is no room: for files and
    /// programs.
    Queue(usize),
    /// All, within the computing thread, which waits for it: for a controller that needs the
    /// contacts at once and takes microseconds.
    Direct,
}

/// What a sink needs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wants {
    /// [`LiveFrame::raw_ue`] and times.
    pub raw: bool,
    /// [`LiveFrame::tared_ue`], [`LiveFrame::gauges`] and [`LiveFrame::phase`].
    pub tared: bool,
    /// [`LiveFrame::touch`]; takes the tared readings along.
    pub contacts: bool,
    /// Covariances of the contacts.
    pub uncertainty: bool,
    /// Other explanations.
    pub alternatives: bool,
    /// A [`LiveEvent::Health`] each second.
    pub health: bool,
}

/// What happens beside frames.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum LiveEvent {
    /// The device described itself: before its first frame and whenever that changes.
    Hello(Arc<Hello>),
    /// The device started anew: its time and numbers begin again.
    Restarted,
    /// What became of the link.
    Link(LinkState),
    /// How the device is doing.
    Status(Status),
    /// A line of text from the device.
    Log(Arc<str>),
    /// The baselines are known: from now on contacts are found.
    Tared,
    /// A tare was refused, or turned out to be wrong.
    TareFault(Arc<TareFault>),
    /// What is known of touch while no frame comes: when contacts become stale, when the phase becomes
    /// unknown, and twice a second from then on.
    Phase(PhaseStatus),
    /// How the runtime is doing; each second, to the sinks that want it, and at the end.
    Health(Arc<Health>),
}

/// What is known of touch while no frame comes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseStatus {
    /// The last frame's phase, or unknown.
    pub phase: TouchPhase,
    /// What the last frame said is old.
    pub is_stale: bool,
    /// Contacts that are not yet let go.
    pub n_contacts: usize,
    /// Time since the last usable frame, s.
    pub silent_s: f64,
}

/// A closure as a sink.
pub struct FnSink<F> {
    name: String,
    wants: Wants,
    delivery: Delivery,
    take: F,
}

impl Wants {
    /// Nothing.
    pub const NOTHING: Self = Self {
        raw: false,
        tared: false,
        contacts: false,
        uncertainty: false,
        alternatives: false,
        health: false,
    };
    /// Readings as they come.
    pub const RAW: Self = Self { raw: true, ..Self::NOTHING };
    /// Readings less what drifts.
    pub const TARED: Self = Self { tared: true, ..Self::RAW };
    /// Contacts without their covariance.
    pub const CONTACTS: Self = Self { contacts: true, ..Self::TARED };
    /// Everything.
    pub const ALL: Self =
        Self { uncertainty: true, alternatives: true, health: true, ..Self::CONTACTS };

    /// What either needs.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            raw: self.raw || other.raw,
            tared: self.tared || other.tared,
            contacts: self.contacts || other.contacts,
            uncertainty: self.uncertainty || other.uncertainty,
            alternatives: self.alternatives || other.alternatives,
            health: self.health || other.health,
        }
    }

    /// Whether contacts have to be found.
    #[must_use]
    pub fn has_contacts(self) -> bool {
        self.contacts || self.uncertainty || self.alternatives
    }

    /// Whether readings have to be conditioned.
    #[must_use]
    pub fn has_tared(self) -> bool {
        self.tared || self.has_contacts()
    }

    /// Whether readings have to be scaled.
    #[must_use]
    pub fn has_raw(self) -> bool {
        self.raw || self.has_tared()
    }

    pub(crate) fn of_touch(self) -> TouchWanted {
        TouchWanted { uncertainty: self.uncertainty, alternatives: self.alternatives }
    }
}

impl<F: FnMut(&LiveFrame) + Send> FnSink<F> {
    /// A sink that calls `take` with the latest frame whenever it is ready for one.
    pub fn new(name: &str, wants: Wants, take: F) -> Self {
        Self { name: name.to_owned(), wants, delivery: Delivery::Latest, take }
    }

    /// The same with another delivery.
    #[must_use]
    pub fn with_delivery(self, delivery: Delivery) -> Self {
        Self { delivery, ..self }
    }
}

impl<F: FnMut(&LiveFrame) + Send> Sink for FnSink<F> {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn wants(&self) -> Wants {
        self.wants
    }

    fn delivery(&self) -> Delivery {
        self.delivery
    }

    fn frame(&mut self, frame: &LiveFrame) -> Result<(), AnyError> {
        (self.take)(frame);
        Ok(())
    }
}
