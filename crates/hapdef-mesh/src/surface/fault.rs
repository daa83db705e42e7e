//! Why a triangle surface can't become a shell, be remeshed or be extruded.

use super::crossing::{Crossing, number, places};
use super::defects::SurfaceDefects;

/// What is wrong, with the numbers found. Vertices, triangles and bodies count from 0; volumes of
/// surfaces that are not closed are what the divergence theorem gives for the triangles there are.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum SurfaceFault {
    #[error("{wanted} is wanted, but the surface has {defects}{}", remedies(defects))]
    Defects { wanted: &'static str, defects: Box<SurfaceDefects> },
    #[error(
        "one solid is wanted, but the surface holds {} bodies with volumes {} cm3: choose one of \
         them (`BodyChoice`)",
        volumes_m3.len(), cubic_centimetres(volumes_m3)
    )]
    Bodies { volumes_m3: Vec<f64> },
    #[error("body {body} is wanted, but the surface has {n_bodies} bodies (0-based)")]
    NoSuchBody { body: usize, n_bodies: usize },
    #[error(
        "the enclosed volume is {volume_m3:.3e} m3, but a solid in this bounding box has more than 0 \
         and at most {box_volume_m3:.3e} m3: the triangles face inward or overlap"
    )]
    Volume { volume_m3: f64, box_volume_m3: f64 },
    #[error(
        "{what} goes through itself: {} pairs of triangles cross, at {}; {advice}",
        number(crossings),
        places(crossings)
    )]
    Crosses { what: &'static str, crossings: Vec<Crossing>, advice: &'static str },
    #[error(
        "the surface is {longest_m} m long, which no limb is (0.05 to 0.8 m): read it in its own \
         unit ({candidates}), or allow any size"
    )]
    UnitUnknown { longest_m: f64, candidates: String },
    #[error("{name} is {found}; it must be {wanted}")]
    Parameter { name: &'static str, found: f64, wanted: &'static str },
    #[error("{n_values} thicknesses are given for {n_nodes} nodes")]
    ThicknessCount { n_values: usize, n_nodes: usize },
    #[error("the thickness at node {node} is {thickness_m} m; it must be above 0 and finite")]
    Thickness { node: usize, thickness_m: f64 },
    #[error("node {node} of the skin has no normal: its faces cancel, or no face uses it")]
    NoNormal { node: usize },
    #[error(
        "triangle {triangle} turns over when its nodes move {offset_m:.6} m to the middle of the \
         wall: the wall is too thick for the skin's edges or curvature there; thin it or remesh \
         coarser"
    )]
    OffsetFolds { triangle: usize, offset_m: f64 },
    #[error(
        "the wedge under triangle {triangle}, layer {layer}, folds: a ten-node tetrahedron there \
         has det J = {jacobian_m3:.3e} m3 (thickness {thickness_m} m at node {node}); thin the wall \
         or remesh coarser"
    )]
    ExtrusionFolds {
        triangle: usize,
        layer: usize,
        node: usize,
        thickness_m: f64,
        jacobian_m3: f64,
    },
    #[error("none of the {n_triangles} triangles sees the outside: lower the free fraction")]
    NoOuterSkin { n_triangles: usize },
    #[error(
        "{:.1} % of the outer skin is no shell, more than the {:.1} % allowed: {:.1} % solid core, \
         {:.1} % without a parallel wall, {:.1} % thicker than {max_thickness_ratio} of the limb, \
         {:.1} % in islands (volume {:.3} cm3); use a solid model, or a skin with a given thickness",
        100.0 * share, 100.0 * allowed_share, 100.0 * solid_core_share,
        100.0 * no_wall_share, 100.0 * too_thick_share, 100.0 * island_share, volume_m3 * 1e6
    )]
    NotAShell {
        share: f64,
        allowed_share: f64,
        solid_core_share: f64,
        no_wall_share: f64,
        too_thick_share: f64,
        island_share: f64,
        max_thickness_ratio: f64,
        volume_m3: f64,
    },
    #[error(
        "body {body} faces inward (volume {volume_m3:.3e} m3) like a cavity, but does not lie inside \
         the solid"
    )]
    CavityOutside { body: usize, volume_m3: f64 },
    #[error(
        "the shell has {:.3} cm3 and the solid {:.3} cm3, a difference of {:.1} % where {:.1} % is \
         allowed: ribs, cores or rims are missing from the shell; use a solid model",
        shell_volume_m3 * 1e6, solid_volume_m3 * 1e6, 100.0 * difference, 100.0 * allowed_difference
    )]
    ShellVolume {
        shell_volume_m3: f64,
        solid_volume_m3: f64,
        difference: f64,
        allowed_difference: f64,
    },
    #[error(
        "an edge length of {target_edge_m} m on {area_m2:.6} m2 makes about {n_triangles} triangles, \
         more than the {max_triangles} allowed"
    )]
    TooManyTriangles { target_edge_m: f64, area_m2: f64, n_triangles: usize, max_triangles: usize },
    #[error(
        "the remeshed surface is {distance_m:.6} m from the given one (allowed {max_distance_m:.6}) and \
         its volume changes by {volume_change:.4} (allowed {max_volume_change}), relative: take a \
         shorter edge length"
    )]
    RemeshStrays {
        distance_m: f64,
        max_distance_m: f64,
        volume_change: f64,
        max_volume_change: f64,
    },
}

/// The settings that may help, in the library and on the command line.
fn remedies(defects: &SurfaceDefects) -> String {
    let open = "; join vertices that lie farther apart (`weld_tolerance_m`, --weld), if its seams are open";
    let misoriented = "; turn triangles over until neighbours agree (`orient`, --orient)";
    [(defects.open_edges.n, open), (defects.misoriented_edges.n, misoriented)]
        .into_iter()
        .filter_map(|(n, remedy)| (n > 0).then_some(remedy))
        .collect()
}

fn cubic_centimetres(volumes_m3: &[f64]) -> String {
    let texts: Vec<String> = volumes_m3.iter().map(|v| format!("{:.3}", v * 1e6)).collect();
    texts.join(", ")
}
