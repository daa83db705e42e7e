//! Topics that other crates add to a recording, beside the readings.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use serde_json::{Value, json};

/// Channel number of the first of these topics; the readings' own are below.
const FIRST_ID: u16 = 16;
/// Messages that wait for the writer at most: over a second of what a limb says at 1 kHz.
pub(crate) const QUEUE_LEN: usize = 8192;
/// Longest message, so that no chunk grows beyond 256 KiB.
pub const MAX_MESSAGE_LEN: usize = 60 << 10;

/// A topic beside the readings: its name, and how its messages are to be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TopicDef {
    /// Name, such as `/hapdef/contacts`.
    pub name: String,
    /// Encoding of its messages, by MCAP's registry: `cdr`, `json`.
    pub message_encoding: String,
    /// Name of the schema, such as `geometry_msgs/msg/WrenchStamped`.
    pub schema_name: String,
    /// Encoding of the schema, by MCAP's registry: `ros2msg`, `jsonschema`.
    pub schema_encoding: String,
    /// The schema.
    pub schema: String,
}

/// Hands messages of further topics to a recorder, from any thread.
#[derive(Clone)]
pub struct TopicWriter {
    sender: SyncSender<Put>,
    n_dropped: Arc<AtomicU64>,
    wall_offset_ns: u64,
}

/// A message on its way to the writer.
pub(crate) struct Put {
    pub(crate) channel: u16,
    pub(crate) log_time_ns: u64,
    pub(crate) message: Vec<u8>,
}

/// The writer's end.
pub(crate) struct Puts {
    pub(crate) receiver: Receiver<Put>,
    pub(crate) n_dropped: Arc<AtomicU64>,
}

impl TopicWriter {
    /// Hands over a message of topic number `topic` (its place in
    /// [`super::RecordParams::topics`]), `log_time_ns` since 1970 UTC, and never waits. False if it was not
    /// taken: the disk was too slow for too long, the recording has ended, or it is longer than
    /// [`MAX_MESSAGE_LEN`]; it counts as dropped then.
    pub fn put(&self, topic: usize, log_time_ns: u64, message: Vec<u8>) -> bool {
        self.counted(topic, log_time_ns, message, |put| self.sender.try_send(put).is_ok())
    }

    /// The same, but where the disk is too slow it is waited for: for what comes from a source that waits, too.
    pub fn put_waiting(&self, topic: usize, log_time_ns: u64, message: Vec<u8>) -> bool {
        self.counted(topic, log_time_ns, message, |put| self.sender.send(put).is_ok())
    }

    fn counted(
        &self,
        topic: usize,
        log_time_ns: u64,
        message: Vec<u8>,
        send: impl FnOnce(Put) -> bool,
    ) -> bool {
        let put = Put { channel: channel_of(topic), log_time_ns, message };
        let is_taken = put.message.len() <= MAX_MESSAGE_LEN && send(put);
        if !is_taken {
            self.n_dropped.fetch_add(1, Ordering::Relaxed);
        }
        is_taken
    }

    /// The wall clock, ns since 1970 UTC, at a moment of the host's monotonic clock, as the
    /// recording maps it.
    #[must_use]
    pub fn wall_ns(&self, t_host_ns: u64) -> u64 {
        t_host_ns.wrapping_add(self.wall_offset_ns)
    }
}

/// Both ends of the queue.
pub(crate) fn queue(wall_offset_ns: u64) -> (TopicWriter, Puts) {
    let (sender, receiver) = sync_channel(QUEUE_LEN);
    let n_dropped = Arc::new(AtomicU64::new(0));
    let writer = TopicWriter { sender, n_dropped: Arc::clone(&n_dropped), wall_offset_ns };
    let puts = Puts { receiver, n_dropped };
    (writer, puts)
}

/// Channel number of a topic by its place.
pub(crate) fn channel_of(topic: usize) -> u16 {
    u16::try_from(topic).map_or(u16::MAX, |topic| FIRST_ID.saturating_add(topic))
}

/// Whether these topics make the file a bag of ROS 2. Its readers refuse schemas of any other kind,
/// so the readings' own topics go without one then.
pub(crate) fn is_ros2<'a>(topics: impl IntoIterator<Item = &'a TopicDef>) -> bool {
    topics.into_iter().any(|topic| topic.schema_encoding == "ros2msg")
}

/// The topics as JSON: a second copy of the definitions, in another chunk than the first.
pub(crate) fn topics_json(topics: &[TopicDef]) -> Value {
    let all = topics.iter().enumerate().map(|(i, topic)| {
        json!({
            "channel": channel_of(i),
            "name": topic.name,
            "message_encoding": topic.message_encoding,
            "schema_name": topic.schema_name,
            "schema_encoding": topic.schema_encoding,
            "schema": topic.schema,
        })
    });
    Value::Array(all.collect())
}

/// Fields of a record, read one after the other. Lengths are not trusted: the library's own reader
/// allocates what they say before it looks whether so much is there.
struct Fields<'a>(&'a [u8]);

/// The topics of a file that is being read, as far as they are known.
#[derive(Default)]
pub(crate) struct Definitions {
    schemas: BTreeMap<u16, [String; 3]>,
    topics: BTreeMap<u16, Arc<TopicDef>>,
}

