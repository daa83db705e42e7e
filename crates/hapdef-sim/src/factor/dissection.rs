//! The elimination sequence of a node graph, by the smaller of two fills.
//!
//! Approximate minimum degree (Amestoy, Davis and Duff, SIAM J. Matrix Anal. Appl. 17, 1996), as
//! faer carries it, wins on small and thin meshes; nested dissection (Karypis and Kumar, SIAM J.
//! Sci. Comput. 20, 1998), as METIS carries it, on large and thick ones. Both are tried, their fill
//! is counted on the node graph, and the winner's elimination tree is put in postorder.
#![expect(
    unsafe_code,
    reason = "METIS is a C library and its safe wrapper leaves the node ordering out"
)]

use std::ptr;
use std::sync::{Mutex, PoisonError};

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;
use faer::sparse::linalg::cholesky::simplicial;

use crate::SimError;
use crate::factor::ordering::NodeGraph;

/// How the elimination order was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ordering {
    /// Approximate minimum degree.
    MinimumDegree,
    /// Nested dissection by METIS.
    NestedDissection,
}

/// Below so many nodes minimum degree is not worth a second opinion.
const DISSECT_FROM: usize = 500;

/// The places of `graph` in elimination order, the elimination tree in postorder; call inside the
/// thread pool.
pub(crate) fn sequence(graph: &NodeGraph) -> Result<(Vec<u32>, Ordering), SimError> {
    let n = graph.row_ptr.len() - 1;
    let by_degree = || Tree::of(graph, minimum_degree(graph)?);
    let dissected = || {
        let sequence = (n >= DISSECT_FROM).then(|| nested_dissection(graph));
        let tree = sequence.flatten().map(|sequence| Tree::of(graph, sequence));
        tree.transpose()
    };
    let (by_degree, dissected) = rayon::join(by_degree, dissected);
    let by_degree = by_degree?;
    let (best, ordering) = match dissected? {
        Some(tree) if tree.fill() < by_degree.fill() => (tree, Ordering::NestedDissection),
        _ => (by_degree, Ordering::MinimumDegree),
    };
    Ok((best.postordered(), ordering))
}

/// An elimination sequence with its tree.
struct Tree {
    sequence: Vec<u32>,
    /// The parent of each step, or −1.
    parent: Vec<i32>,
    /// Entries of each column of L.
    counts: Vec<u32>,
}

impl Tree {
    fn of(graph: &NodeGraph, sequence: Vec<u32>) -> Result<Self, SimError> {
        let n = sequence.len();
        let (col_ptr, row_idx) = upper_pattern(graph, &sequence);
        let pattern = SymbolicSparseColMatRef::new_unsorted_checked(n, n, &col_ptr, None, &row_idx);
        let scratch = simplicial::prefactorize_symbolic_cholesky_scratch::<u32>(n, row_idx.len());
        let mut memory = MemBuffer::try_new(scratch)
            .map_err(|_| too_large(n, "no memory for the elimination tree"))?;
        let (mut parent, mut counts) = (vec![0; n], vec![0; n]);
        let stack = MemStack::new(&mut memory);
        simplicial::prefactorize_symbolic_cholesky(&mut parent, &mut counts, pattern, stack);
        Ok(Self { sequence, parent, counts })
    }

    fn fill(&self) -> u64 {
        self.counts.iter().map(|&count| u64::from(count)).sum()
    }

    /// The sequence with children before their parents and the heaviest child next to its parent,
    /// where the two may merge to one supernode.
    fn postordered(&self) -> Vec<u32> {
        let n = self.sequence.len();
        let mut steps: Vec<u32> = (0..n as u32).collect();
        steps.sort_by_key(|&step| (std::cmp::Reverse(self.counts[step as usize]), step));
        // lists grow at the head: the heaviest child goes in first and comes out last
        let (mut first_child, mut next, mut roots) = (vec![NONE; n], vec![NONE; n], NONE);
        for step in steps {
            let head = match usize::try_from(self.parent[step as usize]) {
                Ok(parent) => &mut first_child[parent],
                Err(_) => &mut roots,
            };
            next[step as usize] = *head;
            *head = step;
        }
        let mut ordered = Vec::with_capacity(n);
        let mut open = Vec::new();
        let mut at = roots;
        while at != NONE || !open.is_empty() {
            if at != NONE {
                open.push(at);
                at = first_child[at as usize];
            } else if let Some(done) = open.pop() {
                ordered.push(self.sequence[done as usize]);
                at = next[done as usize];
            }
        }
        ordered
    }
}

const NONE: u32 = u32::MAX;

fn too_large(n: usize, reason: &str) -> SimError {
    SimError::TooLarge { n_equations: 3 * n, reason: reason.to_owned() }
}

