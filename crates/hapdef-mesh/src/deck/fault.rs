//! What can be wrong with a deck.

use crate::SolidFault;

/// Why a deck was refused. Lines count from 1 in the decompressed text.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum DeckFault {
    #[error(
        "the name ends in `{found}`; expected .inp (Abaqus, CalculiX), .dat, .cdb (ANSYS) or \
         .msh (gmsh), each also with .gz"
    )]
    FileName { found: String },
    #[error(
        "the deck is longer than the {max_bytes} bytes allowed (decompressed); raise the limit if that is meant"
    )]
    TooLong { max_bytes: u64 },
    #[error("line {line}: expected {expected}, found {found}")]
    Unexpected { line: usize, expected: String, found: String },
    #[error("line {line}: the deck ends where {expected} is expected, {found}: it is cut short")]
    Truncated { line: usize, expected: String, found: String },
    #[error("in the included file {file}: {fault}")]
    Included { file: String, fault: Box<DeckFault> },
    #[error(
        "no tetrahedron is left: the deck has {skipped} only; mesh the limb's volume with ten-node \
         tetrahedra"
    )]
    NoSolid { skipped: String },
    #[error("line {line}: `{command}` is not supported: {why}")]
    Unsupported { line: usize, command: String, why: &'static str },
    #[error("line {line}: {kind} `{name}` is not defined before it is used")]
    Undefined { line: usize, kind: &'static str, name: String },
    #[error("line {line}: {kind} `{name}` is already defined")]
    Duplicate { line: usize, kind: &'static str, name: String },
    #[error(
        "{n_nodes} nodes, the first with number {first_node}, are held in {held} only; \
         hold all of x, y and z, or none"
    )]
    PartialSupport { n_nodes: usize, first_node: u32, held: String },
    #[error("line {line}: corner nodes {corners:?} are no boundary face of the solid")]
    NotABoundaryFace { line: usize, corners: [u32; 3] },
    #[error("line {line}: node {node} carries a force but belongs to no element")]
    ForceOnUnusedNode { line: usize, node: u32 },
    #[error("the deck's elements use {found} materials; one for all is supported")]
    SeveralMaterials { found: usize },
    #[error("{fault}{}", first_label(*element_label))]
    Mesh { fault: SolidFault, element_label: Option<u32> },
}

fn first_label(element: Option<u32>) -> String {
    element.map_or_else(String::new, |label| format!(" (element number {label} in the deck)"))
}
