//! The model bundle: one file with everything that a robot needs to find contacts.
//!
//! A safetensors file whose one metadata entry is the hash of a JSON header and that header; the
//! header has the hash of every tensor, so that nothing damaged is ever used.

mod header;
mod read;
mod write;

use std::collections::BTreeMap;
use std::sync::Arc;

use hapdef_inverse::{
    ContactEstimator, ModeScope, OtherLoads, ResponseMap, Skin, SkinFaces, SkinParams,
    TrackerParams,
};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::error::LiveError;
use crate::estimator::{
    EstimatorKind, SearchPlace, Superposition, SuperpositionSettings, TouchEstimator, Tracking,
};
use crate::signals::GivenLoads;

/// Version of the form that is written and read here.
pub const BUNDLE_VERSION: u32 = 2;

/// Everything that a robot needs to find contacts, and where it comes from.
#[derive(Clone, Debug)]
pub struct Bundle {
    /// What it is and what it was made of.
    pub info: BundleInfo,
    /// The scene file's text, for programs that know scenes.
    pub scene_json: String,
    /// Covariance of the map's error at every scan site `[n_sites, n_gauges, n_gauges]`, µε²/N²;
    /// empty where the settings' relative error stands for it.
    pub site_error: Vec<f64>,
    /// Loads on the whole limb that are no contacts, µε per unit; none where there are none.
    pub loads: OtherLoads,
    /// Loads that the device measures, µε per unit of its signals; none where there are none.
    pub given: GivenLoads,
    /// What may change the response, for calibration without a finite-element model; may be empty.
    pub modes: Vec<BundleMode>,
    /// What the map was calibrated with, JSON, if it was.
    pub calibration_json: Option<String>,
    /// Files of the paper's chain with its trained nets, by name; may be empty.
    pub nets: BTreeMap<String, Vec<u8>>,
    map: Arc<ResponseMap>,
    /// The normals that the skin was made with.
    outward: Option<Vec<Vector3<f64>>>,
}

/// What a bundle is and what it was made of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BundleInfo {
    /// Name of the scene.
    pub scene: String,
    /// Version of hapdef that made it.
    pub made_by: String,
    /// Hash of the limb's deck, if it has one.
    pub deck_hash: Option<String>,
    /// The gauges in the order of the map.
    pub gauges: Vec<BundleGauge>,
    /// The middle of the mount, m, where it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mount_m: Option<[f64; 3]>,
    /// What finds contacts, as the scene chooses it.
    pub estimator: EstimatorKind,
    /// How contacts are looked for by superposition, and how many there are at most.
    pub settings: SuperpositionSettings,
}

/// A gauge.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BundleGauge {
    /// Name; channels of that name (its first four letters, upper or lower case) are it.
    pub name: String,
    /// Centre on the wall, m.
    pub position_m: [f64; 3],
    /// Measuring direction.
    pub axis: [f64; 3],
    /// What a channel's value in µε is multiplied by; 1 where the device's own scale is right.
    pub scale: f64,
}

/// A cause that changes the response, as [`hapdef_inverse::ModeMap`] has it.
#[derive(Clone, Debug)]
pub struct BundleMode {
    /// The map's derivative with respect to the cause.
    pub map: ResponseMap,
    /// Whether each gauge has an amplitude of its own.
    pub scope: ModeScope,
    /// Standard deviation of an amplitude before any press.
    pub prior_sd: f64,
}

impl Bundle {
    /// A bundle of a response map in µε/N on a skin that was made with `outward` as its normals
    /// `[n_nodes]`; `None` where it was made without.
    ///
    /// # Errors
    /// [`LiveError::NotReproduced`] where the map would not come back bit for bit;
    /// [`LiveError::FrameLength`] where `info` has another number of gauges than the map.
    pub fn new(
        info: BundleInfo,
        map: Arc<ResponseMap>,
        outward: Option<&[Vector3<f64>]>,
    ) -> Result<Self, LiveError> {
        let (expected, found) = (map.n_gauges(), info.gauges.len());
        if expected != found {
            return Err(LiveError::FrameLength { expected, found });
        }
        let again = rebuilt(map.skin(), outward, map.n_gauges(), &map.nodal())?;
        for (part, is_same) in [
            ("normals", map.skin().normals() == again.skin().normals()),
            ("values", map.nodal() == again.nodal()),
        ] {
            if !is_same {
                return Err(LiveError::NotReproduced { part });
            }
        }
        Ok(Self {
            info,
            scene_json: String::new(),
            site_error: Vec::new(),
            loads: OtherLoads::default(),
            given: GivenLoads::default(),
            modes: Vec::new(),
            calibration_json: None,
            nets: BTreeMap::new(),
            map,
            outward: outward.map(<[_]>::to_vec),
        })
    }

    /// The response map, µε/N; its skin is what can be touched.
    #[must_use]
    pub fn map(&self) -> &Arc<ResponseMap> {
        &self.map
    }

    /// The skin that can be touched.
    #[must_use]
    pub fn skin(&self) -> &Skin {
        self.map.skin()
    }

    /// The search for contacts on the bundle's map.
    ///
    /// # Errors
    /// [`LiveError::Inverse`] for values that can't be used.
    pub fn contact_estimator(&self) -> Result<ContactEstimator, LiveError> {
        let site_error = self.site_error.clone();
        let estimator = self.info.settings.estimator(self.map.clone(), site_error)?;
        Ok(if self.loads.is_empty() {
            estimator
        } else {
            estimator.with_loads(self.loads.clone())?
        })
    }

