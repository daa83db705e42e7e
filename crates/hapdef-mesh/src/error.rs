//! What can go wrong with a limb's geometry.

use std::path::PathBuf;

use crate::unit::LIMB_LENGTH_M;
use crate::{DeckFault, GltfFault, SolidFault, SurfaceFault};

/// Why a mesh could not be read, built or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum MeshError {
    #[error("cannot {action} {}: {cause}", path.display())]
    Io { action: &'static str, path: PathBuf, cause: std::io::Error },
    #[error("{}: {fault}", path.display())]
    Gltf { path: PathBuf, fault: Box<GltfFault> },
    #[error("{}: no surface could be read: {cause}; export it again", path.display())]
    SurfaceFile { path: PathBuf, cause: String },
    #[error(
        "triangle {triangle} uses vertex {vertex}, but the surface has {n_vertices} vertices (0-based)"
    )]
    VertexOutOfRange { triangle: usize, vertex: u32, n_vertices: usize },
    #[error("surface vertex {vertex} is at ({}, {}, {}), which is not finite", position[0], position[1], position[2])]
    VertexNotFinite { vertex: usize, position: [f64; 3] },
    #[error("the surface has {n_vertices} vertices and no triangle; at least one is needed")]
    NoTriangles { n_vertices: usize },
    #[error("the surface has {n_vertices} vertices, more than 32-bit indices can name")]
    TooManyVertices { n_vertices: usize },
    #[error("the weld tolerance is {tolerance_m} m; it must be finite and at least 0")]
    WeldTolerance { tolerance_m: f64 },
    #[error("field `{field}` has {found} values, but the mesh has {expected} points")]
    FieldLength { field: String, expected: usize, found: usize },
    #[error("field `{field}` has {value} at point {point}, which is not finite")]
    FieldNotFinite { field: String, point: usize, value: f64 },
    #[error(
        "the colour range of field `{field}` is {low}..{high}; it must be finite with low <= high"
    )]
    FieldRange { field: String, low: f64, high: f64 },
    #[error("field name `{field}` is not usable here: {why}")]
    FieldName { field: String, why: &'static str },
    #[error("cannot write {}: {what}", path.display())]
    NotWritable { path: PathBuf, what: String },
    #[error(transparent)]
    Solid(#[from] SolidFault),
    #[error(transparent)]
    Surface(#[from] SurfaceFault),
    #[cfg(feature = "wrap")]
    #[error(transparent)]
    Wrap(#[from] crate::WrapFault),
    #[cfg(feature = "wrap")]
    #[error("the body can't be cut: {cause}; a closed body without crossings is wanted")]
    Carve { cause: String },
    #[error(
        "no boundary face belongs to the contact region: {} (the solid measures {:.6} x {:.6} x {:.6} m)",
        region_remedy(size_m), size_m[0], size_m[1], size_m[2]
    )]
    EmptySkin { size_m: [f64; 3] },
    #[error("the contact region has no outward normal at FE node {node}: its faces cancel")]
    SkinNormal { node: u32 },
    #[error("contact region: {why}")]
    RegionParams { why: &'static str },
    #[error(
        "a gauge centred at ({:.6}, {:.6}, {:.6}) m is {distance_m:.6} m from the nearest wall face, more than \
         the {max_distance_m} m allowed: move it onto the wall",
        centre_m[0], centre_m[1], centre_m[2]
    )]
    GaugeOffWall { centre_m: [f64; 3], distance_m: f64, max_distance_m: f64 },
    #[error(
        "the wall at gauge centre ({:.6}, {:.6}, {:.6}) m has {found} FE nodes, but a patch of {expected} is \
         wanted: refine the mesh there or take fewer",
        centre_m[0], centre_m[1], centre_m[2]
    )]
    GaugePatchTooSmall { centre_m: [f64; 3], expected: usize, found: usize },
    #[error("{}: {fault}", path.display())]
    Deck { path: PathBuf, fault: DeckFault },
    #[error("the wall's greatest thickness is {max_thickness_m} m; it must be above 0")]
    WallThickness { max_thickness_m: f64 },
    #[error(
        "the skin face of element {element} is not on the given boundary, or the material behind \
         it has no end: take skin and boundary from the same mesh"
    )]
    OpenWall { element: usize },
    #[error("shin: {why}")]
    ShinParams { why: &'static str },
}

/// What to do where no face is touchable: mend a unit that makes the solid no limb, or the region.
fn region_remedy(size_m: &[f64; 3]) -> String {
    let longest_m = size_m.iter().copied().fold(0.0, f64::max);
    if LIMB_LENGTH_M.contains(&longest_m) {
        return "widen its limits".to_owned();
    }
    let (low, high) = (LIMB_LENGTH_M.start(), LIMB_LENGTH_M.end());
    format!(
        "check the unit, because no limb is {longest_m:.6} m long ({low} to {high} m), or widen the \
         region's limits"
    )
}
