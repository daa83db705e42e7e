//! Limb geometry: triangle surfaces and solid finite-element decks, what is wrong with them, and
//! where things are on them.
//!
//! Knows nothing of forces, materials, networks or scenes. Lengths are metres throughout; a reader
//! that meets another unit scales once, at the border.

pub mod surface;

pub mod solid;

pub mod skin;

pub mod shell;

pub mod gltf;

pub mod deck;

pub mod remesh;

pub mod shin;

pub mod colour;

#[cfg(feature = "wrap")]
pub mod wrap;

mod atomic;
mod beside;
#[cfg(feature = "wrap")]
mod carve;
mod error;
mod ids;
mod unit;

pub use self::gltf::{
    GltfFault, GltfInfo, GltfParams, GltfPart, GltfSurface, VertexField, read_gltf, write_glb,
};
pub use self::remesh::{RemeshInfo, RemeshParams, SurfaceDistance, remesh, surface_distance};
pub use self::shin::{Shin, ShinHole, ShinOutline, ShinParams, shin};
pub use atomic::atomic_write;
pub use beside::folder_of;
#[cfg(feature = "wrap")]
pub use carve::{Pocket, trimmed, with_pockets};
pub use deck::{
    DeckFault, DeckMaterial, DeckParams, DeckReading, FaceTraction, LabelledDisplacements,
    SolidDeck, deck_includes, largest_difference, read_deck, read_deck_with, read_displacements,
    write_inp,
};
pub use error::MeshError;
pub use ids::{FeNodeId, GaugeId, SurfaceNodeId, VirtualGaugeId};
pub use shell::{
    ExtrudeParams, Extrusion, ShellSurface, SkinSide, SolidShell, SolidShellInfo, SolidShellParams,
    WallKind, extrude, measure_solid, shell_from_solid,
};
pub use skin::{
    GaugePatch, HeldSolid, OuterSkinParams, PointIndex, RadialRegionParams, SkinRegion, Wall,
    clear_nodes, face_positions, farthest_nodes, gauge_patch, outer_skin, radial_region, wall,
};
pub use solid::{
    BoundarySurface, PointField, PointValues, RefinedSolid, SolidBody, SolidFault, TET10_EDGES,
    TET10_FACES, Tet10Mesh, Tri6Face, connected_faces, is_folded, kuhn_block, kuhn_cell, kuhn_tube,
    refine_unfolded, tet10, tri6, write_vtu,
};
pub use surface::{
    BodyChoice, BoundingBox, CleanInfo, CleanParams, Closest, ClosestPoint, Crossing, Defect,
    FaceCurve, QualityReport, RefinedSurface, SLIVER_ANGLE_DEG, SurfaceDefects, SurfaceFault,
    SurfaceMesh, WeldInfo, clean_surface, read_surface, self_intersections, write_stl,
};
pub use unit::{LengthUnit, UnitGuess};
#[cfg(feature = "wrap")]
pub use wrap::{WrapFault, WrapInfo, WrapParams, WrapPlaces, WrapSeconds, Wrapped, wrap};
