//! Scene sections about the limb itself: material, mount, contact.

use serde::{Deserialize, Serialize};

use super::rig::is_zero;

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
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
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
    /// All nodes on a plane and beyond it.
    Plane {
        /// A point on it, m.
        point_m: [f64; 3],
        /// Its normal, out of the limb, towards what holds it.
        normal: [f64; 3],
    },
    /// All nodes near an end of the limb along `geometry.axis`.
    End {
        /// Which one.
        end: LimbEnd,
        /// How far from it, m.
        length_m: f64,
    },
}

/// An end of the limb along its axis.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LimbEnd {
    /// Where the axis comes from.
    Low,
    /// Where it points to.
    High,
}

/// Where and how the limb is touched.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct ContactSpec {
    /// The skin that may be touched; its nodes carry the deformation map.
    #[serde(deserialize_with = "super::tag::region")]
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
    /// Faces that see the outside: of a skin's wall its outer side, of a deck what casting rays
    /// finds.
    OuterSkin {},
    /// The outer skin without the faces at held nodes.
    FreeSkin {
        /// Faces with a node nearer than this to a held one are left out, too, m.
        #[serde(default, skip_serializing_if = "is_zero")]
        mount_gap_m: f64,
    },
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

impl Default for ContactSpec {
    /// A tip of 2 mm on all of the free skin, along its normal, up to 34 N; as many as four contacts,
    /// 12 mm apart.
    fn default() -> Self {
        Self {
            region: ContactRegion::FreeSkin { mount_gap_m: 0.0 },
            tip_radius_m: 2e-3,
            force_range_n: [0.0, 34.0],
            direction: LoadDirection::Normal,
            min_spacing_m: 12e-3,
            max_contacts: 4,
        }
    }
}

impl MaterialSpec {
    /// PA2200, laser-sintered polyamide: what a limb is made of of which nothing else is known.
    pub const PA2200: Self =
        Self { youngs_modulus_pa: 1.7e9, poissons_ratio: 0.394, density_kg_m3: 930.0 };
}
