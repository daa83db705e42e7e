//! Messages on the topics of ROS 2 by rmw_zenoh.

use zenoh::Wait;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::Publisher;

use crate::error::RosError;
use crate::rmw_names::{GID_LEN, Node, attachment, node_token, publisher_token, topic_key};
use crate::sink::MessageSink;
use crate::topics::{RosParams, TopicKind};
use crate::zenoh_session::{ROUTER, fault, open};

/// How ROS is reached.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ZenohParams {
    /// ROS_DOMAIN_ID.
    pub domain_id: u32,
    /// Name of the node in ROS's graph.
    pub node: String,
    /// Where the router is.
    pub connect: Vec<String>,
    /// Where to listen for peers, if anywhere.
    pub listen: Vec<String>,
}

/// Publishes messages so that nodes that run with rmw_zenoh receive them, and lists itself in their
/// graph. A message that a slow link can't take is dropped.
pub struct ZenohSink {
    publishers: Vec<OnePublisher>,
    _tokens: Vec<LivelinessToken>,
    session: zenoh::Session,
}

struct OnePublisher {
    publisher: Publisher<'static>,
    gid: [u8; GID_LEN],
    n_sent: i64,
}

impl Default for ZenohParams {
    /// Domain 0, node `hapdef`, the router where rmw_zenoh's nodes look for it.
    fn default() -> Self {
        Self {
            domain_id: 0,
            node: "hapdef".to_owned(),
            connect: vec![ROUTER.to_owned()],
            listen: Vec::new(),
        }
    }
}

impl ZenohSink {
    /// Opens a session and announces the topics.
    ///
    /// # Errors
    /// A parameter that is out of range, a router that is not there.
    pub fn open(params: &RosParams, zenoh: &ZenohParams) -> Result<Self, RosError> {
        params.check()?;
        let session = open(&zenoh.connect, &zenoh.listen)?;
        let zid = session.zid();
        let node =
            Node { domain_id: zenoh.domain_id, session: &zid.to_string(), name: &zenoh.node };
        let alive = |token: String| session.liveliness().declare_token(token).wait().map_err(fault);
        let mut tokens = vec![alive(node_token(&node))?];
        let mut publishers = Vec::new();
        for topic in TopicKind::all(params) {
            let (name, message) = (topic.name(params), topic.message());
            let key = topic_key(zenoh.domain_id, &name, message);
            let publisher = session.declare_publisher(key).wait().map_err(fault)?;
            let entity = topic.number() + 1;
            tokens.push(alive(publisher_token(&node, entity, &name, message))?);
            // Any identity will do that no other publisher has.
            let mut gid = zid.to_le_bytes();
            gid[0] = gid[0].wrapping_add(entity as u8);
            publishers.push(OnePublisher { publisher, gid, n_sent: 0 });
        }
        Ok(Self { publishers, _tokens: tokens, session })
    }

    /// Identity of the zenoh session.
    #[must_use]
    pub fn session_id(&self) -> String {
        self.session.zid().to_string()
    }
}

impl MessageSink for ZenohSink {
    fn put(&mut self, topic: TopicKind, stamp_ns: u64, message: &[u8]) {
        let Some(one) = self.publishers.get_mut(topic.number()) else {
            return;
        };
        one.n_sent += 1;
        let attachment = attachment(one.n_sent, stamp_ns, &one.gid);
        // A session that was lost comes back by itself; until then nobody listens.
        let _ = one.publisher.put(message).attachment(attachment).wait();
    }
}
