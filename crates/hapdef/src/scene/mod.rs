//! The scene file: one JSON document per limb and use.
//!
//! Unknown fields are refused; every error names the JSON path. Units are in the names, SI
//! throughout. What can have a default has one: geometry, mount and gauges are enough.
//! `docs/scene.md` walks through an example.

mod check;
mod estimator;
mod gauges;
mod geometry;
mod limb;
mod loads;
mod read;
mod rig;
mod tag;

pub use estimator::{EstimatorSpec, HapdefxSpec, SuperpositionSpec};
pub use gauges::{GaugeEntry, GaugeSpec};
pub use geometry::{
    Axis, Geometry, Shape, SkinShape, WallBox, WallRegions, WallSide, WallSolver, WallThickness,
};
pub use limb::{ContactRegion, ContactSpec, LimbEnd, LoadDirection, MaterialSpec, Mount};
pub use loads::{FlangeSpec, LoadsSpec};
pub(crate) use read::default_name;
pub use read::{read_scene, scene_file};
pub use rig::{
    BridgeSpec, CreepSpec, ElectronicsSpec, GainSpec, LiveSpec, LoadSensorsSpec, MisplacementSpec,
    PressSpec, RigMesh, RigSpec, VariationSpec,
};

use serde::{Deserialize, Serialize};

/// A limb and what is to be done with it.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Short name; results go to `target/hapdef/<name>/`. Letters, digits, `-` and `_`. If absent, the
    /// file's, or that of its folder for a `scene.json`.
    #[serde(default)]
    pub name: String,
    /// Seed of everything that is drawn on the training side.
    #[serde(default = "one")]
    pub seed: u64,
    /// Where the limb's shape comes from.
    pub geometry: Geometry,
    /// What it is made of; if absent, the deck's own material, of a skin PA2200.
    pub material: Option<MaterialSpec>,
    /// How it is held.
    pub mount: Mount,
    /// Where and how it is touched.
    #[serde(default)]
    pub contact: ContactSpec,
    /// Loads on it that are no contacts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub loads: Option<LoadsSpec>,
    /// Its strain gauges.
    pub gauges: GaugeSpec,
    /// The simulated hardware.
    #[serde(default)]
    pub rig: RigSpec,
    /// How contacts are found from readings.
    #[serde(default, deserialize_with = "tag::estimator")]
    pub estimator: EstimatorSpec,
    /// What is wanted of a frame; if nothing is said, contacts, and the map once a live page asks for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outputs: Option<Outputs>,
}

fn one() -> u64 {
    1
}

/// What is wanted of a frame. A force is only known with its place: there are no forces alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outputs {
    /// Contacts alone: no map of the skin, on the live page neither.
    Contacts,
    /// Contacts, and the displacement of the whole skin.
    Map,
}
