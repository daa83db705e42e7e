//! Solid decks: a mesh with its sets, material, supports and loads, as a finite-element program
//! reads them, and volume meshes of gmsh.

mod ansys;
mod ansys_blocks;
mod ansys_loads;
mod ansys_mesh;
mod ansys_parameters;
mod ansys_state;
mod builder;
mod displacements;
mod fault;
mod include;
mod inp;
mod inp_elements;
mod inp_keyword;
mod inp_sets;
mod msh;
mod msh_source;
mod source;
mod write;

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::Vector3;

pub use displacements::{LabelledDisplacements, largest_difference, read_displacements};
pub use fault::DeckFault;
pub use include::deck_includes;
pub use write::write_inp;

use crate::{FeNodeId, LengthUnit, MeshError, Tet10Mesh};

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
    /// The unit of length that the deck itself states; its numbers were brought to SI by it.
    pub unit: Option<LengthUnit>,
    /// What was passed over or made while reading, a sentence each.
    pub notes: Vec<String>,
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

impl DeckMaterial {
    /// From MPa and t/mm³, which go with millimetres and newtons, to Pa and kg/m³.
    pub fn from_millimetres(&mut self) {
        self.youngs_modulus_pa *= 1e6;
        self.density_kg_m3 = self.density_kg_m3.map(|density| density * 1e12);
    }
}

/// A force per real (curved) area on a boundary face, constant in size and direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaceTraction {
    /// The face's nodes, as in [`crate::Tri6Face`].
    pub nodes: [FeNodeId; 6],
    /// Force per real area, the same vector all over the face, Pa.
    pub traction_pa: Vector3<f64>,
}

/// How much of a deck is wanted. What is wanted and can't be read is refused; the rest is passed
/// over and named in [`SolidDeck::notes`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DeckReading {
    /// The whole model with its loads: whatever would change a linear-elastic statics model counts.
    #[default]
    Whole,
    /// Mesh, sets and supports, for a scene that is mounted where the deck is.
    Supports,
    /// Mesh and sets, for a scene with a mount of its own.
    Mesh,
}

/// Limits of [`read_deck_with`], and what is wanted of the deck.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DeckParams {
    /// A deck that is longer once decompressed, included files and all, is refused, bytes.
    pub max_bytes: u64,
    /// What is wanted of it.
    pub reading: DeckReading,
}

impl Default for DeckParams {
    /// 1 GiB, a deck of several million nodes, and the whole model.
    fn default() -> Self {
        Self { max_bytes: 1 << 30, reading: DeckReading::Whole }
    }
}

/// Reads a deck: Abaqus or CalculiX (`.inp`), ANSYS (`.dat`, `.cdb`), gmsh (`.msh`), each plain or
/// with `.gz`.
///
/// Units are taken as they stand in an `.inp` or `.msh`, and as `/units` says in an ANSYS deck. What
/// would change a linear-elastic statics model and is not supported is refused, never skipped.
///
/// # Errors
/// As [`read_deck_with`].
pub fn read_deck(path: &Path) -> Result<SolidDeck, MeshError> {
    read_deck_with(path, &DeckParams::default())
}

/// [`read_deck`] with limits, and for what is wanted of the deck only.
///
/// # Errors
/// [`MeshError::Io`] if the file can't be read; [`MeshError::Deck`] naming the line, what was
/// expected and what was found.
pub fn read_deck_with(path: &Path, params: &DeckParams) -> Result<SolidDeck, MeshError> {
    let at_path = |fault| MeshError::Deck { path: path.to_owned(), fault };
    let kind = source::kind(path).map_err(at_path)?;
    let bytes = source::read(path, params.max_bytes)?;
    let deck = builder::DeckBuilder::new(params.reading);
    let builder = match kind {
        source::DeckKind::Inp => {
            let mut includes =
                include::Includes::beside(path, params.max_bytes - bytes.len() as u64);
            inp::read(&source::text(&bytes), deck, &mut includes)
        }
        source::DeckKind::Ansys => ansys::read(&source::text(&bytes), deck),
        source::DeckKind::Msh => msh::read(&bytes, deck),
    };
    builder.and_then(builder::DeckBuilder::finish).map_err(at_path)
}
