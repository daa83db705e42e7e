//! Messages beside the raw readings of a recording.

use hapdef_daq::record::TopicWriter;

use crate::sink::MessageSink;
use crate::topics::TopicKind;

/// Hands messages to a recorder that was started with [`crate::topics()`] among its parameters; the
/// recorder writes them on its own thread, by its own policy. A message that it can't take is
/// counted by it.
pub struct McapSink {
    writer: TopicWriter,
}

impl McapSink {
    /// A sink that writes to a recording: [`hapdef_daq::record::Recorder::topics`].
    #[must_use]
    pub fn new(writer: TopicWriter) -> Self {
        Self { writer }
    }
}

impl MessageSink for McapSink {
    fn put(&mut self, topic: TopicKind, stamp_ns: u64, message: &[u8]) {
        self.writer.put(topic.number(), stamp_ns, message.to_vec());
    }
}
