//! Why a triangle surface can't become a shell, be remeshed or be extruded.

use super::crossing::{Crossing, number, places};
use super::defects::SurfaceDefects;

/// What is wrong, with the numbers found. Vertices, triangles and bodies count from 0; volumes of
/// surfaces that are not closed are what the divergence theorem gives for the triangles there are.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceFault {
    /// Edges or triangles that the job at hand can't take.
    #[error("{wanted} is wanted, but the surface has {defects}")]
    Defects {
        /// What kind of surface was asked for.
        wanted: &'static str,
        /// What is in the way.
        defects: Box<SurfaceDefects>,
    },
    /// More than one solid.
    #[error(
        "one solid is wanted, but the surface holds {} bodies with volumes {} cm3: choose one of \
         them (`BodyChoice`)",
        volumes_m3.len(), cubic_centimetres(volumes_m3)
    )]
    Bodies {
        /// Signed volume of each body, m³; the cavity of a solid counts as a body of its own, with
        /// a negative volume.
        volumes_m3: Vec<f64>,
    },
    /// A body asked for that is not there.
    #[error("body {body} is wanted, but the surface has {n_bodies} bodies (0-based)")]
    NoSuchBody {
        /// The body asked for.
        body: usize,
        /// How many there are.
        n_bodies: usize,
    },
    /// A closed surface whose volume can't be a solid's.
    #[error(
        "the enclosed volume is {volume_m3:.3e} m3, but a solid in this bounding box has more than 0 \
         and at most {box_volume_m3:.3e} m3: the triangles face inward or overlap"
    )]
    Volume {
        /// The signed volume, m³.
        volume_m3: f64,
        /// The bounding box's volume, m³.
        box_volume_m3: f64,
    },
    /// A surface that goes through itself.
    #[error(
        "{what} goes through itself: {} pairs of triangles cross, at {}; {advice}",
        number(crossings),
        places(crossings)
    )]
    Crosses {
        /// Which surface.
        what: &'static str,
        /// The pairs; of a wall's triangles the outer side's come first, then the inner side's.
        crossings: Vec<Crossing>,
        /// What to do.
        advice: &'static str,
    },
    /// A surface whose size is no limb's in metres.
    #[error(
        "the surface is {longest_m} m long, which no limb is (0.05 to 0.8 m): read it in its own \
         unit ({candidates}), or allow any size"
    )]
    UnitUnknown {
        /// The bounding box's longest edge, m.
        longest_m: f64,
        /// The units that would make it a limb.
        candidates: String,
    },
    /// A parameter out of its range.
    #[error("{name} is {found}; it must be {wanted}")]
    Parameter {
        /// The parameter.
        name: &'static str,
        /// Its value.
        found: f64,
        /// What is asked for.
        wanted: &'static str,
    },
    /// A list whose length is not the number of nodes.
    #[error("{n_values} thicknesses are given for {n_nodes} nodes")]
    ThicknessCount {
        /// Values given.
        n_values: usize,
        /// Nodes of the surface.
        n_nodes: usize,
    },
    /// A thickness that no wall has.
    #[error("the thickness at node {node} is {thickness_m} m; it must be above 0 and finite")]
    Thickness {
        /// The node.
        node: usize,
        /// Its thickness, m.
        thickness_m: f64,
    },
    /// A node whose faces point all ways.
    #[error("node {node} of the skin has no normal: its faces cancel, or no face uses it")]
    NoNormal {
        /// The node.
        node: usize,
    },
    /// A skin that turns over on the way to the middle of its wall.
    #[error(
        "triangle {triangle} turns over when its nodes move {offset_m:.6} m to the middle of the \
         wall: the wall is too thick for the skin's edges or curvature there; thin it or remesh \
         coarser"
    )]
    OffsetFolds {
        /// The triangle.
        triangle: usize,
        /// The largest distance one of its nodes moves, m.
        offset_m: f64,
    },
    /// A wedge that turns over when the skin is extruded.
    #[error(
        "the wedge under triangle {triangle}, layer {layer}, folds: a ten-node tetrahedron there \
         has det J = {jacobian_m3:.3e} m3 (thickness {thickness_m} m at node {node}); thin the wall \
         or remesh coarser"
    )]
    ExtrusionFolds {
        /// The skin's triangle.
        triangle: usize,
        /// The layer, 0 outermost.
        layer: usize,
        /// The triangle's node with the greatest thickness.
        node: usize,
        /// That node's thickness, m.
        thickness_m: f64,
        /// The smallest Jacobian determinant found, m³.
        jacobian_m3: f64,
    },
    /// A solid without a face that sees the outside.
    #[error("none of the {n_triangles} triangles sees the outside: lower the free fraction")]
    NoOuterSkin {
        /// Triangles of the solid.
        n_triangles: usize,
    },
    /// A solid that is not a shell over too much of its surface.
    #[error(
        "{:.1} % of the outer skin is no shell, more than the {:.1} % allowed: {:.1} % solid core, \
         {:.1} % without a parallel wall, {:.1} % thicker than {max_thickness_ratio} of the limb, \
         {:.1} % in islands (volume {:.3} cm3); use a solid model, or a skin with a given thickness",
        100.0 * share, 100.0 * allowed_share, 100.0 * solid_core_share,
        100.0 * no_wall_share, 100.0 * too_thick_share, 100.0 * island_share, volume_m3 * 1e6
    )]
    NotAShell {
        /// Share of the outer skin's area that is not a shell.
        share: f64,
        /// The share allowed.
        allowed_share: f64,
        /// Share where the far side of the material is outer skin too.
        solid_core_share: f64,
        /// Share without a wall parallel to the skin.
        no_wall_share: f64,
        /// Share whose wall is too thick.
        too_thick_share: f64,
        /// Share of pieces apart from the largest.
        island_share: f64,
        /// The greatest thickness of a shell over the limb's extent behind it.
        max_thickness_ratio: f64,
        /// The solid's volume, m³.
        volume_m3: f64,
    },
    /// A cavity that is not inside its solid.
    #[error(
        "body {body} faces inward (volume {volume_m3:.3e} m3) like a cavity, but does not lie inside \
         the solid"
    )]
    CavityOutside {
        /// The body.
        body: usize,
        /// Its signed volume, m³.
        volume_m3: f64,
    },
    /// A shell that weighs another amount than its solid.
    #[error(
        "the shell has {:.3} cm3 and the solid {:.3} cm3, a difference of {:.1} % where {:.1} % is \
         allowed: ribs, cores or rims are missing from the shell; use a solid model",
        shell_volume_m3 * 1e6, solid_volume_m3 * 1e6, 100.0 * difference, 100.0 * allowed_difference
    )]
    ShellVolume {
        /// Area times thickness at mid-wall, m³.
        shell_volume_m3: f64,
        /// The volume the solid's surface encloses, m³.
        solid_volume_m3: f64,
        /// Their difference over the solid's.
        difference: f64,
        /// The difference allowed.
        allowed_difference: f64,
    },
    /// A target edge that asks for too fine a mesh.
    #[error(
        "an edge length of {target_edge_m} m on {area_m2:.6} m2 makes about {n_triangles} triangles, \
         more than the {max_triangles} allowed"
    )]
    TooManyTriangles {
        /// The edge length asked for, m.
        target_edge_m: f64,
        /// The surface's area, m².
        area_m2: f64,
        /// Triangles expected.
        n_triangles: usize,
        /// Triangles allowed.
        max_triangles: usize,
    },
    /// A remeshed surface that strays from the one it was made from.
    #[error(
        "the remeshed surface is {distance_m:.6} m from the given one (allowed {max_distance_m}) and \
         its volume changes by {volume_change:.4} (allowed {max_volume_change}), relative: take a \
         shorter edge length"
    )]
    RemeshStrays {
        /// Largest sampled distance either way, m.
        distance_m: f64,
        /// Distance allowed, m.
        max_distance_m: f64,
        /// Relative change of the volume; 0 for an open surface.
        volume_change: f64,
        /// Change allowed.
        max_volume_change: f64,
    },
}

fn cubic_centimetres(volumes_m3: &[f64]) -> String {
    let texts: Vec<String> = volumes_m3.iter().map(|v| format!("{:.3}", v * 1e6)).collect();
    texts.join(", ")
}
