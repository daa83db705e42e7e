//! Which nodes are neighbours of which.

use crate::error::KMaxError;

/// The nearest neighbours of every node.
///
/// Nodes as far away as the k-th neighbour (to one part in 10⁹) are all taken in, so that the
/// neighbourhoods do not depend on the order of the points, not even on a regular grid.
#[derive(Debug, Clone)]
pub struct KMaxGraph {
    outgoing: Adjacency,
    incoming: Adjacency,
}

impl KMaxGraph {
    /// A graph of known neighbours: for each node those that it is compared with, as
    /// [`KMaxGraph::neighbours`] lists them.
    ///
    /// Fails on a neighbour that is no node.
    pub fn from_neighbours<Row>(rows: impl IntoIterator<Item = Row>) -> Result<Self, KMaxError>
    where
        Row: IntoIterator<Item = u32>,
    {
        let mut outgoing = Adjacency::with_capacity(0, 0);
        for row in rows {
            outgoing.push_row(row.into_iter());
        }
        let n_nodes = outgoing.n_rows();
        let stray = outgoing.targets.iter().find(|&&j| j as usize >= n_nodes);
        match stray {
            Some(&neighbour) => Err(KMaxError::NeighbourOutOfRange { neighbour, n_nodes }),
            None => Ok(Self::of(outgoing)),
        }
    }

    /// Number of nodes.
    pub fn n_nodes(&self) -> usize {
        self.outgoing.n_rows()
    }

    /// The nodes that `node` is compared with, ascending by index; empty for a node out of range.
    pub fn neighbours(&self, node: usize) -> impl Iterator<Item = usize> + '_ {
        self.outgoing.row(node).iter().map(|&j| j as usize)
    }

    /// The nodes that are compared with `node`, ascending by index.
    pub(crate) fn compared_with(&self, node: usize) -> impl Iterator<Item = usize> + '_ {
        self.incoming.row(node).iter().map(|&j| j as usize)
    }

    /// The graph of the nodes that each is compared with.
    pub(crate) fn of(outgoing: Adjacency) -> Self {
        let incoming = outgoing.transposed();
        Self { outgoing, incoming }
    }
}

/// Lists of node indices, one per node, in one allocation.
#[derive(Debug, Clone)]
pub(crate) struct Adjacency {
    starts: Vec<usize>,
    targets: Vec<u32>,
}

impl Adjacency {
    pub(crate) fn with_capacity(n_rows: usize, n_per_row: usize) -> Self {
        let mut starts = Vec::with_capacity(n_rows + 1);
        starts.push(0);
        Self { starts, targets: Vec::with_capacity(n_rows * n_per_row) }
    }

    pub(crate) fn push_row(&mut self, row: impl Iterator<Item = u32>) {
        let start = self.targets.len();
        self.targets.extend(row);
        self.targets[start..].sort_unstable();
        self.starts.push(self.targets.len());
    }

    fn n_rows(&self) -> usize {
        self.starts.len() - 1
    }

    fn row(&self, row: usize) -> &[u32] {
        match (self.starts.get(row), self.starts.get(row + 1)) {
            (Some(&start), Some(&end)) => &self.targets[start..end],
            _ => &[],
        }
    }

    fn transposed(&self) -> Self {
        let mut rows: Vec<Vec<u32>> = vec![Vec::new(); self.n_rows()];
        for source in 0..self.n_rows() {
            for &target in self.row(source) {
                rows[target as usize].push(source as u32);
            }
        }
        let mut result = Self::with_capacity(rows.len(), self.targets.len() / rows.len().max(1));
        for row in rows {
            result.push_row(row.into_iter());
        }
        result
    }
}
