//! Where messages go.

use crate::topics::TopicKind;

/// Takes encoded messages. It must not wait for whoever reads them.
pub trait MessageSink: Send {
    /// Takes a message of a topic, little-endian CDR.
    fn put(&mut self, topic: TopicKind, stamp_ns: u64, message: &[u8]);

    /// Whether anyone wants the topic's messages now; what nobody wants is not encoded.
    fn wants(&self, _topic: TopicKind) -> bool {
        true
    }
}

/// Several sinks that get the same messages, encoded once.
#[derive(Default)]
pub struct Sinks(pub Vec<Box<dyn MessageSink>>);

impl MessageSink for Sinks {
    fn put(&mut self, topic: TopicKind, stamp_ns: u64, message: &[u8]) {
        for sink in &mut self.0 {
            if sink.wants(topic) {
                sink.put(topic, stamp_ns, message);
            }
        }
    }

    fn wants(&self, topic: TopicKind) -> bool {
        self.0.iter().any(|sink| sink.wants(topic))
    }
}

impl<S: MessageSink + ?Sized> MessageSink for Box<S> {
    fn put(&mut self, topic: TopicKind, stamp_ns: u64, message: &[u8]) {
        (**self).put(topic, stamp_ns, message);
    }

    fn wants(&self, topic: TopicKind) -> bool {
        (**self).wants(topic)
    }
}
