//! Which elements move together as long as nothing deforms.

use hapdef_mesh::FeNodeId;

/// For each tetrahedron, the first tetrahedron of the face-connected part it belongs to.
///
/// Solids joined by a face can't move against each other without deforming; joined by a node or an
/// edge they hinge.
pub(crate) fn face_connected(elements: &[[FeNodeId; 10]]) -> Vec<usize> {
    let mut faces: Vec<([FeNodeId; 3], usize)> = elements
        .iter()
        .enumerate()
        .flat_map(|(element, n)| {
            [[n[0], n[1], n[2]], [n[0], n[1], n[3]], [n[1], n[2], n[3]], [n[0], n[2], n[3]]].map(
                |mut face| {
                    face.sort_unstable();
                    (face, element)
                },
            )
        })
        .collect();
    faces.sort_unstable();
    let mut sets = DisjointSets::new(elements.len());
    for pair in faces.windows(2) {
        if pair[0].0 == pair[1].0 {
            sets.join(pair[0].1, pair[1].1);
        }
    }
    sets.roots()
}

/// Sets of 0..n that can be joined; each is named by its smallest member.
pub(crate) struct DisjointSets {
    parent: Vec<usize>,
}

impl DisjointSets {
    pub(crate) fn new(n: usize) -> Self {
        Self { parent: (0..n).collect() }
    }

    pub(crate) fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b)] = a.min(b);
    }

    /// The name of each member's set.
    pub(crate) fn roots(mut self) -> Vec<usize> {
        (0..self.parent.len()).map(|i| self.root(i)).collect()
    }

    fn root(&mut self, mut i: usize) -> usize {
        while self.parent[i] != i {
            self.parent[i] = self.parent[self.parent[i]];
            i = self.parent[i];
        }
        i
    }
}
