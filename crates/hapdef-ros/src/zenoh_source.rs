//! The messages of a topic of ROS 2 by rmw_zenoh, as a source of frames.

use std::collections::BTreeSet;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use hapdef_daq::Message;
use hapdef_daq::clock::{HostClock, SystemClock};
use hapdef_daq::record::{Arrived, TopicReader};
use hapdef_daq::source::{
    FrameSource, LinkFault, LinkState, SourceStats, SourceStatus, TopicFault,
};
use zenoh::Wait;
use zenoh::pubsub::Subscriber;
use zenoh::sample::{Sample, SampleKind};

use crate::error::RosError;
use crate::rmw_names::{Publisher, messages_key, publishers_key, read_attachment, type_of_key};
use crate::schema::{READABLE, definition, type_hash};
use crate::topics::{TOPIC_NAME, is_topic_name};
use crate::zenoh_session::{ROUTER, fault, open};

/// After that long without a message the source says why.
const PATIENCE_NS: u64 = 2_000_000_000;
/// Messages that wait to be read at most: 4 s at 1 kHz. Those that find no room are missing by their numbers.
const N_WAITING: usize = 4096;
/// Messages handed out in one turn at most.
const N_AT_ONCE: usize = 256;
/// Topics that are named where the one asked for is not there.
const N_NAMED: usize = 12;

/// Which messages are read, and how ROS is reached.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ZenohSourceParams {
    /// ROS_DOMAIN_ID.
    pub domain_id: u32,
    /// The topic; of several lists of numbers in a message one is named behind a point: `/joint_states.effort`.
    pub topic: String,
    /// How many numbers without names a message has to have, if that is known.
    pub n_gauges: Option<usize>,
    /// Where the router is: `tcp/localhost:7447`.
    pub connect: Vec<String>,
    /// Where to listen for peers, if anywhere.
    pub listen: Vec<String>,
}

/// Frames of the messages that a node publishes with rmw_zenoh, as [`TopicReader`] makes them.
///
/// Gaps in the publisher's numbers are lost frames. A router that is not there, a topic that nobody publishes and
/// a publisher that is silent are reported after 2 s, and waited for; messages without numbers for these gauges end
/// it.
pub struct ZenohSource {
    params: ZenohSourceParams,
    samples: Receiver<Stamped>,
    /// Liveliness tokens of all publishers of the domain.
    publishers: Arc<Mutex<BTreeSet<String>>>,
    open: Option<OneType>,
    /// Messages come.
    is_heard: bool,
    /// When the last one came, or the source was opened, ns.
    heard_ns: u64,
    /// Why none come, as it was said last.
    said: Option<LinkState>,
    n_opened: u64,
    has_ended: bool,
    _subscribers: [Subscriber<()>; 2],
    session: zenoh::Session,
}

/// Messages of one type, that of the first.
struct OneType {
    key: String,
    reader: TopicReader,
}

/// A message with its arrival, ns on the host's monotonic clock.
type Stamped = (u64, Sample);

impl ZenohSourceParams {
    /// A topic in a domain, by the router where rmw_zenoh's nodes look for it.
    #[must_use]
    pub fn new(domain_id: u32, topic: &str) -> Self {
        Self {
            domain_id,
            topic: topic.to_owned(),
            n_gauges: None,
            connect: vec![ROUTER.to_owned()],
            listen: Vec::new(),
        }
    }

    /// The topic without the list of numbers.
    fn name(&self) -> &str {
        self.topic.split('.').next().unwrap_or_default()
    }

    fn check(&self) -> Result<(), RosError> {
        if is_topic_name(self.name()) {
            return Ok(());
        }
        let (name, expected, found) = ("topic", TOPIC_NAME, self.topic.clone());
        Err(RosError::Parameter { name, expected, found })
    }
}

