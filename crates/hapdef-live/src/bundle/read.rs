//! A bundle from bytes, every part checked.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use hapdef_inverse::{ModeScope, OtherLoads, ResponseMap, Skin};
use nalgebra::{Point3, Vector3};
use safetensors::{Dtype, SafeTensors};

use super::header::{
    AnyHeader, CALIBRATION, ENTRY, FACES, FORBIDDEN, GIVEN, Header, LOAD_SDS, LOADS, MAP, MODE,
    NET, NODES, OUTWARD, SCENE, SITE_ERROR, hash, tensor_hash,
};
use super::{BUNDLE_VERSION, Bundle, BundleMode, SkinShape, map_on};
use crate::error::LiveError;
use crate::signals::{GivenLoads, UnknownSignal};

impl Bundle {
    /// Reads a bundle and checks every part of it.
    ///
    /// # Errors
    /// [`LiveError::BundleFile`], and as [`Bundle::from_bytes`].
    pub fn read(path: &Path) -> Result<Self, LiveError> {
        let bytes = std::fs::read(path)
            .map_err(|source| LiveError::BundleFile { path: path.to_owned(), source })?;
        Self::from_bytes(&bytes, &path.display().to_string())
    }

    /// The same from the bytes of `file`.
    ///
    /// # Errors
    /// [`LiveError::NotABundle`], [`LiveError::BundleVersion`], [`LiveError::BundleDamaged`];
    /// [`LiveError::Inverse`] for a skin or map that can't be used.
    pub fn from_bytes(bytes: &[u8], file: &str) -> Result<Self, LiveError> {
        let parts = Parts::open(bytes, file)?;
        let header = parts.header()?;
        parts.check_hashes(&header.hashes)?;
        let n_gauges = header.info.gauges.len();
        let (skin, outward) = parts.skin()?;
        let map = parts.map(MAP, &skin, n_gauges)?;
        let mut modes = Vec::with_capacity(header.modes.len());
        for (i, mode) in header.modes.iter().enumerate() {
            modes.push(BundleMode {
                map: parts.map(&format!("{MODE}{i}"), &skin, n_gauges)?,
                scope: if mode.is_each_gauge { ModeScope::EachGauge } else { ModeScope::Shared },
                prior_sd: mode.prior_sd,
            });
        }
        let site_error = match parts.find(SITE_ERROR) {
            None => Vec::new(),
            Some(part) => {
                let n_sites = part.shape().first().copied().unwrap_or(0);
                parts.numbers(SITE_ERROR, &[n_sites, n_gauges, n_gauges])?
            }
        };
        let loads = match parts.find(LOADS) {
            None => OtherLoads::default(),
            Some(part) => {
                let n_loads = part.shape().first().copied().unwrap_or(0);
                OtherLoads {
                    response: parts.numbers(LOADS, &[n_loads, n_gauges])?,
                    sd: parts.numbers(LOAD_SDS, &[n_loads])?,
                }
            }
        };
        let signals: Result<Vec<_>, _> = header.signals.iter().map(|word| word.parse()).collect();
        let signals = signals.map_err(|e: UnknownSignal| parts.refused(e.to_string()))?;
        let given = match signals.len() {
            0 => GivenLoads::default(),
            n => GivenLoads { signals, response_ue: parts.numbers(GIVEN, &[n, n_gauges])? },
        };
        let has_calibration = parts.find(CALIBRATION).is_some();
        let calibration = has_calibration.then(|| parts.text(CALIBRATION));
        Ok(Self {
            scene_json: parts.text(SCENE)?,
            calibration_json: calibration.transpose()?,
            nets: parts.nets(),
            map: Arc::new(map),
            info: header.info,
            outward,
            site_error,
            loads,
            given,
            modes,
        })
    }
}

/// `[n_nodes]`.
type Normals = Vec<Vector3<f64>>;

/// The tensors of a file.
struct Parts<'a> {
    tensors: SafeTensors<'a>,
    entry: String,
    file: &'a str,
}

impl<'a> Parts<'a> {
    fn open(bytes: &'a [u8], file: &'a str) -> Result<Self, LiveError> {
        let refused = |what: String| LiveError::NotABundle { file: file.to_owned(), what };
        let tensors = SafeTensors::deserialize(bytes).map_err(|e| refused(e.to_string()))?;
        let (_, metadata) =
            SafeTensors::read_metadata(bytes).map_err(|e| refused(e.to_string()))?;
        let entries = metadata.metadata().as_ref();
        let entry = entries.and_then(|entries| entries.get(ENTRY).cloned());
        let entry = entry.ok_or_else(|| refused(format!("it has no entry {ENTRY:?}")))?;
        Ok(Self { tensors, entry, file })
    }

    /// The header, its hash and version checked.
    fn header(&self) -> Result<Header, LiveError> {
        let damaged = || self.damaged("its header");
        let (said, json) = self.entry.split_once(' ').ok_or_else(damaged)?;
        if said != hash(json.as_bytes()) {
            return Err(damaged());
        }
        let any: AnyHeader =
            serde_json::from_str(json).map_err(|e| self.refused(format!("header: {e}")))?;
        if any.version != BUNDLE_VERSION {
            return Err(LiveError::BundleVersion {
                file: self.file.to_owned(),
                found: any.version,
                expected: BUNDLE_VERSION,
                made_by: any.info.made_by,
            });
        }
        serde_json::from_str(json).map_err(|e| self.refused(format!("header: {e}")))
    }

