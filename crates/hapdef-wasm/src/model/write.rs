//! A model as bytes.

use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;
use safetensors::Dtype;
use safetensors::tensor::{TensorView, serialize};

use super::PageModel;
use super::header::{BUNDLE, COLUMNS, ENTRY, Header, INWARD, NORMALS, TRIANGLES, VERTICES, width};
use super::planes;
use crate::error::PageError;

type Part = (&'static str, Dtype, Vec<usize>, Vec<u8>);

impl PageModel {
    /// The model as the bytes of its file, compressed; the same model is always the same bytes.
    ///
    /// # Errors
    /// [`PageError::Live`] for a bundle that can't be written, [`PageError::NotAModel`].
    pub fn to_bytes(&self) -> Result<Vec<u8>, PageError> {
        let refused = |what: String| PageError::NotAModel { what };
        let header = Header::new(&self.picture, &self.rig);
        let json = serde_json::to_string(&header).map_err(|error| refused(error.to_string()))?;
        let parts = self.parts()?;
        let views: Vec<_> = parts
            .iter()
            .map(|(name, dtype, shape, bytes)| {
                TensorView::new(*dtype, shape.clone(), bytes).map(|view| (*name, view))
            })
            .collect::<Result<_, _>>()
            .map_err(|error| refused(error.to_string()))?;
        let metadata = [(ENTRY.to_owned(), json)].into_iter().collect();
        let bytes = serialize(views, Some(metadata)).map_err(|error| refused(error.to_string()))?;
        let mut packed = GzEncoder::new(Vec::new(), Compression::best());
        let written = packed.write_all(&bytes).and_then(|()| packed.finish());
        written.map_err(|error| refused(error.to_string()))
    }

    fn parts(&self) -> Result<Vec<Part>, PageError> {
        let bundle = self.bundle.to_bytes()?;
        let (n_nodes, n_gauges) = (self.inward.len(), self.bundle.info.gauges.len());
        let picture = &self.picture;
        let inward = self.inward.iter().flatten().flat_map(|c| c.to_le_bytes());
        let columns = self.columns_ue_per_n.iter().flatten();
        let columns = columns.flat_map(|c| (*c as f32).to_le_bytes());
        let of_f32 = |values: &[[f32; 3]]| -> Vec<u8> {
            values.as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect()
        };
        let triangles = picture.triangles.as_flattened().iter().flat_map(|n| n.to_le_bytes());
        let n_vertices = picture.vertices_m.len();
        let parts = [
            (BUNDLE, Dtype::U8, vec![bundle.len()], bundle),
            (INWARD, Dtype::F64, vec![n_nodes, 3], inward.collect()),
            (COLUMNS, Dtype::F32, vec![n_nodes, n_gauges, 3], columns.collect()),
            (VERTICES, Dtype::F32, vec![n_vertices, 3], of_f32(&picture.vertices_m)),
            (NORMALS, Dtype::F32, vec![n_vertices, 3], of_f32(&picture.normals)),
            (TRIANGLES, Dtype::U32, vec![picture.triangles.len(), 3], triangles.collect()),
        ];
        let split = |(name, dtype, shape, bytes): Part| {
            (name, dtype, shape, planes::split(&bytes, width(name)))
        };
        Ok(parts.map(split).into())
    }
}
