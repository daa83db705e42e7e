//! Messages live in Foxglove: a WebSocket server of its protocol, `foxglove.sdk.v1`.

use std::sync::Arc;

use foxglove::WebSocketServerHandle;
use foxglove::{ChannelBuilder, Context, PartialMetadata, RawChannel, Schema, WebSocketServer};

use crate::error::RosError;
use crate::sink::MessageSink;
use crate::topics::{RosParams, TopicKind, topics};

/// Messages that wait for a client at most; the oldest are dropped for one that is slower.
const BACKLOG: usize = 1024;

/// A server that shows messages to Foxglove. Clients get what they subscribe to; a slow client
/// loses messages and holds up nobody. Dropping it stops the server.
pub struct FoxgloveServer {
    channels: Vec<Arc<RawChannel>>,
    handle: Option<WebSocketServerHandle>,
    port: u16,
    /// The server does not keep it: without it channels are not announced.
    _context: Arc<Context>,
}

impl FoxgloveServer {
    /// Starts a server at `host` and `port`, 0 for any that is free. It has no passwords: bind it to
    /// 127.0.0.1 unless everyone on the network may look.
    ///
    /// # Errors
    /// A parameter that is out of range, an address that can't be bound.
    pub fn start(params: &RosParams, host: &str, port: u16) -> Result<Self, RosError> {
        let context = Context::new();
        let fault = |error: foxglove::FoxgloveError| RosError::Server {
            address: format!("{host}:{port}"),
            message: error.to_string(),
        };
        let mut channels = Vec::new();
        for topic in topics(params)? {
            let schema = topic.schema.into_bytes();
            let channel = ChannelBuilder::new(topic.name)
                .context(&context)
                .message_encoding(topic.message_encoding)
                .schema(Schema::new(topic.schema_name, topic.schema_encoding, schema))
                .build_raw();
            channels.push(channel.map_err(fault)?);
        }
        let handle = WebSocketServer::new()
            .name(params.name())
            .message_backlog_size(BACKLOG)
            .bind(host, port)
            .context(&context)
            .start_blocking()
            .map_err(fault)?;
        Ok(Self { channels, port: handle.port(), handle: Some(handle), _context: context })
    }

    /// The port it listens at.
    #[must_use]
    pub fn port(&self) -> u16 {
        self.port
    }

    /// Clients that are connected.
    #[must_use]
    pub fn n_clients(&self) -> usize {
        let handle = self.handle.as_ref();
        handle.map_or(0, WebSocketServerHandle::client_count)
    }
}

impl MessageSink for FoxgloveServer {
    fn put(&mut self, topic: TopicKind, stamp_ns: u64, message: &[u8]) {
        if let Some(channel) = self.channels.get(topic.number()) {
            let log_time = Some(stamp_ns);
            channel.log_with_meta(message, PartialMetadata { log_time });
        }
    }

    fn wants(&self, topic: TopicKind) -> bool {
        let channel = self.channels.get(topic.number());
        channel.is_some_and(|channel| channel.has_sinks())
    }
}

impl Drop for FoxgloveServer {
    fn drop(&mut self) {
        if let Some(handle) = self.handle.take() {
            // Clients are cut off; nobody waits for them.
            let _ = handle.stop();
        }
    }
}
