//! Scene sections about the limb itself: geometry, material, mount, contact.

use std::path::PathBuf;

use hapdef_mesh::LengthUnit;
use serde::{Deserialize, Serialize};

/// Where the limb's shape comes from.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Geometry {
    /// Deck or volume mesh of tetrahedra (`.inp`, `.dat`, `.cdb`, `.msh`, each also `.gz`), relative
    /// to the scene file.
    pub solid_deck: PathBuf,
    /// Unit of the deck's lengths, metres or millimetres. Stresses and densities go along: Pa and
    /// kg/m³ with metres, MPa and t/mm³ with millimetres.
    #[serde(with = "deck_unit")]
    pub unit: LengthUnit,
    /// The limb's long axis, for unrolling and for radial rules.
    pub axis: Axis,
    /// How many times every tetrahedron of the deck is cut into eight before anything else;
    /// `hapdef converge` says how many it takes.
    #[serde(default)]
    pub refinements: u32,
    /// Surface (`.glb`, `.gltf`) in metres and in the deck's frame that the live page draws instead
    /// of the deck's skin, relative to the scene file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub skin_gltf: Option<PathBuf>,
}

/// A line in space.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    /// A point on it, m.
    pub point_m: [f64; 3],
    /// Its direction, any length above 0.
    pub direction: [f64; 3],
}

/// Isotropic linear-elastic material.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct MaterialSpec {
    /// Young's modulus, Pa.
    pub youngs_modulus_pa: f64,
    /// Poisson's ratio.
    pub poissons_ratio: f64,
    /// Density, kg/m³.
    pub density_kg_m3: f64,
}

/// Which nodes are held fast in all three directions.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Mount {
    /// The nodes that the deck itself fixes.
    Deck {},
    /// A node set (component) of the deck.
    NodeSet {
        /// Its name in the deck.
        name: String,
    },
    /// All nodes within an axis-aligned box.
    Box {
        /// Lower corner, m.
        min_m: [f64; 3],
        /// Upper corner, m.
        max_m: [f64; 3],
    },
}

/// Where and how the limb is touched.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ContactSpec {
    /// The skin that may be touched; its nodes carry the deformation map.
    pub region: ContactRegion,
    /// Radius of the touching tip, m; 0 is a point force on a node.
    pub tip_radius_m: f64,
    /// Smallest and largest force of one contact, N.
    pub force_range_n: [f64; 2],
    /// Direction of the force.
    pub direction: LoadDirection,
    /// Smallest distance of two contacts at a time, m.
    pub min_spacing_m: f64,
    /// Most contacts at a time, 1 to 4; datasets of more contacts are left out.
    pub max_contacts: usize,
}

/// Rule that picks the touchable skin among the solid's boundary faces.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(tag = "rule", rename_all = "snake_case", deny_unknown_fields)]
pub enum ContactRegion {
    /// Faces that look away from the limb's axis, far enough from it, within a length of it.
    Radial {
        /// Smallest cosine between the face's normal and the radial direction.
        min_normal_dot_radial: f64,
        /// Smallest distance from the axis, m.
        min_radius_m: f64,
        /// Range along the axis, m.
        axial_range_m: [f64; 2],
    },
    /// Faces that see the outside, found by casting rays.
    OuterSkin {},
}

/// Direction of a contact's force.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum LoadDirection {
    /// Against the skin's outward normal.
    Normal,
    /// Towards the limb's axis, without axial part, as in the authors' loads.
    Radial,
}

/// The units that a deck's lengths may have, by their signs.
mod deck_unit {
    use hapdef_mesh::LengthUnit;
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serializer};

    const ALLOWED: [LengthUnit; 2] = [LengthUnit::Metre, LengthUnit::Millimetre];

    #[expect(clippy::trivially_copy_pass_by_ref, reason = "serde calls it so")]
    pub(super) fn serialize<S: Serializer>(unit: &LengthUnit, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(unit.symbol())
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<LengthUnit, D::Error> {
        let sign = String::deserialize(from)?;
        let unit = ALLOWED.into_iter().find(|unit| unit.symbol() == sign);
        unit.ok_or_else(|| D::Error::unknown_variant(&sign, &["m", "mm"]))
    }
}