impl ZenohSource {
    /// Opens a session and subscribes. The router may come later.
    ///
    /// # Errors
    /// [`RosError::Parameter`] for what is no topic's name, [`RosError::Zenoh`] for an address that is none.
    pub fn open(params: &ZenohSourceParams) -> Result<Self, RosError> {
        params.check()?;
        let session = open(&params.connect, &params.listen)?;
        let publishers = Arc::<Mutex<BTreeSet<String>>>::default();
        let (sender, samples) = sync_channel(N_WAITING);
        let graph = session
            .liveliness()
            .declare_subscriber(publishers_key(params.domain_id))
            .history(true)
            .callback(note(Arc::clone(&publishers)))
            .wait()
            .map_err(fault)?;
        let messages = session
            .declare_subscriber(messages_key(params.domain_id, params.name()))
            .callback(hand_on(sender))
            .wait()
            .map_err(fault)?;
        Ok(Self {
            params: params.clone(),
            samples,
            publishers,
            open: None,
            is_heard: false,
            heard_ns: SystemClock.now_ns(),
            said: None,
            n_opened: 0,
            has_ended: false,
            _subscribers: [graph, messages],
            session,
        })
    }

    fn take(
        &mut self,
        (arrival_ns, sample): &Stamped,
        sink: &mut dyn FnMut(Message),
    ) -> Result<(), TopicFault> {
        let key = sample.key_expr().as_str();
        if self.open.is_none() {
            let reader = self.reader_of(key)?;
            self.open = Some(OneType { key: key.to_owned(), reader });
        }
        let Some(open) = &mut self.open else { return Ok(()) };
        if open.key != key {
            let (of, first) = (type_of_key(key).0, type_of_key(&open.key).0);
            let why = format!("it is of {of}, the first was of {first}; start anew to read these");
            open.reader.leave_out(why, *arrival_ns, sink);
            return Ok(());
        }
        self.heard_ns = *arrival_ns;
        if !std::mem::replace(&mut self.is_heard, true) {
            self.n_opened += 1;
            self.said = None;
            sink(Message::Link(LinkState::Open));
        }
        let attachment = sample.attachment().map(zenoh::bytes::ZBytes::to_bytes);
        let bytes = sample.payload().to_bytes();
        let arrived = Arrived {
            numbered: attachment.as_deref().and_then(read_attachment),
            arrival_ns: *arrival_ns,
            bytes: &bytes,
        };
        open.reader.take(&arrived, sink)
    }

    /// Reads messages of a key, which has their type and the hash of its definition.
    fn reader_of(&self, key: &str) -> Result<TopicReader, TopicFault> {
        let (name, hash) = type_of_key(key);
        let definition = self.known(&name, hash)?;
        let reader = TopicReader::new(&self.params.topic, &name, &definition, self.params.n_gauges);
        reader.map_err(|fault| TopicFault::NoNumbers {
            topic: self.params.name().to_owned(),
            message: fault.to_string(),
        })
    }

    /// The definition of a type; that of another distribution of ROS may be another one.
    fn known(&self, name: &str, hash: &str) -> Result<String, TopicFault> {
        let is_other =
            hash.starts_with("RIHS01_") && type_hash(name).is_some_and(|known| known != hash);
        let other = |found: String| TopicFault::OtherType {
            topic: self.params.name().to_owned(),
            found,
            expected: format!("one of {}", READABLE.join(", ")),
        };
        match definition(name) {
            Some(definition) if !is_other => Ok(definition),
            Some(_) => Err(other(format!("{name} by another definition ({hash})"))),
            None => Err(other(name.to_owned())),
        }
    }

    /// Says why no message comes; an error where none will.
    fn look(&mut self, sink: &mut dyn FnMut(Message)) -> Result<(), TopicFault> {
        let quiet_ns = SystemClock.now_ns().saturating_sub(self.heard_ns);
        if self.open.is_some() && quiet_ns < PATIENCE_NS {
            return Ok(());
        }
        let (here, elsewhere) = self.publishers();
        let mut types = here.iter().map(|p| self.known(&p.message, &p.hash).map(drop));
        if self.open.is_none()
            && let Some(Err(fault)) = types.next()
            && types.all(|known| known.is_err())
        {
            return Err(fault);
        }
        if quiet_ns < PATIENCE_NS {
            return Ok(());
        }
        let state = self.why_quiet(&here, &elsewhere);
        if self.said.as_ref() != Some(&state) {
            self.said = Some(state.clone());
            self.is_heard = false;
            sink(Message::Link(state));
        }
        Ok(())
    }

