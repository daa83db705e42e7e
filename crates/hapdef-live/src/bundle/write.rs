//! A bundle as bytes.

use std::borrow::Cow;
use std::collections::BTreeMap;

use hapdef_inverse::{ModeScope, OtherLoads, Skin};
use nalgebra::Vector3;
use safetensors::tensor::{TensorView, serialize};
use safetensors::{Dtype, SafeTensorError};

use super::header::{
    CALIBRATION, ENTRY, FACES, FORBIDDEN, GIVEN, Header, LOAD_SDS, LOADS, MAP, MODE, ModeHeader,
    NET, NODES, OUTWARD, SCENE, SITE_ERROR, hash, tensor_hash,
};
use super::{Bundle, skin_corners};
use crate::error::LiveError;

/// A tensor to write.
struct Part<'a> {
    dtype: Dtype,
    shape: Vec<usize>,
    bytes: Cow<'a, [u8]>,
}

impl Bundle {
    /// The bundle as the bytes of its file; the same bundle is always the same bytes.
    ///
    /// # Errors
    /// [`LiveError::NotABundle`] where the parts don't fit each other.
    pub fn to_bytes(&self) -> Result<Vec<u8>, LiveError> {
        let parts = self.parts();
        let hashes = parts.iter().map(|(name, part)| (name.clone(), part.hash())).collect();
        let mode = |mode: &super::BundleMode| ModeHeader {
            is_each_gauge: matches!(mode.scope, ModeScope::EachGauge),
            prior_sd: mode.prior_sd,
        };
        let modes = self.modes.iter().map(mode).collect();
        let signals = self.given.signals.iter().map(ToString::to_string).collect();
        let header = Header::new(self.info.clone(), signals, modes, hashes);
        let refused = |what: String| LiveError::NotABundle { file: self.info.scene.clone(), what };
        let json = serde_json::to_string(&header).map_err(|e| refused(e.to_string()))?;
        let entry = format!("{} {json}", hash(json.as_bytes()));
        let metadata = [(ENTRY.to_owned(), entry)].into_iter().collect();
        let views: Result<Vec<_>, SafeTensorError> =
            parts.iter().map(|(name, part)| Ok((name, part.view()?))).collect();
        views.and_then(|views| serialize(views, Some(metadata))).map_err(|e| refused(e.to_string()))
    }

    fn parts(&self) -> BTreeMap<String, Part<'_>> {
        let (skin, n_gauges) = (self.skin(), self.map.n_gauges());
        let mut parts = skin_parts(skin, self.outward.as_deref());
        let of_map = |nodal: &[Vector3<f64>]| {
            let n_values = nodal.len() / n_gauges;
            Part::of_f64(nodal.iter().flatten(), vec![n_values, n_gauges, 3])
        };
        parts.insert(MAP.to_owned(), of_map(&self.map.nodal()));
        parts.insert(SCENE.to_owned(), Part::of_bytes(self.scene_json.as_bytes()));
        if !self.site_error.is_empty() {
            let n_sites = self.site_error.len() / (n_gauges * n_gauges);
            let shape = vec![n_sites, n_gauges, n_gauges];
            let part = Part::of_f64(self.site_error.iter(), shape);
            parts.insert(SITE_ERROR.to_owned(), part);
        }
        if !self.loads.is_empty() {
            let (n_loads, OtherLoads { response, sd }) = (self.loads.len(), &self.loads);
            let response = Part::of_f64(response.iter(), vec![n_loads, n_gauges]);
            parts.insert(LOADS.to_owned(), response);
            parts.insert(LOAD_SDS.to_owned(), Part::of_f64(sd.iter(), vec![n_loads]));
        }
        if !self.given.is_empty() {
            let shape = vec![self.given.signals.len(), n_gauges];
            let part = Part::of_f64(self.given.response_ue.iter(), shape);
            parts.insert(GIVEN.to_owned(), part);
        }
        for (i, mode) in self.modes.iter().enumerate() {
            parts.insert(format!("{MODE}{i}"), of_map(&mode.map.nodal()));
        }
        if let Some(json) = &self.calibration_json {
            parts.insert(CALIBRATION.to_owned(), Part::of_bytes(json.as_bytes()));
        }
        for (name, bytes) in &self.nets {
            parts.insert(format!("{NET}{name}"), Part::of_bytes(bytes));
        }
        parts
    }
}

fn skin_parts<'a>(skin: &Skin, outward: Option<&[Vector3<f64>]>) -> BTreeMap<String, Part<'a>> {
    let n_nodes = skin.n_nodes();
    let nodes = skin.nodes().iter().flat_map(|x| x.coords.iter());
    let corners = skin_corners(skin);
    let per_face = corners.len() / skin.n_faces();
    let forbidden = (0..skin.n_faces()).map(|face| u8::from(skin.is_forbidden(face)));
    let face_bytes: Vec<u8> = corners.iter().flat_map(|node| node.to_le_bytes()).collect();
    let outward = outward.map(|outward| {
        let part = Part::of_f64(outward.iter().flatten(), vec![n_nodes, 3]);
        (OUTWARD.to_owned(), part)
    });
    let mut parts = BTreeMap::from([
        (NODES.to_owned(), Part::of_f64(nodes, vec![n_nodes, 3])),
        (
            FACES.to_owned(),
            Part {
                dtype: Dtype::U32,
                shape: vec![skin.n_faces(), per_face],
                bytes: face_bytes.into(),
            },
        ),
        (
            FORBIDDEN.to_owned(),
            Part {
                dtype: Dtype::U8,
                shape: vec![skin.n_faces()],
                bytes: forbidden.collect::<Vec<u8>>().into(),
            },
        ),
    ]);
    parts.extend(outward);
    parts
}

impl<'a> Part<'a> {
    fn of_f64<'b>(values: impl Iterator<Item = &'b f64>, shape: Vec<usize>) -> Self {
        let bytes: Vec<u8> = values.flat_map(|value| value.to_le_bytes()).collect();
        Self { dtype: Dtype::F64, shape, bytes: bytes.into() }
    }

    fn of_bytes(bytes: &'a [u8]) -> Self {
        Self { dtype: Dtype::U8, shape: vec![bytes.len()], bytes: bytes.into() }
    }

    fn hash(&self) -> String {
        tensor_hash(self.dtype, &self.shape, &self.bytes)
    }

    fn view(&self) -> Result<TensorView<'_>, SafeTensorError> {
        TensorView::new(self.dtype, self.shape.clone(), &self.bytes)
    }
}
