//! The GLB container: glTF 2.0 specification, section 4.4.

use super::GltfFault;

const MAGIC: u32 = 0x4654_6C67;
const JSON: u32 = 0x4E4F_534A;
const BIN: u32 = 0x004E_4942;
const HEADER_BYTES: usize = 12;
const CHUNK_HEADER_BYTES: usize = 8;

/// The parts of a GLB file, borrowed from its bytes.
pub(super) struct Glb<'a> {
    pub json: &'a [u8],
    pub bin: Option<&'a [u8]>,
    /// Bytes after the container, which the format tells readers to ignore.
    pub n_trailing_bytes: usize,
}

struct Chunk<'a> {
    kind: u32,
    data: &'a [u8],
}

/// Splits a GLB file into its JSON and its BIN chunk.
pub(super) fn split(bytes: &[u8]) -> Result<Glb<'_>, GltfFault> {
    let container = container(bytes)?;
    let mut glb = Glb { json: &[], bin: None, n_trailing_bytes: bytes.len() - container.len() };
    let mut offset = HEADER_BYTES;
    let mut position = 0;
    while offset < container.len() {
        let chunk = chunk_at(container, offset)?;
        offset += CHUNK_HEADER_BYTES + chunk.data.len();
        match (position, chunk.kind) {
            (0, JSON) => glb.json = chunk.data,
            (0, kind) => return Err(out_of_order(0, kind, "the first chunk must be JSON")),
            (1, BIN) => glb.bin = Some(chunk.data),
            (_, BIN) => {
                return Err(out_of_order(position, BIN, "the one BIN chunk must be the second"));
            }
            (_, JSON) => {
                return Err(out_of_order(position, JSON, "there is already a JSON chunk"));
            }
            _ => {}
        }
        position += 1;
    }
    Ok(glb)
}

/// The bytes the header declares, header included.
fn container(bytes: &[u8]) -> Result<&[u8], GltfFault> {
    if bytes.len() < HEADER_BYTES {
        return Err(GltfFault::GlbHeaderShort { found: bytes.len() });
    }
    let [magic, version, declared] = [0, 4, 8].map(|at| u32_at(bytes, at));
    if magic != MAGIC {
        return Err(GltfFault::GlbMagic { found: magic });
    }
    if version != 2 {
        return Err(GltfFault::GlbVersion { found: version });
    }
    let smallest = HEADER_BYTES + CHUNK_HEADER_BYTES;
    if (declared as usize) < smallest || declared as usize > bytes.len() {
        return Err(GltfFault::GlbLength { declared, found: bytes.len() });
    }
    Ok(&bytes[..declared as usize])
}

fn chunk_at(container: &[u8], offset: usize) -> Result<Chunk<'_>, GltfFault> {
    let left = container.len() - offset;
    let fault = |problem, length| GltfFault::GlbChunk { offset, problem, length, left };
    if left < CHUNK_HEADER_BYTES {
        return Err(fault("its 8-byte header is cut off", 0));
    }
    let [length, kind] = [offset, offset + 4].map(|at| u32_at(container, at));
    if length as usize > left - CHUNK_HEADER_BYTES {
        return Err(fault("its data are cut off", length));
    }
    if kind == JSON && length == 0 {
        return Err(fault("the JSON is empty", length));
    }
    if length % 4 != 0 {
        return Err(fault("its length is not a multiple of 4", length));
    }
    let start = offset + CHUNK_HEADER_BYTES;
    Ok(Chunk { kind, data: &container[start..start + length as usize] })
}

fn out_of_order(position: usize, kind: u32, problem: &'static str) -> GltfFault {
    GltfFault::GlbChunkOrder { position, kind, problem }
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}
