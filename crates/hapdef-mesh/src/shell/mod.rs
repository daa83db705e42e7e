//! From a triangle surface to a shell: what is wrong with it, what a caller asks to be cleaned,
//! the outer skin of a closed solid and its wall, and the shell's surface.

mod clean;
mod defects;
mod fault;
mod params;
mod pieces;
mod solid;
mod surface;
mod walls;

pub use clean::{BodyChoice, CleanInfo, CleanParams, clean_surface};
pub use defects::{Defect, SurfaceDefects};
pub(crate) use defects::{check_closed, check_manifold, check_size};
pub use fault::SurfaceFault;
pub use params::SolidShellParams;
pub use solid::{SolidShell, SolidShellInfo, WallKind, measure_solid, shell_from_solid};
pub use surface::{ShellSurface, SkinSide};
pub(crate) use surface::{check_thickness, steps};