    fn why_quiet(&self, here: &[Publisher], elsewhere: &[Publisher]) -> LinkState {
        let topic = self.params.name().to_owned();
        let name = format!("topic {topic}");
        if !here.is_empty() {
            let for_s = PATIENCE_NS / 1_000_000_000;
            return LinkState::Topic(TopicFault::Silent { topic, for_s });
        }
        if !self.is_connected() {
            let address = self.params.connect.join(", ");
            return LinkState::Away(LinkFault::NoRouter { name, address });
        }
        let named = elsewhere.iter().map(|p| format!("{} ({})", p.topic, p.message));
        let named: BTreeSet<String> = named.collect();
        let n_more = named.len().saturating_sub(N_NAMED);
        let mut words: Vec<String> = named.into_iter().take(N_NAMED).collect();
        match (words.is_empty(), n_more) {
            (true, _) => words.push("no topic".to_owned()),
            (false, 1..) => words.push(format!("{n_more} more")),
            (false, 0) => {}
        }
        let (domain_id, found) = (self.params.domain_id, words.join(", "));
        LinkState::Away(LinkFault::NoPublisher { name, domain_id, found })
    }

    /// Publishers of the topic, and those of others.
    fn publishers(&self) -> (Vec<Publisher>, Vec<Publisher>) {
        let tokens = self.publishers.lock().unwrap_or_else(PoisonError::into_inner);
        let all = tokens.iter().filter_map(|token| Publisher::of_token(token));
        all.partition(|publisher| publisher.topic == self.params.name())
    }

    fn is_connected(&self) -> bool {
        let info = self.session.info();
        info.routers_zid().wait().next().is_some() || info.peers_zid().wait().next().is_some()
    }

    /// What comes within `timeout`.
    fn read(&mut self, timeout: Duration, sink: &mut dyn FnMut(Message)) -> Result<(), TopicFault> {
        let Ok(first) = self.samples.recv_timeout(timeout) else {
            return self.look(sink);
        };
        self.take(&first, sink)?;
        for _ in 1..N_AT_ONCE {
            let Ok(next) = self.samples.try_recv() else { break };
            self.take(&next, sink)?;
        }
        Ok(())
    }
}

impl FrameSource for ZenohSource {
    fn poll(&mut self, timeout: Duration, sink: &mut dyn FnMut(Message)) -> SourceStatus {
        if self.has_ended {
            return SourceStatus::Ended;
        }
        if let Err(fault) = self.read(timeout, sink) {
            self.has_ended = true;
            sink(Message::Link(LinkState::Topic(fault)));
            return SourceStatus::Ended;
        }
        SourceStatus::Open
    }

    fn stats(&self) -> SourceStats {
        let stats = self.open.as_ref().map(|open| open.reader.stats()).unwrap_or_default();
        SourceStats { n_opened: self.n_opened, ..stats }
    }

    fn name(&self) -> String {
        format!("ros2:{}, topic {}", self.params.domain_id, self.params.topic)
    }
}

/// Notes who publishes.
fn note(publishers: Arc<Mutex<BTreeSet<String>>>) -> impl Fn(Sample) + Send + Sync + 'static {
    move |sample| {
        let mut tokens = publishers.lock().unwrap_or_else(PoisonError::into_inner);
        let token = sample.key_expr().as_str();
        match sample.kind() {
            SampleKind::Put => tokens.insert(token.to_owned()),
            SampleKind::Delete => tokens.remove(token),
        };
    }
}

/// Stamps messages as they come; zenoh's own thread must not wait.
fn hand_on(sender: SyncSender<Stamped>) -> impl Fn(Sample) + Send + Sync + 'static {
    move |sample| {
        if sample.kind() == SampleKind::Put {
            // One for which there is no room is missing by its number.
            let _ = sender.try_send((SystemClock.now_ns(), sample));
        }
    }
}
