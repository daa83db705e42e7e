//! Scene section about the strain gauges.

use serde::{Deserialize, Serialize};

/// All gauges of the limb.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct GaugeSpec {
    /// Length along the gauge's axis, m; the paper has 8 mm.
    pub length_m: f64,
    /// Width, m; the paper has 5 mm.
    pub width_m: f64,
    /// Share of a gauge's footprint that may hang over a hole or rim, in [0, 1); the reading is
    /// the mean over the rest.
    pub max_lost_share: f64,
    /// FE nodes of a gauge's patch of virtual gauges; the paper has 24.
    pub patch_nodes: usize,
    /// The gauges in channel order.
    pub sites: Vec<GaugeEntry>,
}

/// One gauge.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct GaugeEntry {
    /// Name for people.
    pub name: String,
    /// Centre on the wall, m.
    pub position_m: [f64; 3],
    /// Measuring direction; its part along the wall counts.
    pub axis: [f64; 3],
}

impl Default for GaugeSpec {
    /// The paper's size, 8 × 5 mm, and its 24 virtual gauges; a tenth of a footprint may hang over.
    /// No gauge.
    fn default() -> Self {
        Self {
            length_m: 8e-3,
            width_m: 5e-3,
            max_lost_share: 0.1,
            patch_nodes: 24,
            sites: Vec::new(),
        }
    }
}