impl Fields<'_> {
    fn number(&mut self) -> Option<u16> {
        let (bytes, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(u16::from_le_bytes(*bytes))
    }

    /// A length of 32 bits and so many bytes.
    fn text(&mut self) -> Option<String> {
        let (len, rest) = self.0.split_first_chunk()?;
        let len = usize::try_from(u32::from_le_bytes(*len)).ok()?;
        let (bytes, rest) = rest.split_at_checked(len)?;
        self.0 = rest;
        Some(String::from_utf8_lossy(bytes).into_owned())
    }
}

impl Definitions {
    /// The topic of a channel, if it is known.
    pub(crate) fn topic(&self, channel: u16) -> Option<&Arc<TopicDef>> {
        self.topics.get(&channel)
    }

    pub(crate) fn is_ros2(&self) -> bool {
        is_ros2(self.topics.values().map(|topic| &**topic))
    }

    /// Takes a schema's record: number, name, encoding, text.
    pub(crate) fn take_schema(&mut self, content: &[u8]) {
        let mut fields = Fields(content);
        let schema = fields.number().and_then(|id| {
            let [name, encoding] = [fields.text()?, fields.text()?];
            Some((id, [name, encoding, fields.text()?]))
        });
        self.schemas.extend(schema);
    }

    /// Takes a channel's record: number, schema, topic, encoding of the messages. One whose schema
    /// is not known is left out: nobody could read it.
    pub(crate) fn take_channel(&mut self, content: &[u8]) {
        let mut fields = Fields(content);
        let topic = fields.number().and_then(|id| {
            let schema = match fields.number()? {
                0 => <[String; 3]>::default(),
                schema_id => self.schemas.get(&schema_id)?.clone(),
            };
            let [schema_name, schema_encoding, schema] = schema;
            let topic = TopicDef {
                name: fields.text()?,
                message_encoding: fields.text()?,
                schema_name,
                schema_encoding,
                schema,
            };
            Some((id, Arc::new(topic)))
        });
        self.topics.extend(topic);
    }

    /// The topics, in words.
    pub(crate) fn in_words(&self) -> String {
        let in_words = |topic: &Arc<TopicDef>| match topic.schema_name.as_str() {
            "" => format!("{} ({})", topic.name, topic.message_encoding),
            schema => format!("{} ({schema}, {})", topic.name, topic.message_encoding),
        };
        let topics: Vec<String> = self.topics.values().map(in_words).collect();
        if topics.is_empty() { "none".to_owned() } else { topics.join(", ") }
    }

    /// Takes the second copy, where a session's record has one.
    pub(crate) fn take_json(&mut self, session: &Value) {
        for value in session["topics"].as_array().into_iter().flatten() {
            let text = |key: &str| value[key].as_str().map(str::to_owned);
            let channel = value["channel"].as_u64().and_then(|id| id.try_into().ok());
            let topic = || {
                Some(TopicDef {
                    name: text("name")?,
                    message_encoding: text("message_encoding")?,
                    schema_name: text("schema_name")?,
                    schema_encoding: text("schema_encoding")?,
                    schema: text("schema")?,
                })
            };
            if let (Some(channel), Some(topic)) = (channel, topic()) {
                let is_further = channel >= FIRST_ID;
                is_further.then(|| self.topics.entry(channel).or_insert(Arc::new(topic)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_disk_loses_messages_unless_it_is_waited_for() {
        let n = QUEUE_LEN + 100;
        for waits in [false, true] {
            let (writer, Puts { receiver, n_dropped }) = queue(0);
            let hands_over = move || {
                let put = if waits { TopicWriter::put_waiting } else { TopicWriter::put };
                (0..n).filter(|&i| put(&writer, 0, i as u64, Vec::new())).count()
            };
            let producer = std::thread::spawn(hands_over);
            // nothing is written until the queue is full
            while !waits && !producer.is_finished() {
                std::thread::yield_now();
            }
            let written: Vec<u64> = receiver.iter().map(|put| put.log_time_ns).collect();
            let n_taken = if waits { n } else { QUEUE_LEN };
            assert_eq!(producer.join().unwrap(), n_taken);
            assert!(written.into_iter().eq(0..n_taken as u64));
            assert_eq!(n_dropped.load(Ordering::Relaxed), (n - n_taken) as u64);
        }
    }

    #[test]
    fn lengths_that_are_not_there_are_not_believed() {
        let mut definitions = Definitions::default();
        let mut schema = vec![7, 0];
        for text in ["x/msg/X", "ros2msg", "float64 x\n"] {
            schema.extend((text.len() as u32).to_le_bytes());
            schema.extend(text.bytes());
        }
        definitions.take_schema(&schema);
        let mut channel = vec![16, 0, 7, 0, 2, 0, 0, 0, b'/', b'x', 3, 0, 0, 0, b'c', b'd', b'r'];
        definitions.take_channel(&channel);
        let topic = definitions.topic(16).unwrap();
        assert_eq!((topic.name.as_str(), topic.message_encoding.as_str()), ("/x", "cdr"));
        assert_eq!(topic.schema, "float64 x\n");
        assert!(definitions.is_ros2());
        channel[0] = 17;
        channel[4..8].fill(0xff);
        definitions.take_channel(&channel);
        assert!(definitions.topic(17).is_none());
        for len in 0..schema.len() {
            Definitions::default().take_schema(&schema[..len]);
        }
    }
}
