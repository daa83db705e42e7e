//! The order in which free nodes are eliminated.
//!
//! The graph of free nodes is ordered, not the graph of equations: it is nine times smaller, and
//! the three equations of a node stay together.

use hapdef_mesh::{FeNodeId, Tet10Mesh};

use crate::SimError;
use crate::dissection::{Ordering, sequence};

/// The places of free nodes in elimination order.
#[derive(Debug)]
pub(crate) struct NodeOrder {
    place_of_node: Vec<u32>,
    node_at: Vec<FeNodeId>,
    /// How it was found.
    pub(crate) ordering: Ordering,
}

/// A symmetric graph on places: the neighbours of each, ascending, itself left out.
pub(crate) struct NodeGraph {
    pub(crate) row_ptr: Vec<usize>,
    pub(crate) neighbours: Vec<u32>,
}

const CLAMPED: u32 = u32::MAX;

impl NodeOrder {
    /// Orders the free nodes of `mesh`; `clamped` is per node.
    pub(crate) fn build(mesh: &Tet10Mesh, clamped: &[bool]) -> Result<Self, SimError> {
        let natural = Self::from_sequence(clamped.len(), free_nodes(clamped));
        let graph = NodeGraph::build(mesh, &natural);
        let (sequence, ordering) = sequence(&graph)?;
        let node_at = sequence
            .iter()
            .map(|&place| natural.node_at[place as usize])
            .collect();
        Ok(Self {
            ordering,
            ..Self::from_sequence(clamped.len(), node_at)
        })
    }

    fn from_sequence(n_nodes: usize, node_at: Vec<FeNodeId>) -> Self {
        let mut place_of_node = vec![CLAMPED; n_nodes];
        for (place, node) in node_at.iter().enumerate() {
            place_of_node[node.index()] = place as u32;
        }
        Self {
            place_of_node,
            node_at,
            ordering: Ordering::MinimumDegree,
        }
    }

    /// The place of `node`, or nothing if it is clamped.
    pub(crate) fn place(&self, node: FeNodeId) -> Option<usize> {
        let place = self.place_of_node[node.index()];
        (place != CLAMPED).then_some(place as usize)
    }

    /// The node at each place.
    pub(crate) fn nodes(&self) -> &[FeNodeId] {
        &self.node_at
    }

    /// Nodes of the mesh, clamped ones included.
    pub(crate) fn n_fe_nodes(&self) -> usize {
        self.place_of_node.len()
    }
}

impl NodeGraph {
    /// The graph of nodes that share an element, on the places of `order`.
    pub(crate) fn build(mesh: &Tet10Mesh, order: &NodeOrder) -> Self {
        let n = order.nodes().len();
        let (first, elements_of) = elements_at(mesh, order);
        let mut mark = vec![CLAMPED; n];
        let mut graph = Self {
            row_ptr: Vec::with_capacity(n + 1),
            neighbours: Vec::new(),
        };
        graph.row_ptr.push(0);
        for place in 0..n {
            let start = graph.neighbours.len();
            mark[place] = place as u32;
            for &element in &elements_of[first[place]..first[place + 1]] {
                for node in mesh.elements()[element as usize] {
                    let Some(other) = order.place(node) else {
                        continue;
                    };
                    if mark[other] != place as u32 {
                        mark[other] = place as u32;
                        graph.neighbours.push(other as u32);
                    }
                }
            }
            graph.neighbours[start..].sort_unstable();
            graph.row_ptr.push(graph.neighbours.len());
        }
        graph
    }

    pub(crate) fn of(&self, place: usize) -> &[u32] {
        &self.neighbours[self.row_ptr[place]..self.row_ptr[place + 1]]
    }
}

fn free_nodes(clamped: &[bool]) -> Vec<FeNodeId> {
    (0..clamped.len())
        .filter(|&node| !clamped[node])
        .map(FeNodeId::from_index)
        .collect()
}

/// The elements at each place, as offsets and a flat list.
fn elements_at(mesh: &Tet10Mesh, order: &NodeOrder) -> (Vec<usize>, Vec<u32>) {
    let mut first = vec![0; order.nodes().len() + 1];
    let places = || {
        mesh.elements().iter().enumerate().flat_map(|(e, nodes)| {
            nodes
                .iter()
                .filter_map(move |&node| order.place(node).map(|place| (e, place)))
        })
    };
    for (_, place) in places() {
        first[place + 1] += 1;
    }
    for i in 1..first.len() {
        first[i] += first[i - 1];
    }
    let mut next = first.clone();
    let mut elements = vec![0; first[first.len() - 1]];
    for (element, place) in places() {
        elements[next[place]] = element as u32;
        next[place] += 1;
    }
    (first, elements)
}
