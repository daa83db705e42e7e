//! Damage that surely hits frames, for the tests of several crates.

/// One bit is flipped amid the chunk at a whole recording's middle.
///
/// The byte at the file's middle may be of an index instead, which costs no frame: recorders end
/// a chunk by the clock, so that no two recordings are divided alike.
pub fn flip_amid_a_chunk(recording: &mut [u8]) {
    let chunks = mcap::Summary::read(recording).unwrap().unwrap().chunk_indexes;
    let chunk = &chunks[chunks.len() / 2];
    let middle = chunk.chunk_start_offset + chunk.chunk_length / 2;
    recording[usize::try_from(middle).unwrap()] ^= 1;
}
