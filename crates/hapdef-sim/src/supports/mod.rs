//! What holds a limb and what ties its parts together: the boundary conditions, whether they leave
//! a rigid motion free, and the unknowns that they leave.

pub(crate) mod conditions;
mod floating_body;
mod null_space;
pub(crate) mod rigid_modes;
pub(crate) mod unknowns;

pub use conditions::{
    Foundation, FoundationFaces, HeldMotion, Hold, RigidBody, Supports, SymmetryPlane,
};
pub use floating_body::{FloatingBody, RigidMotion};
