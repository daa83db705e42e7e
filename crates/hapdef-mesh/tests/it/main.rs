//! The integration tests of hapdef-mesh: one program.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "what can't be prepared fails its test; what is skipped or measured is printed"
)]

mod authors_limb;
mod deck_ansys;
mod deck_field;
mod deck_inp;
mod deck_msh;
mod deck_scene;
mod deck_write;
mod examples;
mod extrude;
mod gltf_buffers;
mod gltf_common;
mod gltf_corpus;
mod gltf_fuzz;
mod gltf_hostile;
mod gltf_limbs;
mod gltf_scene;
mod gltf_write;
mod remesh;
mod self_intersection;
mod shell_limbs;
mod shell_solid;
mod shin;
mod solid_common;
mod solid_mesh;
mod surface_common;
mod surface_files;
mod wall;
#[cfg(feature = "wrap")]
mod wrap;