    /// Every tensor is one of the header's, and as it was written.
    fn check_hashes(&self, hashes: &BTreeMap<String, String>) -> Result<(), LiveError> {
        for (name, said) in hashes {
            let part = self.part(name)?;
            if tensor_hash(part.dtype(), part.shape(), part.data()) != *said {
                return Err(self.damaged(name));
            }
        }
        let (expected, found) = (hashes.len(), self.tensors.len());
        if expected == found {
            return Ok(());
        }
        Err(self.refused(format!("expected {expected} tensors, found {found}")))
    }

    /// The skin, and the normals that it was made with.
    fn skin(&self) -> Result<(Skin, Option<Normals>), LiveError> {
        let faces = self.part(FACES)?;
        let (n_faces, per_face) = match (faces.shape(), faces.dtype()) {
            (&[n, per_face @ (3 | 6)], Dtype::U32) => (n, per_face),
            (shape, dtype) => {
                return Err(self.refused(format!(
                    "{FACES}: expected [n, 3] or [n, 6] of U32, found {shape:?} of {dtype:?}"
                )));
            }
        };
        let (words, _) = faces.data().as_chunks::<4>();
        let corners: Vec<u32> = words.iter().map(|w| u32::from_le_bytes(*w)).collect();
        let forbidden = self.part(FORBIDDEN)?;
        let flags = forbidden.data();
        if flags.len() != n_faces {
            let found = flags.len();
            return Err(self.refused(format!("{FORBIDDEN}: expected {n_faces}, found {found}")));
        }
        let forbidden: Vec<usize> = (0..n_faces).filter(|&face| flags[face] != 0).collect();
        let n_nodes = self.part(NODES)?.shape().first().copied().unwrap_or(0);
        let nodes = self.vectors(NODES, &[n_nodes, 3])?;
        let outward = self.find(OUTWARD).map(|_| self.vectors(OUTWARD, &[n_nodes, 3]));
        let outward = outward.transpose()?;
        let shape = SkinShape {
            nodes: nodes.into_iter().map(Point3::from).collect(),
            corners: &corners,
            per_face,
            outward: outward.as_deref(),
            forbidden: &forbidden,
        };
        Ok((shape.skin()?, outward))
    }

    fn nets(&self) -> BTreeMap<String, Vec<u8>> {
        let named = self.tensors.iter().filter_map(|(name, part)| {
            let name = name.strip_prefix(NET)?;
            Some((name.to_owned(), part.data().to_vec()))
        });
        named.collect()
    }

    fn text(&self, name: &str) -> Result<String, LiveError> {
        let bytes = self.part(name)?.data().to_vec();
        String::from_utf8(bytes).map_err(|_| self.refused(format!("{name} is no text")))
    }

    /// `shape` ends with the three coordinates.
    /// A map with a value at each node, or at each point of subdivided six-node faces.
    fn map(&self, name: &str, skin: &Skin, n_gauges: usize) -> Result<ResponseMap, LiveError> {
        let found = self.part(name)?.shape().first().copied();
        let subdivided = skin.subdivided_points().len();
        let n_values = match found == Some(subdivided) {
            true => subdivided,
            false => skin.n_nodes(),
        };
        let shape = [n_values, n_gauges, 3];
        map_on(skin.clone(), n_gauges, &self.vectors(name, &shape)?)
    }

    fn vectors(&self, name: &str, shape: &[usize]) -> Result<Vec<Vector3<f64>>, LiveError> {
        let numbers = self.numbers(name, shape)?;
        let (triples, _) = numbers.as_chunks::<3>();
        Ok(triples.iter().map(|v| Vector3::from(*v)).collect())
    }

    fn numbers(&self, name: &str, shape: &[usize]) -> Result<Vec<f64>, LiveError> {
        let part = self.part(name)?;
        if part.dtype() != Dtype::F64 || part.shape() != shape {
            let (dtype, found) = (part.dtype(), part.shape());
            return Err(self.refused(format!(
                "{name}: expected {shape:?} of F64, found {found:?} of {dtype:?}"
            )));
        }
        let (words, _) = part.data().as_chunks::<8>();
        Ok(words.iter().map(|w| f64::from_le_bytes(*w)).collect())
    }

    fn find(&self, name: &str) -> Option<safetensors::tensor::TensorView<'a>> {
        self.tensors.tensor(name).ok()
    }

    fn part(&self, name: &str) -> Result<safetensors::tensor::TensorView<'a>, LiveError> {
        let missing = || self.refused(format!("it lacks the tensor {name}"));
        self.find(name).ok_or_else(missing)
    }

    fn refused(&self, what: String) -> LiveError {
        LiveError::NotABundle { file: self.file.to_owned(), what }
    }

    fn damaged(&self, part: &str) -> LiveError {
        LiveError::BundleDamaged { file: self.file.to_owned(), part: part.to_owned() }
    }
}
