//! One contact of a sample.

use serde::{Deserialize, Serialize};

/// Where something presses on a limb, and how hard.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// Index of the surface node that carries the force.
    pub surface_node: u32,
    /// Position of that node in the limb's frame, metres.
    pub position_m: [f32; 3],
    /// Normal force, newtons, positive into the limb.
    pub force_n: f32,
}
