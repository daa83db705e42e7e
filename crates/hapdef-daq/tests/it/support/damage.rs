//! Damage that surely hits frames, for the tests of several crates.

/// An MCAP file begins with a magic of this length.
const MAGIC_BYTES: usize = 8;
/// A record is an opcode, the length of its body in eight bytes, and the body.
const HEADER_BYTES: usize = 9;
/// The opcode of the records that hold the frames.
const CHUNK: u8 = 6;

/// One bit is flipped amid the chunk at a recording's middle.
///
/// The byte at the file's middle may be of an index instead, which costs no frame: recorders end
/// a chunk by the clock, so that no two recordings are divided alike.
pub fn flip_amid_a_chunk(bytes: &mut [u8]) {
    let (mut at, mut middle) = (MAGIC_BYTES, None);
    while at < bytes.len() / 2 {
        let length = bytes[at + 1..at + HEADER_BYTES].try_into().unwrap();
        let length = usize::try_from(u64::from_le_bytes(length)).unwrap();
        if bytes[at] == CHUNK {
            middle = Some(at + HEADER_BYTES + length / 2);
        }
        at += HEADER_BYTES + length;
    }
    bytes[middle.unwrap()] ^= 1;
}
