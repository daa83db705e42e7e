//! What can go wrong in statics.

use crate::{FloatingBody, ShellElementProblem};

/// Why an elastic model, a load or a gauge could not be built, or a system not be solved.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SimError {
    /// A material property outside the theory's range.
    #[error("{property} is {value}; it must be {expected}")]
    Material {
        /// Which property.
        property: &'static str,
        /// The value found.
        value: f64,
        /// The allowed range in words.
        expected: &'static str,
    },
    /// An element's modulus factor that is not usable.
    #[error(
        "element {element} (0-based) has the stiffness scale {value}; it must be finite and positive"
    )]
    StiffnessScale {
        /// The element, counted from 0.
        element: usize,
        /// The factor found.
        value: f64,
    },
    /// An array whose length does not fit the mesh.
    #[error("{what} has {found} entries; expected {expected}")]
    Length {
        /// Which array.
        what: &'static str,
        /// Entries needed.
        expected: usize,
        /// Entries found.
        found: usize,
    },
    /// A node index beyond the mesh.
    #[error("{what} names node {node}, but the mesh has {n_nodes} nodes (0-based)")]
    NodeOutOfRange {
        /// What names the node.
        what: &'static str,
        /// The index found.
        node: usize,
        /// Nodes in the mesh.
        n_nodes: usize,
    },
    /// An element index beyond the mesh.
    #[error("{what} names element {element}, but the mesh has {n_elements} elements (0-based)")]
    ElementOutOfRange {
        /// What names the element.
        what: &'static str,
        /// The index found.
        element: usize,
        /// Elements in the mesh.
        n_elements: usize,
    },
    /// A rigid body with a node that is held as well.
    #[error(
        "node {node} (0-based) of rigid body {rigid_body} is also clamped or in a symmetry plane: \
         a rigid body moves freely; clamp all of its nodes instead, or leave the held ones out"
    )]
    RigidBodyHeld {
        /// The rigid body, counted from 0.
        rigid_body: usize,
        /// The node.
        node: usize,
    },
    /// Two rigid bodies that share a node.
    #[error(
        "rigid bodies {} and {} share node {node} (0-based): join them into one", rigid_bodies[0], rigid_bodies[1]
    )]
    RigidBodiesShareNode {
        /// The rigid bodies, counted from 0.
        rigid_bodies: [usize; 2],
        /// The node.
        node: usize,
    },
    /// A rigid body that could spin without moving a node.
    #[error(
        "rigid body {rigid_body} has {n_nodes} different nodes, all on a line; it needs three that \
         are not"
    )]
    RigidBodyTooSmall {
        /// The rigid body, counted from 0.
        rigid_body: usize,
        /// Its different nodes.
        n_nodes: usize,
    },
    /// A moment or a held rotation where nodes have no rotation.
    #[error("{what} is about a rotation, which nodes of a solid do not have; use a pair of forces")]
    NoRotations {
        /// What is about a rotation.
        what: &'static str,
    },
    /// An energy that displacements alone do not fix.
    #[error(
        "the strain energy of a shell or of a limb with rigid bodies does not follow from \
         displacements alone; take half the work of the load"
    )]
    NeedsRotations,
    /// An element that is turned inside out at a Gauss point, seen by its Jacobian.
    #[error(
        "element {element} (0-based) has det J = {det_j_m3:.3e} m³ at parent coordinates \
         ({}, {}, {}): it is inside out or flat; move its mid-side nodes or remesh", parent[0], parent[1], parent[2]
    )]
    ElementInverted {
        /// The element, counted from 0.
        element: usize,
        /// Parent coordinates (ξ, η, ζ) of the Gauss point.
        parent: [f64; 3],
        /// The Jacobian determinant there, m³.
        det_j_m3: f64,
    },
    /// A shell triangle that is not usable.
    #[error("shell element {element} (0-based): {problem}")]
    ShellElement {
        /// The element, counted from 0.
        element: usize,
        /// What is wrong with it.
        problem: ShellElementProblem,
    },
    /// A node of a shell that no triangle uses.
    #[error("node {node} (0-based) belongs to no triangle of the shell; remove it")]
    UnusedNode {
        /// The node.
        node: usize,
    },
    /// Parts that can move without deforming, because too few or badly placed nodes are clamped.
    #[error(
        "the supports leave {} of {n_bodies} connected bodies free to move: {}",
        bodies.len(),
        bodies.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
    )]
    FreeRigidModes {
        /// Connected bodies in the mesh.
        n_bodies: usize,
        /// The bodies that can move, by ascending first element.
        bodies: Vec<FloatingBody>,
    },
    /// Every node is clamped, so that nothing is left to solve.
    #[error("all {n_nodes} nodes are clamped; at least one must be free")]
    AllClamped {
        /// Nodes in the mesh.
        n_nodes: usize,
    },
    /// The stiffness matrix has a pivot that is not positive.
    #[error(
        "the stiffness matrix is not positive definite at node {node}, direction {direction} \
         (0-based): a mechanism, a degenerate element or a modulus contrast beyond f64"
    )]
    NotPositiveDefinite {
        /// The node of the failing pivot.
        node: usize,
        /// Its direction, 0..3 for a displacement along x, y, z, 3..6 for a rotation about them.
        direction: usize,
    },
    /// The factor does not fit in memory or in 32-bit indices.
    #[error("the factor of {n_equations} equations is too large: {reason}")]
    TooLarge {
        /// Equations of the system.
        n_equations: usize,
        /// What ran out.
        reason: String,
    },
    /// Results that would not fit the memory the caller allows.
    #[error(
        "{n_loads} loads at {n_wanted} nodes need {needed_bytes} bytes; allowed are {allowed_bytes}"
    )]
    OverBudget {
        /// Load columns.
        n_loads: usize,
        /// Nodes at which displacement is wanted.
        n_wanted: usize,
        /// Bytes for results and workspace.
        needed_bytes: usize,
        /// Bytes allowed.
        allowed_bytes: usize,
    },
    /// A reused analysis met a mesh with another connectivity.
    #[error("element {element} (0-based) does not fit the mesh that the analysis was made for")]
    OtherMesh {
        /// The first element that differs, counted from 0.
        element: usize,
    },
    /// The worker threads could not be started.
    #[error("cannot start {n_threads} worker threads: {source}")]
    Threads {
        /// Threads asked for.
        n_threads: usize,
        /// The thread pool's answer.
        source: rayon::ThreadPoolBuildError,
    },
    /// A force or traction that is not finite.
    #[error("load {load} has the value ({}, {}, {}), which is not finite", value[0], value[1], value[2])]
    LoadNotFinite {
        /// Which entry of the load, counted from 0.
        load: usize,
        /// The value found.
        value: [f64; 3],
    },
    /// A direction without length.
    #[error("{what} is ({}, {}, {}); it must be finite and not zero", value[0], value[1], value[2])]
    Direction {
        /// Which direction.
        what: &'static str,
        /// The value found.
        value: [f64; 3],
    },
    /// A length or count that is not usable.
    #[error("{what} is {value}; it must be {expected}")]
    Parameter {
        /// Which parameter.
        what: &'static str,
        /// The value found.
        value: f64,
        /// The allowed range in words.
        expected: &'static str,
    },
    /// A patch load whose tip does not touch the skin.
    #[error(
        "the tip at ({:.6}, {:.6}, {:.6}) m with radius {tip_radius_m} m does not reach the skin; \
         the nearest skin node is {nearest_node_m:.6} m away", centre_m[0], centre_m[1], centre_m[2]
    )]
    PatchOffSkin {
        /// The tip's centre, m.
        centre_m: [f64; 3],
        /// The tip's radius, m.
        tip_radius_m: f64,
        /// Distance to the nearest skin node, m.
        nearest_node_m: f64,
    },
    /// A face whose nodes are not corners of the element it names.
    #[error(
        "a face names element {element} (0-based), which does not hold its corner nodes {corners:?}"
    )]
    FaceOfOtherElement {
        /// The element named.
        element: usize,
        /// The face's corner nodes.
        corners: [usize; 3],
    },
    /// A gauge too far from every wall face.
    #[error(
        "the gauge at ({:.6}, {:.6}, {:.6}) m is {distance_m:.6} m from the nearest wall face; allowed are {max_distance_m} m",
        centre_m[0], centre_m[1], centre_m[2]
    )]
    GaugeOffWall {
        /// The gauge's centre, m.
        centre_m: [f64; 3],
        /// Distance to the nearest wall face, m.
        distance_m: f64,
        /// The distance allowed, m.
        max_distance_m: f64,
    },
    /// A gauge whose footprint hangs over a hole or a rim.
    #[error(
        "{n_lost} of the {n_samples} sample points of the gauge at ({:.6}, {:.6}, {:.6}) m miss its wall \
         (share {lost_share:.3}, allowed {max_lost_share}): move the gauge away from holes and rims",
        centre_m[0], centre_m[1], centre_m[2]
    )]
    GaugeOverhang {
        /// The gauge's centre, m.
        centre_m: [f64; 3],
        /// Sample points that miss the wall.
        n_lost: usize,
        /// Sample points of the footprint.
        n_samples: usize,
        /// `n_lost / n_samples`.
        lost_share: f64,
        /// The share allowed.
        max_lost_share: f64,
    },
    /// A solution whose residual stays too large after refinement.
    #[error(
        "load {load} is solved to a backward error of {backward_error:.2e} after \
         {n_refinements} refinement steps; allowed is {limit:e}"
    )]
    Residual {
        /// The load column, counted from 0.
        load: usize,
        /// The backward error reached, see [`crate::SolveParams`].
        backward_error: f64,
        /// Refinement steps done.
        n_refinements: usize,
        /// The limit.
        limit: f64,
    },
    /// A stiffness matrix that is singular up to rounding, found on the coarsest level of multigrid.
    #[error(
        "the stiffness matrix is singular: around node {node} (0-based) the body can move almost \
         without resistance in direction {direction} (scaled pivot {pivot:.2e}): hold it, or tie \
         its hinged parts"
    )]
    Singular {
        /// A node of the part that moves.
        node: usize,
        /// The direction of the failing pivot, 0..3.
        direction: usize,
        /// The pivot of the coarsest matrix, scaled to a unit diagonal.
        pivot: f64,
    },
    /// An iteration that ended short of its promise.
    #[error(
        "load {load} after {n_iterations} iterations: backward error {backward_error:.2e} (allowed \
         {limit:e}), estimated relative error in energy {energy_error:.2e} (allowed {energy_limit:e}); \
         give the direct factor more memory, or remesh slivers"
    )]
    NotConverged {
        /// The load column, counted from 0.
        load: usize,
        /// Iterations done.
        n_iterations: usize,
        /// The backward error reached, see [`crate::SolveParams`].
        backward_error: f64,
        /// Its limit.
        limit: f64,
        /// The estimated relative error in energy reached, see [`crate::IterativeParams`].
        energy_error: f64,
        /// Its limit.
        energy_limit: f64,
    },
    /// A system so near to singular that its solution can't be trusted.
    #[error(
        "the stiffness has a condition number of about {condition:e}: with a backward error of \
         {backward_error:.2e} displacements may be off by {bound:e}, allowed is {limit:e}; tie parts \
         that are far stiffer than the rest as rigid bodies, and remesh slivers"
    )]
    IllConditioned {
        /// The estimated condition number of the Jacobi-scaled stiffness.
        condition: f64,
        /// The largest backward error of the solutions.
        backward_error: f64,
        /// The bound on the relative error.
        bound: f64,
        /// The bound allowed.
        limit: f64,
    },
}
