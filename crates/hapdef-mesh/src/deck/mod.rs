//! Solid decks: a mesh with its sets, material, supports and loads, as a finite-element program
//! reads them.

mod ansys;
mod ansys_blocks;
mod ansys_loads;
mod ansys_mesh;
mod ansys_parameters;
mod ansys_state;
mod builder;
mod fault;
mod inp;
mod inp_keyword;
mod inp_sets;
mod source;
mod write;

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::Vector3;

pub use fault::DeckFault;
pub use write::write_inp;

use crate::{FeNodeId, MeshError, Tet10Mesh};

/// A linear-elastic statics problem on a solid mesh, as read from a deck. SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidDeck {
    /// The mesh; ids count nodes and elements in deck order.
    pub mesh: Tet10Mesh,
    /// The deck's own node numbers `[n_fe_nodes]`.
    pub node_labels: Vec<u32>,
    /// The deck's own element numbers `[n_elements]`.
    pub element_labels: Vec<u32>,
    /// Named node sets, names in upper case, nodes ascending.
    pub node_sets: BTreeMap<String, Vec<FeNodeId>>,
    /// The material, if the deck states one.
    pub material: Option<DeckMaterial>,
    /// Nodes whose three displacements are held at zero, ascending.
    pub fixed_nodes: Vec<FeNodeId>,
    /// Point forces, N, ascending by node, one entry per node.
    pub nodal_forces: Vec<(FeNodeId, Vector3<f64>)>,
    /// Tractions on boundary faces, in deck order. Pressures are not among them: a pressure follows
    /// the face's normal, so the reader turns it into its consistent nodal forces.
    pub face_tractions: Vec<FaceTraction>,
    /// Node numbers the deck defines but no element uses; they are not part of the mesh, and
    /// supports on them have no effect.
    pub unused_node_labels: Vec<u32>,
}

/// An isotropic linear-elastic material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeckMaterial {
    /// Young's modulus E, Pa.
    pub youngs_modulus_pa: f64,
    /// Poisson's ratio ν.
    pub poissons_ratio: f64,
    /// Mass density ρ, kg/m³, if stated.
    pub density_kg_m3: Option<f64>,
}

/// A force per real (curved) area on a boundary face, constant in size and direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaceTraction {
    /// The face's nodes, as in [`crate::Tri6Face`].
    pub nodes: [FeNodeId; 6],
    /// Force per real area, the same vector all over the face, Pa.
    pub traction_pa: Vector3<f64>,
}

/// Limits of [`read_deck_with`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DeckParams {
    /// A deck that is longer once decompressed is refused, bytes.
    pub max_bytes: u64,
}

impl Default for DeckParams {
    /// 1 GiB: a deck of several million nodes.
    fn default() -> Self {
        Self { max_bytes: 1 << 30 }
    }
}

/// Reads a deck: Abaqus or CalculiX (`.inp`), ANSYS (`.dat`, `.cdb`), each plain or with `.gz`.
///
/// Units are taken as they stand in an `.inp` and must be MKS in an ANSYS deck. What would change
/// a linear-elastic statics model and is not supported is refused, never skipped.
///
/// # Errors
/// As [`read_deck_with`].
pub fn read_deck(path: &Path) -> Result<SolidDeck, MeshError> {
    read_deck_with(path, &DeckParams::default())
}

/// [`read_deck`] with limits.
///
/// # Errors
/// [`MeshError::Io`] if the file can't be read; [`MeshError::Deck`] naming the line, what was
/// expected and what was found.
pub fn read_deck_with(path: &Path, params: &DeckParams) -> Result<SolidDeck, MeshError> {
    let at_path = |fault| MeshError::Deck { path: path.to_owned(), fault };
    let kind = source::kind(path).map_err(at_path)?;
    let text = source::read(path, params)?;
    let builder = match kind {
        source::DeckKind::Inp => inp::read(&text),
        source::DeckKind::Ansys => ansys::read(&text),
    };
    builder.and_then(builder::DeckBuilder::finish).map_err(at_path)
}
