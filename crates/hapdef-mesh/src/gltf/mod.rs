//! glTF 2.0 and GLB files: a bounded reader and a writer.
//!
//! Sections cited in this module are those of the Khronos glTF 2.0 specification, version 2.0.1.

mod accessor;
mod assembly;
mod buffers;
mod container;
mod document;
mod fault;
mod params;
mod primitive;
mod read;
mod scene;
mod source;
mod view;
mod write;

pub use fault::GltfFault;
pub use params::{GltfInfo, GltfParams, GltfPart};
pub(crate) use read::read_bounded;
pub use read::{GltfSurface, read_gltf};
pub use write::{VertexField, write_glb};
