//! The ten-node tetrahedron and its material: stiffness, strain, stress, mass.

pub(crate) mod element_set;
pub(crate) mod mass;
pub(crate) mod material;
pub(crate) mod parts;
pub(crate) mod patch_stress;
pub(crate) mod quadrature;
pub(crate) mod rounding;
pub(crate) mod stress;
pub(crate) mod tet10;

pub use mass::{MassProperties, element_mass_kg};
pub use material::{IsotropicMaterial, MaterialRegion};
pub use patch_stress::patch_stress;
pub use quadrature::tet_rule;
pub use stress::{nodal_stress, stress};
pub use tet10::{ElementMatrix, InvertedPoint, space_gradients, stiffness, strain};
