//! Thin walls: from a surface or a closed solid to a shell's mid-surface and thickness, and from a
//! skin with a thickness to a wall of solid elements.

pub(crate) mod extrude;
mod params;
mod pieces;
mod solid;
mod surface;
mod walls;

pub use extrude::{ExtrudeParams, Extrusion, extrude};
pub use params::SolidShellParams;
pub use solid::{SolidShell, SolidShellInfo, measure_solid, shell_from_solid};
pub use surface::{ShellSurface, SkinSide};
pub use walls::WallKind;
