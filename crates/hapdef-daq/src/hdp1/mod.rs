//! HDP1, the wire protocol: packets framed by COBS and 0x00, guarded by CRC-32C.
//!
//! A packet is COBS(body) 0x00, a body is a header of 16 bytes, a payload and the CRC over both,
//! all little-endian. docs/formats.md has the tables. Nothing here does input or output.

mod decode;
mod encode;
mod hello;
mod payload;
mod reject;
mod sequence;
mod wire;

pub use decode::{Data, Decoder, Event};
pub use encode::Encoder;
pub use hello::{Channel, ChannelKind, Hello, SampleFormat};
pub use payload::{Command, Pong, Status};
pub use reject::{Rejected, RejectedCounts};
pub use sequence::LossCounts;
pub use wire::{FrameFlags, Header, MAJOR_VERSION, MAX_BODY_LEN, MAX_CHANNELS, MINOR_VERSION};
