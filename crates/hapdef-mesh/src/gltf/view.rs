//! Bytes out of buffer views: every bound is checked before a byte is touched.

use gltf::json::buffer::{Target, View};
use gltf::json::validation::Checked;

use super::GltfFault;
use super::source::{Source, found};

/// What an accessor is read for.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Use {
    Vertices,
    Indices,
    SparsePart,
}

/// `n` elements of `element_bytes` each, `offset` bytes into a view.
pub(super) struct Span {
    pub view: usize,
    pub offset: u64,
    pub n: usize,
    pub element_bytes: usize,
    pub component_bytes: usize,
    pub used_for: Use,
}

impl Source<'_> {
    /// Copies a span's elements together, after checking view, use, stride, alignment and end.
    pub fn gathered(&self, span: &Span, place: &str) -> Result<Vec<u8>, GltfFault> {
        let view = found(&self.root.buffer_views, span.view, place, "bufferView")?;
        let bytes = self.view_bytes(span.view, view)?;
        check_use(span, view, place)?;
        let stride = stride(span, view)?;
        let start = view.byte_offset.unwrap_or_default().0.saturating_add(span.offset);
        if start % span.component_bytes as u64 != 0 {
            let component_bytes = span.component_bytes;
            return Err(GltfFault::Alignment {
                place: place.into(),
                offset: start,
                component_bytes,
            });
        }
        // n ≥ 1: the last element begins at (n − 1)·stride.
        let last = (stride as u64).saturating_mul(span.n as u64 - 1);
        let end = last.saturating_add(span.element_bytes as u64).saturating_add(span.offset);
        if end > bytes.len() as u64 {
            let available = bytes.len() as u64;
            return Err(GltfFault::AccessorEnd { place: place.to_owned(), end, available });
        }
        let used = &bytes[span.offset as usize..end as usize];
        Ok(used.chunks(stride).flat_map(|chunk| &chunk[..span.element_bytes]).copied().collect())
    }

    fn view_bytes(&self, index: usize, view: &View) -> Result<&[u8], GltfFault> {
        let place = format!("bufferViews[{index}].buffer");
        let buffer = found(self.buffers, view.buffer.value(), &place, "buffer")?;
        let start = view.byte_offset.unwrap_or_default().0;
        let end = start.saturating_add(view.byte_length.0);
        let available = buffer.len() as u64;
        if end > available {
            return Err(GltfFault::ViewEnd { view: index, end, available });
        }
        Ok(&buffer[start as usize..end as usize])
    }
}

fn check_use(span: &Span, view: &View, place: &str) -> Result<(), GltfFault> {
    let why = match (span.used_for, view.target, view.byte_stride) {
        (_, Some(Checked::Invalid), _) => "its target is neither 34962 nor 34963",
        (Use::Vertices, Some(Checked::Valid(Target::ElementArrayBuffer)), _) => {
            "its target is ELEMENT_ARRAY_BUFFER"
        }
        (Use::Indices, Some(Checked::Valid(Target::ArrayBuffer)), _) => {
            "its target is ARRAY_BUFFER"
        }
        (Use::SparsePart, Some(_), _) => "it has a target, which sparse parts must not have",
        (Use::Indices | Use::SparsePart, _, Some(_)) => {
            "it has a byteStride, which only vertices may"
        }
        _ => return Ok(()),
    };
    Err(GltfFault::ViewUse { view: span.view, place: place.to_owned(), why })
}

/// The distance between elements: specification, section 5.11 (`bufferView.byteStride`).
fn stride(span: &Span, view: &View) -> Result<usize, GltfFault> {
    let Some(stride) = view.byte_stride else {
        return Ok(span.element_bytes);
    };
    let stride = stride.0;
    if stride % 4 != 0 || !(4..=252).contains(&stride) || stride < span.element_bytes {
        let element_bytes = span.element_bytes;
        return Err(GltfFault::Stride { view: span.view, stride, element_bytes });
    }
    Ok(stride)
}
