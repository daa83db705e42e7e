//! Recordings in MCAP: raw data that survives kill -9, full disks and damaged files.
//!
//! [`record()`] writes what a receiver gets, on threads of its own: a chunk every 80 ms, `fdatasync`
//! every 100 ms, CRC on, `.partial.mcap` until it is finished. [`Recording`] reads chunks whose CRC
//! is right, wherever they are in the file, so a damaged, cut or unfinished file loses what is
//! damaged and nothing else; [`recover()`] makes a whole file of it. docs/formats.md has the topics.

mod disk;
mod export;
mod file;
mod further;
mod messages;
mod numbers;
mod params;
mod player;
mod recording;
mod recover;
mod scan;
mod topics;
mod writer;

pub use export::{export_csv, export_json_lines};
pub use file::{check_unclaimed, claim};
pub use further::{MAX_MESSAGE_LEN, TopicDef, TopicWriter};
pub use numbers::{Arrived, Numbered, NumbersRow, NumbersTopic, TopicReader, is_mcap};
pub use params::{RecordInfo, RecordParams, RecordStats};
pub use player::{Player, PlayerControl};
pub use recording::{Content, Record, Recording};
pub use recover::{RecoverInfo, recover};
pub use scan::DamageInfo;
pub use writer::{Recorder, record};
