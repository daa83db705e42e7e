//! Stills as WebP, one after the other, as one moving picture: an animated WebP (RFC 9649).

/// A still and how long it is shown, ms.
pub struct Still {
    pub webp: Vec<u8>,
    pub for_ms: u32,
}

/// The moving picture, without an end.
pub fn film(stills: &[Still]) -> Result<Vec<u8>, String> {
    let first = stills.first().ok_or("no stills")?;
    let (width, height) = size(&first.webp)?;
    let mut body = b"WEBP".to_vec();
    let mut head = vec![IS_ANIMATED, 0, 0, 0];
    put_u24(&mut head, width - 1);
    put_u24(&mut head, height - 1);
    put_chunk(&mut body, *b"VP8X", &head);
    put_chunk(&mut body, *b"ANIM", &[0; 6]);
    for still in stills {
        if size(&still.webp)? != (width, height) {
            return Err("stills of several sizes".to_owned());
        }
        let mut frame = vec![0; 6];
        put_u24(&mut frame, width - 1);
        put_u24(&mut frame, height - 1);
        put_u24(&mut frame, still.for_ms);
        frame.push(IS_NOT_BLENDED);
        put_chunk(&mut frame, *b"VP8 ", lossy(&still.webp)?);
        put_chunk(&mut body, *b"ANMF", &frame);
    }
    let mut film = Vec::with_capacity(8 + body.len());
    put_chunk(&mut film, *b"RIFF", &body);
    Ok(film)
}

/// Bit of the extended header (RFC 9649, 2.7).
const IS_ANIMATED: u8 = 2;
/// Bit of a frame (RFC 9649, 2.7.1.1): it replaces what was there.
const IS_NOT_BLENDED: u8 = 2;

/// Width and height of a lossy still (RFC 6386, 9.1).
fn size(webp: &[u8]) -> Result<(u32, u32), String> {
    let head = lossy(webp)?.get(6..10).ok_or("a still that ends in its header")?;
    let side = |at: usize| u32::from(u16::from_le_bytes([head[at], head[at + 1]]) & 0x3fff);
    Ok((side(0), side(2)))
}

/// The lossy picture in a still.
fn lossy(webp: &[u8]) -> Result<&[u8], String> {
    let mut rest = webp.get(12..).ok_or("a still without a header")?;
    while let Some((head, after)) = rest.split_first_chunk::<8>() {
        let n = u32::from_le_bytes([head[4], head[5], head[6], head[7]]) as usize;
        let content = after.get(..n).ok_or("a still that ends within a chunk")?;
        if head.starts_with(b"VP8 ") {
            return Ok(content);
        }
        rest = after.get(n.next_multiple_of(2)..).unwrap_or_default();
    }
    Err("no lossy picture in a still".to_owned())
}

/// Chunks begin at even places.
fn put_chunk(out: &mut Vec<u8>, name: [u8; 4], content: &[u8]) {
    out.extend(name);
    out.extend((content.len() as u32).to_le_bytes());
    out.extend(content);
    out.extend(vec![0; content.len() % 2]);
}

fn put_u24(out: &mut Vec<u8>, value: u32) {
    out.extend(&value.to_le_bytes()[..3]);
}
