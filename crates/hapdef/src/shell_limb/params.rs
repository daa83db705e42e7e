//! What a shell limb is made from besides its surface, and the scene that it becomes.

use std::fmt;

use hapdef_mesh::{CleanParams, LengthUnit};
use hapdef_sim::{ShellKind, SimError};
use nalgebra::Vector3;
use serde::Serialize;

use crate::error::HapdefError;
use crate::new_limb::{HELD_SHARE, SKIN, Skin, SkinParams, WALL, WallChoice};
use crate::scene::{
    Axis, ContactRegion, ContactSpec, Geometry, LimbEnd, MaterialSpec, Mount, Scene, Shape,
    SkinShape, WallSide, WallSolver, WallThickness,
};

/// How a surface becomes a shell with gauges.
#[derive(Clone, Debug)]
pub struct ShellLimbParams {
    /// What is done to the surface first; a surface that is no oriented body then, or that no wall fits
    /// behind, is wrapped.
    pub clean: CleanParams,
    /// The wall.
    pub wall: WallChoice,
    /// Which side of a constant wall the surface is; a measured one has its outside there.
    pub side: WallSide,
    /// The edge length to which the skin is remeshed, m; a fortieth of the longest extent when not
    /// given, shortened where that strays or folds.
    pub edge_m: Option<f64>,
    /// The axis along which the ends lie: 0 is x; the longest extent when not given.
    pub mount_axis: Option<usize>,
    /// The end that is held.
    pub mount_end: LimbEnd,
    /// How far from that end nodes are clamped, m; 5 % of the extent when not given.
    pub mount_m: Option<f64>,
    /// Gauges, spread over the inner side of the wall.
    pub n_gauges: usize,
    /// The wall's material.
    pub material: MaterialSpec,
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

/// The held end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MountInfo {
    /// `x`, `y` or `z`.
    pub axis: char,
    /// Which end of it.
    pub end: LimbEnd,
    /// How far from the end nodes are clamped, m.
    pub length_m: f64,
    /// Clamped nodes of the shell.
    pub n_clamped: usize,
}

impl fmt::Display for MountInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let end = match self.end {
            LimbEnd::Low => "low",
            LimbEnd::High => "high",
        };
        let (axis, mm, n) = (self.axis, 1e3 * self.length_m, self.n_clamped);
        write!(f, "{end} end of {axis}, {mm:.2} mm: {n} nodes clamped")
    }
}

impl ShellLimbParams {
    /// The surface is the outside of `wall` of PA2200; ten gauges, the default shell, a tip of 2 mm, 240
    /// presses, one thread, held at the low end of the longest axis.
    #[must_use]
    pub fn new(wall: WallChoice) -> Self {
        Self {
            clean: CleanParams::default(),
            wall,
            side: WallSide::Outer,
            edge_m: None,
            mount_axis: None,
            mount_end: LimbEnd::Low,
            mount_m: None,
            n_gauges: 10,
            material: MaterialSpec::PA2200,
            kind: ShellKind::default(),
            tip_radius_m: 2e-3,
            n_presses: 240,
            n_solid_halvings: None,
            n_threads: 1,
        }
    }

    /// Which side of the wall the skin is.
    pub(super) fn side(&self) -> WallSide {
        match self.wall {
            WallChoice::Constant(_) => self.side,
            WallChoice::Measured => WallSide::Outer,
        }
    }

    pub(super) fn skin(&self) -> SkinParams {
        SkinParams {
            clean: self.clean,
            wall: self.wall,
            side: self.side().into(),
            edge_m: self.edge_m,
            is_shell: true,
            n_threads: self.n_threads,
        }
    }

    /// The scene of a skin, without gauges yet, and where it is held. All of the skin may be touched.
    ///
    /// # Errors
    /// [`HapdefError::Sim`] for a mount longer than the limb.
    pub(super) fn scene(&self, skin: &Skin) -> Result<(Scene, MountInfo), HapdefError> {
        let size_m = skin.surface.bounding_box().size_m();
        let along = self.mount_axis.unwrap_or(size_m.imax());
        let length_m = self.mount_m.unwrap_or(HELD_SHARE * size_m[along]);
        if !(length_m > 0.0 && length_m < size_m[along]) {
            return Err(SimError::Parameter {
                what: "the length of the mount (m)",
                value: length_m,
                expected: "above 0 and shorter than the limb",
            }
            .into());
        }
        let wall = match self.wall {
            WallChoice::Constant(wall_m) => WallThickness::Constant(wall_m),
            // as it is called where it is written
            WallChoice::Measured => WallThickness::File(WALL.into()),
        };
        let (file, side) = (SKIN.into(), self.side());
        let shape = Shape::Skin(SkinShape { file, wall, side, solver: WallSolver::Shell });
        let axis = Axis { point_m: [0.0; 3], direction: Vector3::<f64>::ith(along, 1.0).into() };
        let scene = Scene {
            name: String::new(),
            seed: 1,
            geometry: Geometry {
                shape,
                unit: LengthUnit::Metre,
                axis: Some(axis),
                refinements: 0,
                skin_gltf: None,
            },
            material: Some(self.material),
            mount: Mount::End { end: self.mount_end, length_m },
            contact: ContactSpec {
                region: ContactRegion::OuterSkin {},
                tip_radius_m: self.tip_radius_m,
                ..ContactSpec::default()
            },
            loads: None,
            gauges: Default::default(),
            rig: Default::default(),
            estimator: Default::default(),
            outputs: None,
        };
        let axis = ['x', 'y', 'z'][along];
        Ok((scene, MountInfo { axis, end: self.mount_end, length_m, n_clamped: 0 }))
    }
}