    /// An estimator of each frame on its own.
    ///
    /// # Errors
    /// As [`Bundle::contact_estimator`].
    pub fn superposition(&self) -> Result<Superposition, LiveError> {
        Ok(Superposition::new(self.contact_estimator()?))
    }

    /// An estimator that follows contacts from frame to frame, as many as the settings say.
    ///
    /// # Errors
    /// As [`Bundle::contact_estimator`], and where no thread can be started for `place`.
    pub fn tracking(&self, place: SearchPlace) -> Result<Tracking, LiveError> {
        let params = TrackerParams {
            max_contacts: self.info.settings.max_contacts,
            ..TrackerParams::default()
        };
        Tracking::new(self.contact_estimator()?, params, place)
    }

    /// The paper's chain of the bundle's nets; as many contacts at most as the settings say.
    ///
    /// # Errors
    /// [`LiveError::NotABundle`] where it has no nets, or no whole ones; as
    /// [`crate::estimator::Hapdefx::new`].
    #[cfg(feature = "nets")]
    pub fn paper_chain(&self) -> Result<crate::estimator::PaperChain, LiveError> {
        if self.nets.is_empty() {
            return Err(LiveError::NotABundle {
                file: format!("the bundle of {}", self.info.scene),
                what: "it has no nets (hapdef bundle --nets adds them)".to_owned(),
            });
        }
        let chain = crate::estimator::Hapdefx::from_files(&self.nets)?;
        let (expected, found) = (self.info.gauges.len(), chain.n_gauges());
        if expected != found {
            return Err(LiveError::FrameLength { expected, found });
        }
        let SuperpositionSettings { max_contacts, max_force_n, .. } = self.info.settings;
        let range_n = max_force_n / hapdef_inverse::BELIEVED_OF_RANGE;
        Ok(crate::estimator::PaperChain::new(chain, max_contacts, range_n))
    }

    /// What finds contacts in a stream: `kind`, or what the scene chooses. The paper's chain takes the
    /// feature `nets`; full searches of tracking run at `place`.
    ///
    /// # Errors
    /// As [`Bundle::tracking`] and [`Bundle::paper_chain`]; [`LiveError::NetsLeftOut`] without the
    /// feature.
    pub fn estimator(
        &self,
        kind: Option<EstimatorKind>,
        place: SearchPlace,
    ) -> Result<Box<dyn TouchEstimator>, LiveError> {
        match kind.unwrap_or(self.info.estimator.in_stream()) {
            EstimatorKind::Tracking => Ok(Box::new(self.tracking(place)?)),
            EstimatorKind::Superposition => Ok(Box::new(self.superposition()?)),
            #[cfg(feature = "nets")]
            EstimatorKind::Hapdefx => Ok(Box::new(self.paper_chain()?)),
            #[cfg(not(feature = "nets"))]
            EstimatorKind::Hapdefx => {
                Err(LiveError::NetsLeftOut { scene: self.info.scene.clone() })
            }
        }
    }
}

/// The map of nodal values on a skin like `skin`.
fn rebuilt(
    skin: &Skin,
    outward: Option<&[Vector3<f64>]>,
    n_gauges: usize,
    nodal: &[Vector3<f64>],
) -> Result<ResponseMap, LiveError> {
    let forbidden: Vec<usize> =
        (0..skin.n_faces()).filter(|&face| skin.is_forbidden(face)).collect();
    let corners = skin_corners(skin);
    let shape = SkinShape {
        nodes: skin.nodes().to_vec(),
        corners: &corners,
        per_face: if skin.is_quadratic() { 6 } else { 3 },
        outward,
        forbidden: &forbidden,
    };
    map_on(shape.skin()?, n_gauges, nodal)
}

/// Node numbers of all faces, face by face.
fn skin_corners(skin: &Skin) -> Vec<u32> {
    let faces = (0..skin.n_faces()).flat_map(|face| skin.face_nodes(face));
    faces.copied().collect()
}

/// The tip is in the nodal values already.
fn map_on(skin: Skin, n_gauges: usize, nodal: &[Vector3<f64>]) -> Result<ResponseMap, LiveError> {
    Ok(ResponseMap::from_values(skin, n_gauges, nodal)?)
}

/// What a skin is made of.
struct SkinShape<'a> {
    nodes: Vec<nalgebra::Point3<f64>>,
    corners: &'a [u32],
    per_face: usize,
    outward: Option<&'a [Vector3<f64>]>,
    forbidden: &'a [usize],
}

impl SkinShape<'_> {
    fn skin(self) -> Result<Skin, LiveError> {
        let params = SkinParams::default();
        let outward = self.outward;
        let skin = if self.per_face == 6 {
            let (faces, _) = self.corners.as_chunks::<6>();
            Skin::new(self.nodes, SkinFaces::Quadratic(faces), outward, &params)?
        } else {
            let (faces, _) = self.corners.as_chunks::<3>();
            Skin::new(self.nodes, SkinFaces::Linear(faces), outward, &params)?
        };
        Ok(skin.forbid(self.forbidden)?)
    }
}
