//! What can go wrong in statics.

use crate::{FloatingBody, ShellElementProblem};

/// Why an elastic model, a load or a gauge could not be built, or a system not be solved.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum SimError {
    #[error("{property} is {value}; it must be {expected}")]
    Material { property: &'static str, value: f64, expected: &'static str },
    #[error(
        "element {element} (0-based) has the stiffness scale {value}; it must be finite and positive"
    )]
    StiffnessScale { element: usize, value: f64 },
    #[error("{what} has {found} entries; expected {expected}")]
    Length { what: &'static str, expected: usize, found: usize },
    #[error("{what} names node {node}, but the mesh has {n_nodes} nodes (0-based)")]
    NodeOutOfRange { what: &'static str, node: usize, n_nodes: usize },
    #[error("{what} names element {element}, but the mesh has {n_elements} elements (0-based)")]
    ElementOutOfRange { what: &'static str, element: usize, n_elements: usize },
    #[error(
        "node {node} (0-based) of rigid body {rigid_body} is also clamped or in a symmetry plane: \
         a rigid body moves freely; clamp all of its nodes instead, or leave the held ones out"
    )]
    RigidBodyHeld { rigid_body: usize, node: usize },
    #[error(
        "rigid bodies {} and {} share node {node} (0-based): join them into one", rigid_bodies[0], rigid_bodies[1]
    )]
    RigidBodiesShareNode { rigid_bodies: [usize; 2], node: usize },
    #[error(
        "rigid body {rigid_body} has {n_nodes} different nodes, all on a line; it needs three that \
         are not"
    )]
    RigidBodyTooSmall { rigid_body: usize, n_nodes: usize },
    #[error(
        "a flange of {n_nodes} nodes takes no wrench: it needs three that are not on a line; name a \
         larger face or a finer mesh"
    )]
    Flange { n_nodes: usize },
    #[error("{what} is about a rotation, which nodes of a solid do not have; use a pair of forces")]
    NoRotations { what: &'static str },
    #[error(
        "the strain energy of a shell or of a limb with rigid bodies does not follow from \
         displacements alone; take half the work of the load"
    )]
    NeedsRotations,
    #[error(
        "element {element} (0-based) has det J = {det_j_m3:.3e} m³ at parent coordinates \
         ({}, {}, {}): it is inside out or flat; move its mid-side nodes or remesh", parent[0], parent[1], parent[2]
    )]
    ElementInverted { element: usize, parent: [f64; 3], det_j_m3: f64 },
    #[error("shell element {element} (0-based): {problem}")]
    ShellElement { element: usize, problem: ShellElementProblem },
    #[error("node {node} (0-based) belongs to no triangle of the shell; remove it")]
    UnusedNode { node: usize },
    #[error(
        "the supports leave {} of {n_bodies} connected bodies free to move: {}",
        bodies.len(),
        bodies.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
    )]
    FreeRigidModes { n_bodies: usize, bodies: Vec<FloatingBody> },
    #[error("all {n_nodes} nodes are clamped; at least one must be free")]
    AllClamped { n_nodes: usize },
    #[error(
        "the stiffness matrix is not positive definite at node {node}, direction {direction} \
         (0-based): a mechanism, a degenerate element or a modulus contrast beyond f64"
    )]
    NotPositiveDefinite { node: usize, direction: usize },
    #[error("the factor of {n_equations} equations is too large: {reason}")]
    TooLarge { n_equations: usize, reason: String },
    #[error(
        "{n_loads} loads at {n_wanted} nodes need {needed_bytes} bytes; allowed are {allowed_bytes}"
    )]
    OverBudget { n_loads: usize, n_wanted: usize, needed_bytes: usize, allowed_bytes: usize },
    #[error("element {element} (0-based) does not fit the mesh that the analysis was made for")]
    OtherMesh { element: usize },
    #[error("cannot start {n_threads} worker threads: {source}")]
    Threads { n_threads: usize, source: rayon::ThreadPoolBuildError },
    #[error("load {load} has the value ({}, {}, {}), which is not finite", value[0], value[1], value[2])]
    LoadNotFinite { load: usize, value: [f64; 3] },
    #[error("{what} is ({}, {}, {}); it must be finite and not zero", value[0], value[1], value[2])]
    Direction { what: &'static str, value: [f64; 3] },
    #[error("{what} is {value}; it must be {expected}")]
    Parameter { what: &'static str, value: f64, expected: &'static str },
    #[error(
        "the tip at ({:.6}, {:.6}, {:.6}) m with radius {tip_radius_m} m does not reach the skin; \
         the nearest skin node is {nearest_node_m:.6} m away", centre_m[0], centre_m[1], centre_m[2]
    )]
    PatchOffSkin { centre_m: [f64; 3], tip_radius_m: f64, nearest_node_m: f64 },
    #[error(
        "a face names element {element} (0-based), which does not hold its corner nodes {corners:?}"
    )]
    FaceOfOtherElement { element: usize, corners: [usize; 3] },
    #[error(
        "the gauge at ({:.6}, {:.6}, {:.6}) m is {distance_m:.6} m from the nearest wall face; allowed are {max_distance_m} m",
        centre_m[0], centre_m[1], centre_m[2]
    )]
    GaugeOffWall { centre_m: [f64; 3], distance_m: f64, max_distance_m: f64 },
    #[error(
        "{n_lost} of the {n_samples} sample points of the gauge at ({:.6}, {:.6}, {:.6}) m miss its wall \
         (share {lost_share:.3}, allowed {max_lost_share}): move the gauge away from holes and rims",
        centre_m[0], centre_m[1], centre_m[2]
    )]
    GaugeOverhang {
        centre_m: [f64; 3],
        n_lost: usize,
        n_samples: usize,
        lost_share: f64,
        max_lost_share: f64,
    },
    #[error(
        "load {load} is solved to a backward error of {backward_error:.2e} after \
         {n_refinements} refinement steps; allowed is {limit:e}"
    )]
    Residual { load: usize, backward_error: f64, n_refinements: usize, limit: f64 },
    #[error(
        "the stiffness matrix is singular: around node {node} (0-based) the body can move almost \
         without resistance in direction {direction} (scaled pivot {pivot:.2e}): hold it, or tie \
         its hinged parts"
    )]
    Singular { node: usize, direction: usize, pivot: f64 },
    #[error(
        "load {load} after {n_iterations} iterations: backward error {backward_error:.2e} (allowed \
         {limit:e}), estimated relative error in energy {energy_error:.2e} (allowed {energy_limit:e}); \
         give the direct factor more memory, or remesh slivers"
    )]
    NotConverged {
        load: usize,
        n_iterations: usize,
        backward_error: f64,
        limit: f64,
        energy_error: f64,
        energy_limit: f64,
    },
    #[error(
        "the stiffness has a condition number of about {condition:e}: with a backward error of \
         {backward_error:.2e} displacements may be off by {bound:e}, allowed is {limit:e}; tie parts \
         that are far stiffer than the rest as rigid bodies, and remesh slivers"
    )]
    IllConditioned { condition: f64, backward_error: f64, bound: f64, limit: f64 },
}
