//! The order in which unknowns are eliminated.
//!
//! The graph of unknown three-vectors is ordered, not the graph of equations: it is nine times
//! smaller, and the three equations of a motion stay together. Approximate minimum degree (Amestoy, Davis and
//! Duff, SIAM J. Matrix Anal. Appl. 17, 1996), as faer carries it.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;

use crate::SimError;

/// A symmetric graph on places: the neighbours of each, ascending, itself left out.
pub(crate) struct NodeGraph {
    pub(crate) row_ptr: Vec<usize>,
    pub(crate) neighbours: Vec<u32>,
}

const NONE: u32 = u32::MAX;

impl NodeGraph {
    /// The graph of unknowns that share a clique: the unknowns of an element.
    pub(crate) fn build(n_places: usize, cliques: &Cliques) -> Self {
        let (first, cliques_of) = cliques.at_places(n_places);
        let mut mark = vec![NONE; n_places];
        let mut graph = Self {
            row_ptr: Vec::with_capacity(n_places + 1),
            neighbours: Vec::new(),
        };
        graph.row_ptr.push(0);
        for place in 0..n_places {
            let start = graph.neighbours.len();
            mark[place] = place as u32;
            for &clique in &cliques_of[first[place]..first[place + 1]] {
                for &other in cliques.of(clique as usize) {
                    if mark[other as usize] != place as u32 {
                        mark[other as usize] = place as u32;
                        graph.neighbours.push(other);
                    }
                }
            }
            graph.neighbours[start..].sort_unstable();
            graph.row_ptr.push(graph.neighbours.len());
        }
        graph
    }

    /// The same graph with `sequence[new place] = old place`.
    pub(crate) fn reordered(&self, sequence: &[u32]) -> Self {
        let mut new_place = vec![0; sequence.len()];
        for (new, &old) in sequence.iter().enumerate() {
            new_place[old as usize] = new as u32;
        }
        let mut graph = Self {
            row_ptr: vec![0],
            neighbours: Vec::with_capacity(self.neighbours.len()),
        };
        for &old in sequence {
            let start = graph.neighbours.len();
            let others = self.of(old as usize).iter();
            graph
                .neighbours
                .extend(others.map(|&other| new_place[other as usize]));
            graph.neighbours[start..].sort_unstable();
            graph.row_ptr.push(graph.neighbours.len());
        }
        graph
    }

    pub(crate) fn of(&self, place: usize) -> &[u32] {
        &self.neighbours[self.row_ptr[place]..self.row_ptr[place + 1]]
    }
}

/// Sets of unknowns that are all coupled with each other, as offsets and a flat list of places.
#[derive(Default)]
pub(crate) struct Cliques {
    end: Vec<usize>,
    places: Vec<u32>,
}

impl Cliques {
    pub(crate) fn push(&mut self, places: impl Iterator<Item = usize>) {
        self.places.extend(places.map(|place| place as u32));
        self.end.push(self.places.len());
    }

    fn of(&self, clique: usize) -> &[u32] {
        let begin = clique.checked_sub(1).map_or(0, |before| self.end[before]);
        &self.places[begin..self.end[clique]]
    }

    /// The cliques at each place, as offsets and a flat list.
    fn at_places(&self, n_places: usize) -> (Vec<usize>, Vec<u32>) {
        let mut first = vec![0; n_places + 1];
        for &place in &self.places {
            first[place as usize + 1] += 1;
        }
        for i in 1..first.len() {
            first[i] += first[i - 1];
        }
        let mut next = first.clone();
        let mut cliques = vec![0; self.places.len()];
        for clique in 0..self.end.len() {
            for &place in self.of(clique) {
                cliques[next[place as usize]] = clique as u32;
                next[place as usize] += 1;
            }
        }
        (first, cliques)
    }
}

/// The sequence in which places are eliminated: `sequence[new place] = old place`.
pub(crate) fn minimum_degree(graph: &NodeGraph) -> Result<Vec<u32>, SimError> {
    let n = graph.row_ptr.len() - 1;
    let (col_ptr, row_idx) = upper_pattern(graph);
    let pattern = SymbolicSparseColMatRef::new_checked(n, n, &col_ptr, None, &row_idx);
    let too_large = |reason: String| SimError::TooLarge {
        n_equations: 3 * n,
        reason,
    };
    let scratch = amd::order_scratch::<u32>(n, row_idx.len());
    let mut memory = MemBuffer::try_new(scratch)
        .map_err(|_| too_large("no memory for the ordering".to_owned()))?;
    let (mut forward, mut inverse) = (vec![0; n], vec![0; n]);
    let stack = MemStack::new(&mut memory);
    amd::order(
        &mut forward,
        &mut inverse,
        pattern,
        amd::Control::default(),
        stack,
    )
    .map_err(|error| too_large(format!("{error:?}")))?;
    Ok(forward)
}

fn upper_pattern(graph: &NodeGraph) -> (Vec<u32>, Vec<u32>) {
    let mut col_ptr = vec![0];
    let mut row_idx = Vec::with_capacity(graph.neighbours.len() / 2);
    for place in 0..graph.row_ptr.len() - 1 {
        row_idx.extend(
            graph
                .of(place)
                .iter()
                .take_while(|&&other| (other as usize) < place),
        );
        col_ptr.push(row_idx.len() as u32);
    }
    (col_ptr, row_idx)
}
