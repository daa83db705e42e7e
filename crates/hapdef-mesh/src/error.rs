//! What can go wrong with a limb's geometry.

use std::path::PathBuf;

use crate::unit::LIMB_LENGTH_M;
use crate::{DeckFault, GltfFault, SolidFault, SurfaceFault};

/// Why a mesh could not be read, built or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// A file could not be opened, read, written or renamed.
    #[error("cannot {action} {}: {cause}", path.display())]
    Io {
        /// What was being done: `read`, `write`, `rename`.
        action: &'static str,
        /// The file concerned.
        path: PathBuf,
        /// The operating system's answer.
        cause: std::io::Error,
    },
    /// A glTF or GLB file breaks the format, or holds what this reader does not take.
    #[error("{}: {fault}", path.display())]
    Gltf {
        /// The file as the caller named it.
        path: PathBuf,
        /// The place in the file, what was expected and what was found.
        fault: Box<GltfFault>,
    },
    /// A triangle names a vertex that is not there.
    #[error(
        "triangle {triangle} uses vertex {vertex}, but the surface has {n_vertices} vertices (0-based)"
    )]
    VertexOutOfRange {
        /// The triangle, counted from 0.
        triangle: usize,
        /// The vertex it names.
        vertex: u32,
        /// How many vertices there are.
        n_vertices: usize,
    },
    /// A surface vertex has a coordinate that is not a finite number.
    #[error("surface vertex {vertex} is at ({}, {}, {}), which is not finite", position[0], position[1], position[2])]
    VertexNotFinite {
        /// The vertex, counted from 0.
        vertex: usize,
        /// Its coordinates, m.
        position: [f64; 3],
    },
    /// A surface without triangles.
    #[error("the surface has {n_vertices} vertices and no triangle; at least one is needed")]
    NoTriangles {
        /// How many vertices there are.
        n_vertices: usize,
    },
    /// A surface with more vertices than 32-bit indices can name.
    #[error("the surface has {n_vertices} vertices, more than 32-bit indices can name")]
    TooManyVertices {
        /// How many vertices there are.
        n_vertices: usize,
    },
    /// A tolerance that is negative or not finite.
    #[error("the weld tolerance is {tolerance_m} m; it must be finite and at least 0")]
    WeldTolerance {
        /// The tolerance given, m.
        tolerance_m: f64,
    },
    /// A field whose length is not the number of points it belongs to.
    #[error("field `{field}` has {found} values, but the mesh has {expected} points")]
    FieldLength {
        /// The field's name.
        field: String,
        /// Points in the mesh.
        expected: usize,
        /// Values in the field.
        found: usize,
    },
    /// A field value or a bound of the colour range that cannot be drawn.
    #[error("field `{field}` has {value} at point {point}, which is not finite")]
    FieldNotFinite {
        /// The field's name.
        field: String,
        /// The point, counted from 0.
        point: usize,
        /// The value found.
        value: f64,
    },
    /// A colour range whose ends are not finite or not in order.
    #[error(
        "the colour range of field `{field}` is {low}..{high}; it must be finite with low <= high"
    )]
    FieldRange {
        /// The field's name.
        field: String,
        /// The lower end.
        low: f64,
        /// The upper end.
        high: f64,
    },
    /// A field name that the file format cannot carry.
    #[error("field name `{field}` is not usable here: {why}")]
    FieldName {
        /// The name given.
        field: String,
        /// What the format asks for.
        why: &'static str,
    },
    /// A coordinate or count too large for the format being written.
    #[error("cannot write {}: {what}", path.display())]
    NotWritable {
        /// The file to be written.
        path: PathBuf,
        /// What does not fit.
        what: String,
    },
    /// Nodes and elements that don't make a solid mesh.
    #[error(transparent)]
    Solid(#[from] SolidFault),
    /// A triangle surface that can't become a shell, be remeshed or be extruded.
    #[error(transparent)]
    Surface(#[from] SurfaceFault),
    /// No boundary face belongs to the contact region.
    #[error(
        "no boundary face belongs to the contact region: {} (the solid measures {:.6} x {:.6} x {:.6} m)",
        region_remedy(size_m), size_m[0], size_m[1], size_m[2]
    )]
    EmptySkin {
        /// The solid's bounding box, m.
        size_m: [f64; 3],
    },
    /// The faces around a node of the contact region face opposite ways.
    #[error("the contact region has no outward normal at FE node {node}: its faces cancel")]
    SkinNormal {
        /// The node, counted from 0.
        node: u32,
    },
    /// Limits of a contact region that can't be used.
    #[error("contact region: {why}")]
    RegionParams {
        /// What is asked for.
        why: &'static str,
    },
    /// A gauge that is not on the wall it should be glued to.
    #[error(
        "a gauge centred at ({:.6}, {:.6}, {:.6}) m is {distance_m:.6} m from the nearest wall face, more than \
         the {max_distance_m} m allowed: move it onto the wall",
        centre_m[0], centre_m[1], centre_m[2]
    )]
    GaugeOffWall {
        /// The gauge centre, m.
        centre_m: [f64; 3],
        /// Its distance to the nearest wall face, m; infinite if there is none or the centre is
        /// not finite.
        distance_m: f64,
        /// The distance allowed, m.
        max_distance_m: f64,
    },
    /// A wall with fewer nodes than a gauge's patch needs.
    #[error(
        "the wall at gauge centre ({:.6}, {:.6}, {:.6}) m has {found} FE nodes, but a patch of {expected} is \
         wanted: refine the mesh there or take fewer",
        centre_m[0], centre_m[1], centre_m[2]
    )]
    GaugePatchTooSmall {
        /// The gauge centre, m.
        centre_m: [f64; 3],
        /// Nodes wanted.
        expected: usize,
        /// Nodes on the wall.
        found: usize,
    },
    /// A solid deck that breaks its format, or holds what the reader does not take.
    #[error("{}: {fault}", path.display())]
    Deck {
        /// The deck as the caller named it.
        path: PathBuf,
        /// The place in the deck, what was expected and what was found.
        fault: DeckFault,
    },
    /// A limit of the wall's thickness that can't be used.
    #[error("the wall's greatest thickness is {max_thickness_m} m; it must be above 0")]
    WallThickness {
        /// The limit given, m.
        max_thickness_m: f64,
    },
    /// A skin face without wall behind it.
    #[error(
        "the skin face of element {element} is not on the given boundary, or the material behind \
         it has no end: take skin and boundary from the same mesh"
    )]
    OpenWall {
        /// The element, counted from 0.
        element: usize,
    },
    /// Measures that don't make a limb.
    #[error("shin: {why}")]
    ShinParams {
        /// What is asked for.
        why: &'static str,
    },
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
