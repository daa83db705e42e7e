//! A model from bytes.

use std::io::Read;

use flate2::read::GzDecoder;
use hapdef_live::Bundle;
use hapdef_view::LimbPicture;
use nalgebra::Vector3;
use safetensors::tensor::{Dtype, SafeTensors};

use super::header::{
    BUNDLE, COLUMNS, ENTRY, Header, INWARD, NORMALS, TRIANGLES, VERSION, VERTICES, width,
};
use super::{PageModel, planes, sites};
use crate::error::PageError;

/// Most bytes that a model may unpack to.
const MOST_BYTES: u64 = 1 << 30;

impl PageModel {
    /// Reads the bytes of a file.
    ///
    /// # Errors
    /// [`PageError`] says what of it is wrong.
    pub fn from_bytes(packed: &[u8]) -> Result<Self, PageError> {
        let mut bytes = Vec::new();
        let unpacked = GzDecoder::new(packed).take(MOST_BYTES).read_to_end(&mut bytes);
        unpacked.map_err(|error| refused(&error))?;
        let header = header(&bytes)?;
        let parts = Parts(SafeTensors::deserialize(&bytes).map_err(|error| refused(&error))?);
        let bundle = parts.get(BUNDLE, Dtype::U8, None)?;
        let bundle = Bundle::from_bytes(&bundle.bytes, "the page's model")?;
        let (n_nodes, n_gauges) = (bundle.skin().n_nodes(), bundle.info.gauges.len());
        let inward = parts.get(INWARD, Dtype::F64, Some(vec![n_nodes, 3]))?;
        let columns = parts.get(COLUMNS, Dtype::F32, Some(vec![n_nodes, n_gauges, 3]))?;
        let vertices = parts.get(VERTICES, Dtype::F32, None)?;
        let normals = parts.get(NORMALS, Dtype::F32, Some(vertices.shape.clone()))?;
        let triangles = parts.get(TRIANGLES, Dtype::U32, None)?;
        let columns = f32s(&columns);
        let picture = LimbPicture {
            title: header.title,
            vertices_m: f32s(&vertices),
            normals: f32s(&normals),
            triangles: words(&triangles).map(|three| three.map(u32::from_le_bytes)).collect(),
            gauges: sites(&bundle),
            up: header.up,
            view_from: header.view_from,
        };
        Ok(Self {
            rig: header.rig,
            inward: words(&inward).map(|three| three.map(f64::from_le_bytes).into()).collect(),
            columns_ue_per_n: columns.iter().map(|c| Vector3::from(*c).cast()).collect(),
            bundle,
            picture,
        })
    }
}

fn header(bytes: &[u8]) -> Result<Header, PageError> {
    let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(|error| refused(&error))?;
    let entry = metadata.metadata().as_ref().and_then(|entries| entries.get(ENTRY));
    let json = entry.ok_or_else(|| PageError::NotAModel { what: "it has no header".to_owned() })?;
    let value: serde_json::Value = serde_json::from_str(json).map_err(|error| refused(&error))?;
    let found = value["version"].as_u64().and_then(|version| u32::try_from(version).ok());
    match found {
        Some(VERSION) => serde_json::from_value(value).map_err(|error| refused(&error)),
        Some(found) => Err(PageError::Version { expected: VERSION, found }),
        None => Err(PageError::NotAModel { what: "its header has no version".to_owned() }),
    }
}

fn refused(error: &impl ToString) -> PageError {
    PageError::NotAModel { what: error.to_string() }
}

struct Parts<'a>(SafeTensors<'a>);

struct Part {
    shape: Vec<usize>,
    bytes: Vec<u8>,
}

impl Parts<'_> {
    /// A list of that kind and shape; without one a list, or rows of three.
    fn get(
        &self,
        part: &'static str,
        dtype: Dtype,
        shape: Option<Vec<usize>>,
    ) -> Result<Part, PageError> {
        let view = self.0.tensor(part).map_err(|error| refused(&error))?;
        let is_shaped = match &shape {
            Some(shape) => view.shape() == shape,
            None => matches!(view.shape(), [_] | [_, 3]),
        };
        if view.dtype() == dtype && is_shaped {
            let bytes = planes::joined(view.data(), width(part));
            return Ok(Part { shape: view.shape().to_vec(), bytes });
        }
        let shape = shape.map_or_else(|| "[n] or [n, 3]".to_owned(), |shape| format!("{shape:?}"));
        Err(PageError::Part {
            part,
            expected: format!("{dtype:?} {shape}"),
            found: format!("{:?} {:?}", view.dtype(), view.shape()),
        })
    }
}

/// Rows of three words.
fn words<const N: usize>(part: &Part) -> impl Iterator<Item = [[u8; N]; 3]> {
    let (words, _) = part.bytes.as_chunks::<N>();
    let (rows, _) = words.as_chunks::<3>();
    rows.iter().copied()
}

fn f32s(part: &Part) -> Vec<[f32; 3]> {
    words(part).map(|three| three.map(f32::from_le_bytes)).collect()
}
