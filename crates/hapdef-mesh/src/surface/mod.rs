//! Triangle surfaces: files, quality, defects, welding, self-intersections, nearest points, refinement.

pub(crate) mod clean;
pub(crate) mod closest;
mod crossing;
pub(crate) mod curve;
mod defects;
mod fault;
pub(crate) mod find_defects;
mod orient;
pub(crate) mod quality;
pub(crate) mod read;
mod refine;
pub(crate) mod self_intersection;
pub(crate) mod topology;
pub(crate) mod triangles;
pub(crate) mod weld;
mod write_stl;

pub use clean::{BodyChoice, CleanInfo, CleanParams, clean_surface};
pub use closest::{Closest, ClosestPoint};
pub use crossing::Crossing;
pub use curve::FaceCurve;
pub use defects::{Defect, SurfaceDefects};
pub use fault::SurfaceFault;
pub use quality::{QualityReport, SLIVER_ANGLE_DEG};
pub use read::read_surface;
pub use refine::RefinedSurface;
pub use self_intersection::self_intersections;
pub use triangles::{BoundingBox, SurfaceMesh};
pub use weld::WeldInfo;
pub use write_stl::write_stl;
