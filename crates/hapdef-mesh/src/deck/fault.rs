//! What can be wrong with a deck.

use crate::SolidFault;

/// Why a deck was refused. Lines count from 1 in the decompressed text.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DeckFault {
    /// A file name that says nothing about the format.
    #[error(
        "the name ends in `{found}`; expected .inp (Abaqus, CalculiX) or .dat, .cdb (ANSYS), \
         each also with .gz"
    )]
    FileName {
        /// The ending found.
        found: String,
    },
    /// A deck longer than allowed.
    #[error(
        "the deck is longer than the {max_bytes} bytes allowed (decompressed); raise the limit if that is meant"
    )]
    TooLong {
        /// The limit.
        max_bytes: u64,
    },
    /// The text does not go on as the format asks.
    #[error("line {line}: expected {expected}, found {found}")]
    Unexpected {
        /// Where.
        line: usize,
        /// What the format asks for.
        expected: String,
        /// What is there.
        found: String,
    },
    /// The deck ends too early.
    #[error("line {line}: the deck ends where {expected} is expected, {found}: it is cut short")]
    Truncated {
        /// The last line.
        line: usize,
        /// What should follow.
        expected: String,
        /// How far it got.
        found: String,
    },
    /// A command that changes the model and that this reader does not know.
    #[error("line {line}: `{command}` is not supported: {why}")]
    Unsupported {
        /// Where.
        line: usize,
        /// The command as written.
        command: String,
        /// Why it can't be skipped, or what to do.
        why: &'static str,
    },
    /// A name or number that nothing in the deck defines.
    #[error("line {line}: {kind} `{name}` is not defined before it is used")]
    Undefined {
        /// Where.
        line: usize,
        /// `node`, `element`, `node set`, `table`.
        kind: &'static str,
        /// The name or number.
        name: String,
    },
    /// A number or name that is defined twice.
    #[error("line {line}: {kind} `{name}` is already defined")]
    Duplicate {
        /// Where.
        line: usize,
        /// What is defined.
        kind: &'static str,
        /// The name or number.
        name: String,
    },
    /// A node held in some directions only.
    #[error(
        "{n_nodes} nodes, the first with number {first_node}, are held in {held} only; \
         hold all of x, y and z, or none"
    )]
    PartialSupport {
        /// How many nodes.
        n_nodes: usize,
        /// The first of them, deck number.
        first_node: u32,
        /// The directions it is held in, such as `x, z`.
        held: String,
    },
    /// A surface load on something that is not a boundary face.
    #[error("line {line}: corner nodes {corners:?} are no boundary face of the solid")]
    NotABoundaryFace {
        /// Where the load's face is defined.
        line: usize,
        /// The corner nodes, deck numbers.
        corners: [u32; 3],
    },
    /// A force on a node that no element uses.
    #[error("line {line}: node {node} carries a force but belongs to no element")]
    ForceOnUnusedNode {
        /// Where the force is given.
        line: usize,
        /// The node, deck number.
        node: u32,
    },
    /// Elements that use different materials.
    #[error("the deck's elements use {found} materials; one for all is supported")]
    SeveralMaterials {
        /// How many.
        found: usize,
    },
    /// A deck without mesh, or one whose mesh is not usable.
    #[error("{fault}{}", first_label(*element_label))]
    Mesh {
        /// What is wrong, with node and element numbers counted from 0 in deck order.
        fault: SolidFault,
        /// The deck's number of the element concerned, if one is.
        element_label: Option<u32>,
    },
}

fn first_label(element: Option<u32>) -> String {
    element.map_or_else(String::new, |label| format!(" (element number {label} in the deck)"))
}
