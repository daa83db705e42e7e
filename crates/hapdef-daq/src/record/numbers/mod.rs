//! Numbers of one topic of any MCAP file: what others logged, as rows and as frames.

mod cdr;
mod file;
mod find;
mod frames;
mod live;
mod part;

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, VecDeque};
use std::path::{Path, PathBuf};

use self::cdr::Ros2Type;
use self::file::McapFile;
use self::find::{Found, numbers};
use self::part::Part;
use super::further::{Definitions, TopicDef};
use super::scan::{CHANNEL, MESSAGE, MESSAGE_FIELDS_LEN, SCHEMA, channel_and_time, next_record};
use crate::DaqError;

pub use self::file::is_mcap;
pub use self::live::{Arrived, Numbered, TopicReader};

/// The numbers of a topic, message by message.
///
/// Messages are JSON, or of ROS 2 with their definitions: `std_msgs/msg/Float64MultiArray`, or any that
/// has one list of numbers. Of several lists one is named behind the topic, as in `/joint_states.effort`.
/// A list of as many texts beside the numbers names them; so do the fields of a message without a list.
pub struct NumbersTopic {
    path: PathBuf,
    file: McapFile,
    topic: String,
    definitions: Definitions,
    /// Types of ROS 2, by channel.
    types: BTreeMap<u16, Ros2Type>,
    rows: VecDeque<NumbersRow>,
    /// What the first message has.
    first: Option<Found>,
    n_read: usize,
}

/// The numbers of one message.
#[derive(Clone, Debug, PartialEq)]
pub struct NumbersRow {
    /// Which message of the topic it is, from 1.
    pub number: usize,
    /// Time of it, ns.
    pub log_time_ns: u64,
    /// The numbers, as many as in the first message; NaN where a message has none.
    pub values: Vec<f64>,
}

impl NumbersTopic {
    /// Opens a file, and reads the first message of `topic`.
    ///
    /// # Errors
    /// [`DaqError::NoTopic`] with the topics that are there, [`DaqError::NoNumbers`] for messages of
    /// another kind; a file that can't be read.
    pub fn open(path: &Path, topic: &str) -> Result<Self, DaqError> {
        let mut new = Self {
            path: path.to_owned(),
            file: McapFile::open(path)?,
            topic: topic.to_owned(),
            definitions: Definitions::default(),
            types: BTreeMap::new(),
            rows: VecDeque::new(),
            first: None,
            n_read: 0,
        };
        while new.rows.is_empty() {
            if !new.read_on()? {
                let found = new.definitions.in_words();
                return Err(DaqError::NoTopic { path: new.path, topic: new.topic, found });
            }
        }
        Ok(new)
    }

    /// How many numbers a message has.
    #[must_use]
    pub fn n_values(&self) -> usize {
        self.first.as_ref().map_or(0, |first| first.values.len())
    }

    /// Names of the numbers, where they have some.
    #[must_use]
    pub fn names(&self) -> Option<&[String]> {
        self.first.as_ref()?.names.as_deref()
    }

    /// The numbers of the next message; none at the end.
    ///
    /// # Errors
    /// [`DaqError::NoNumbers`] for a message of another kind than the first; a file that can't be read
    /// on.
    pub fn next_row(&mut self) -> Result<Option<NumbersRow>, DaqError> {
        while self.rows.is_empty() {
            if !self.read_on()? {
                return Ok(None);
            }
        }
        Ok(self.rows.pop_front())
    }

    /// Reads the next records; false at the end.
    fn read_on(&mut self) -> Result<bool, DaqError> {
        let Some(records) = self.file.next_records()? else {
            return Ok(false);
        };
        let mut rest = &records[..];
        while let Some((op, content, next)) = next_record(rest) {
            match op {
                SCHEMA => self.definitions.take_schema(content),
                CHANNEL => self.definitions.take_channel(content),
                MESSAGE => self.take_message(content)?,
                _ => {}
            }
            rest = next;
        }
        Ok(true)
    }

    fn take_message(&mut self, content: &[u8]) -> Result<(), DaqError> {
        let Some((channel, log_time_ns)) = channel_and_time(content) else { return Ok(()) };
        let Some(definition) = self.definitions.topic(channel) else { return Ok(()) };
        let Some(field) = field(&self.topic, &definition.name) else { return Ok(()) };
        self.n_read += 1;
        let bytes = &content[MESSAGE_FIELDS_LEN..];
        let found = message(definition, channel, &mut self.types, bytes)
            .and_then(|message| numbers(&message, field))
            .and_then(|found| same_as_first(&mut self.first, found));
        let values = found.map_err(|message| DaqError::NoNumbers {
            path: self.path.clone(),
            topic: self.topic.clone(),
            message: format!("message {}: {message}", self.n_read),
        })?;
        self.rows.push_back(NumbersRow { number: self.n_read, log_time_ns, values });
        Ok(())
    }
}

/// The field that `asked` names of a message of topic `name`, if it is one of that: all of it, or what
/// stands behind the topic and a point.
fn field<'a>(asked: &'a str, name: &str) -> Option<Option<&'a str>> {
    match asked.strip_prefix(name)? {
        "" => Some(None),
        rest => rest.strip_prefix('.').map(Some),
    }
}

fn message(
    definition: &TopicDef,
    channel: u16,
    types: &mut BTreeMap<u16, Ros2Type>,
    bytes: &[u8],
) -> Result<Part, String> {
    match (definition.message_encoding.as_str(), definition.schema_encoding.as_str()) {
        ("json", _) => serde_json::from_slice(bytes).map_err(|error| format!("no JSON: {error}")),
        ("cdr", "ros2msg") => {
            let of_messages = match types.entry(channel) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(new) => {
                    new.insert(Ros2Type::parse(&definition.schema_name, &definition.schema)?)
                }
            };
            of_messages.read(bytes)
        }
        (encoding, schema) => Err(format!(
            "written as {encoding:?} with a schema of {schema:?}: json is read, and cdr with ros2msg"
        )),
    }
}

/// The values found, where they are as many as in the first message, with the same names.
fn same_as_first(first: &mut Option<Found>, found: Found) -> Result<Vec<f64>, String> {
    let first = first.get_or_insert_with(|| found.clone());
    if found.values.len() != first.values.len() {
        let (n, n_first) = (found.values.len(), first.values.len());
        return Err(format!("{n} numbers, the first message has {n_first}"));
    }
    if found.names != first.names {
        return Err("its names are others than those of the first message".to_owned());
    }
    Ok(found.values)
}