/// The graph's upper triangle by columns, eliminated as in `sequence`.
fn upper_pattern(graph: &NodeGraph, sequence: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let mut step_of = vec![0; sequence.len()];
    for (step, &place) in sequence.iter().enumerate() {
        step_of[place as usize] = step as u32;
    }
    let mut col_ptr = vec![0];
    let mut row_idx = Vec::with_capacity(graph.neighbours.len() / 2);
    for (step, &place) in sequence.iter().enumerate() {
        let others = graph.of(place as usize).iter();
        row_idx.extend(
            others.map(|&other| step_of[other as usize]).filter(|&other| (other as usize) < step),
        );
        col_ptr.push(row_idx.len() as u32);
    }
    (col_ptr, row_idx)
}

fn minimum_degree(graph: &NodeGraph) -> Result<Vec<u32>, SimError> {
    let n = graph.row_ptr.len() - 1;
    let natural: Vec<u32> = (0..n as u32).collect();
    let (col_ptr, row_idx) = upper_pattern(graph, &natural);
    let pattern = SymbolicSparseColMatRef::new_checked(n, n, &col_ptr, None, &row_idx);
    let scratch = amd::order_scratch::<u32>(n, row_idx.len());
    let mut memory =
        MemBuffer::try_new(scratch).map_err(|_| too_large(n, "no memory for the ordering"))?;
    let (mut forward, mut inverse) = (vec![0; n], vec![0; n]);
    amd::order(
        &mut forward,
        &mut inverse,
        pattern,
        amd::Control::default(),
        MemStack::new(&mut memory),
    )
    .map_err(|error| too_large(n, &format!("{error:?}")))?;
    Ok(forward)
}

/// METIS draws random numbers from one global state: two calls at once would not repeat.
static METIS: Mutex<()> = Mutex::new(());

/// The sequence that METIS gives, or nothing where it fails or 32-bit indices don't reach.
fn nested_dissection(graph: &NodeGraph) -> Option<Vec<u32>> {
    let to_index = |i: usize| i32::try_from(i).ok();
    let mut n = to_index(graph.row_ptr.len() - 1)?;
    let starts = graph.row_ptr.iter().map(|&i| to_index(i));
    let mut starts: Vec<i32> = starts.collect::<Option<_>>()?;
    let mut neighbours: Vec<i32> = graph.neighbours.iter().map(|&i| i as i32).collect();
    let mut sequence = vec![0_i32; graph.row_ptr.len() - 1];
    let mut inverse = sequence.clone();
    let only = METIS.lock().unwrap_or_else(PoisonError::into_inner);
    // SAFETY: the arrays have the lengths METIS reads and writes: n + 1 starts, the last of which
    // is the number of neighbours, and n for each permutation; neighbours are below n; null weights
    // and options stand for the defaults (METIS 5.1 manual, section 5.8), whose seed is fixed.
    let status = unsafe {
        metis_sys::METIS_NodeND(
            &raw mut n,
            starts.as_mut_ptr(),
            neighbours.as_mut_ptr(),
            ptr::null_mut(),
            ptr::null_mut(),
            sequence.as_mut_ptr(),
            inverse.as_mut_ptr(),
        )
    };
    drop(only);
    (status == metis_sys::rstatus_et_METIS_OK)
        .then(|| sequence.into_iter().map(|place| place as u32).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An n × n grid with its diagonals.
    fn grid(n: usize) -> NodeGraph {
        let mut graph = NodeGraph { row_ptr: vec![0], neighbours: Vec::new() };
        for i in 0..n * n {
            for j in 0..n * n {
                let near = (i / n).abs_diff(j / n) <= 1 && (i % n).abs_diff(j % n) <= 1;
                if near && i != j {
                    graph.neighbours.push(j as u32);
                }
            }
            graph.row_ptr.push(graph.neighbours.len());
        }
        graph
    }

    #[test]
    fn every_place_is_eliminated_once_and_children_stand_before_parents() {
        for n in [1, 7, 40] {
            let graph = grid(n);
            let (sequence, _) = sequence(&graph).unwrap();
            let mut seen = sequence.clone();
            seen.sort_unstable();
            assert!(seen.iter().enumerate().all(|(i, &place)| i == place as usize));
            let tree = Tree::of(&graph, sequence).unwrap();
            let natural: Vec<u32> = (0..(n * n) as u32).collect();
            assert!(tree.fill() <= Tree::of(&graph, natural).unwrap().fill());
            // in a postordered tree the subtree below a step ends just before it
            let (mut size, mut lowest) = (vec![1; n * n], (0..n * n).collect::<Vec<_>>());
            for step in 0..n * n {
                assert_eq!(lowest[step] + size[step], step + 1);
                if let Ok(parent) = usize::try_from(tree.parent[step]) {
                    size[parent] += size[step];
                    lowest[parent] = lowest[parent].min(lowest[step]);
                }
            }
        }
    }

    #[test]
    fn dissection_gives_the_same_sequence_twice() {
        let graph = grid(30);
        let once = nested_dissection(&graph).unwrap();
        assert_eq!(once, nested_dissection(&graph).unwrap());
    }
}
