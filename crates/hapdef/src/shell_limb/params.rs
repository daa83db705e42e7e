//! What a shell limb is made from besides its surface.

use hapdef_mesh::{CleanParams, SkinSide};
use hapdef_sim::{IsotropicMaterial, ShellKind};

/// How thick the wall is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WallChoice {
    /// The same everywhere, m: the surface is a skin.
    Constant(f64),
    /// As measured: the surface is a closed solid with an outer and an inner wall.
    Measured,
}

/// An end of the limb's bounding box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MountEnd {
    /// Where the coordinate is smallest.
    Low,
    /// Where the coordinate is largest.
    High,
}

/// Where the limb is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MountChoice {
    /// The axis along which the ends lie: 0 is x; the longest extent when not given.
    pub axis: Option<usize>,
    /// The end that is held.
    pub end: MountEnd,
    /// How far from that end nodes are clamped, m; 5 % of the extent when not given.
    pub length_m: Option<f64>,
}

/// How a surface becomes a shell with gauges.
#[derive(Clone, Debug, PartialEq)]
pub struct ShellLimbParams {
    /// What is done to the surface first; by default nothing.
    pub clean: CleanParams,
    /// The wall.
    pub wall: WallChoice,
    /// Which side of a constant wall the surface is; a measured one has its outside there.
    pub side: SkinSide,
    /// The edge length to which the skin is remeshed, m; a fortieth of the longest extent when not
    /// given, halved at most twice where that strays or folds.
    pub edge_m: Option<f64>,
    /// Where the limb is held.
    pub mount: MountChoice,
    /// Gauges, spread over the inner side of the wall.
    pub n_gauges: usize,
    /// Length and width of a gauge, m.
    pub gauge_size_m: [f64; 2],
    /// The wall's material.
    pub material: IsotropicMaterial,
    /// The bending theory.
    pub kind: ShellKind,
    /// Radius of the tip in comparisons with a solid, m.
    pub tip_radius_m: f64,
    /// Presses whose displacement is compared with a solid's; at most 24 where that is too large to
    /// be factored.
    pub n_presses: usize,
    /// How often the edges of the extruded solid are halved; from 1 on the change by the last
    /// halving is reported. Once when not given, if that makes no more than 150,000 nodes.
    pub n_solid_halvings: Option<usize>,
    /// Worker threads; results don't depend on it.
    pub n_threads: usize,
}

impl ShellLimbParams {
    /// The surface is the outside of `wall`; ten gauges of 8 × 5 mm, the default shell, a tip of
    /// 2 mm, 240 presses, one thread, held at the low end of the longest axis.
    #[must_use]
    pub fn new(wall: WallChoice, material: IsotropicMaterial) -> Self {
        Self {
            clean: CleanParams::default(),
            wall,
            side: SkinSide::Outer,
            edge_m: None,
            mount: MountChoice { axis: None, end: MountEnd::Low, length_m: None },
            n_gauges: 10,
            gauge_size_m: [8e-3, 5e-3],
            material,
            kind: ShellKind::default(),
            tip_radius_m: 2e-3,
            n_presses: 240,
            n_solid_halvings: None,
            n_threads: 1,
        }
    }
}
