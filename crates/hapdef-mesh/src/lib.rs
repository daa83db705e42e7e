//! Limb geometry: triangle surfaces and solid finite-element decks, what is wrong with them, and
//! where things are on them.
//!
//! Knows nothing of forces, materials, networks or scenes. Lengths are metres throughout; a reader
//! that meets another unit scales once, at the border.

mod atomic;
mod boundary;
mod closest;
pub mod colour;
mod curve;
mod deck;
mod error;
mod extrude;
mod gltf;
mod ids;
mod kuhn;
mod neighbours;
mod patch;
mod quality;
mod rays;
mod refine;
mod refine_surface;
mod refined;
mod remesh;
mod self_intersection;
mod shell;
mod shin;
mod sites;
mod skin;
mod solid;
mod solid_fault;
mod surface;
pub mod tet10;
mod topology;
pub mod tri6;
mod unit;
mod vtu;
mod wall;
mod weld;

pub use self::gltf::{
    GltfFault, GltfInfo, GltfParams, GltfPart, GltfSurface, VertexField, read_gltf, write_glb,
};
pub use atomic::atomic_write;
pub use boundary::{BoundarySurface, TET10_FACES, Tri6Face, connected_faces};
pub use closest::{Closest, ClosestPoint};
pub use curve::FaceCurve;
pub use deck::{
    DeckFault, DeckMaterial, DeckParams, FaceTraction, SolidDeck, read_deck, read_deck_with,
    write_inp,
};
pub use error::MeshError;
pub use extrude::{ExtrudeParams, Extrusion, extrude};
pub use ids::{FeNodeId, GaugeId, SurfaceNodeId, VirtualGaugeId};
pub use kuhn::{kuhn_block, kuhn_cell, kuhn_tube};
pub use neighbours::PointIndex;
pub use patch::{GaugePatch, gauge_patch};
pub use quality::{QualityReport, SLIVER_ANGLE_DEG};
pub use refine_surface::RefinedSurface;
pub use refined::{RefinedSolid, is_folded, refine_unfolded};
pub use remesh::{RemeshInfo, RemeshParams, SurfaceDistance, remesh, surface_distance};
pub use self_intersection::{Crossing, self_intersections};
pub use shell::{
    BodyChoice, CleanInfo, CleanParams, Defect, ShellSurface, SkinSide, SolidShell, SolidShellInfo,
    SolidShellParams, SurfaceDefects, SurfaceFault, WallKind, clean_surface, measure_solid,
    shell_from_solid,
};
pub use shin::{Shin, ShinHole, ShinOutline, ShinParams, shin};
pub use sites::{clear_nodes, farthest_nodes};
pub use skin::{RadialRegionParams, SkinRegion, face_positions, radial_region};
pub use solid::{TET10_EDGES, Tet10Mesh};
pub use solid_fault::SolidFault;
pub use surface::{BoundingBox, SurfaceMesh};
pub use unit::{LengthUnit, UnitGuess};
pub use vtu::{PointField, PointValues, write_vtu};
pub use wall::{OuterSkinParams, Wall, outer_skin, wall};
pub use weld::WeldInfo;
