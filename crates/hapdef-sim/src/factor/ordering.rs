//! The order in which unknowns are eliminated.
//!
//! The graph of unknown three-vectors is ordered, not the graph of equations: it is nine times
//! smaller, and the three equations of a motion stay together.

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
        let mut graph = Self { row_ptr: Vec::with_capacity(n_places + 1), neighbours: Vec::new() };
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
        let mut graph =
            Self { row_ptr: vec![0], neighbours: Vec::with_capacity(self.neighbours.len()) };
        for &old in sequence {
            let start = graph.neighbours.len();
            let others = self.of(old as usize).iter();
            graph.neighbours.extend(others.map(|&other| new_place[other as usize]));
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
