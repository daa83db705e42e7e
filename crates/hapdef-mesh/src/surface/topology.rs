//! Edges, connected bodies and doubled triangles of a triangle list. Sorted arrays throughout, so
//! that results never depend on a hash order.

/// Whether a triangle names a vertex twice.
pub(crate) fn repeats([a, b, c]: &[u32; 3]) -> bool {
    a == b || b == c || c == a
}

/// How the edges of a triangle list are used. Triangles that repeat a corner have no edges.
pub(crate) struct Edges {
    pub n_edges: usize,
    pub n_open: usize,
    pub n_non_manifold: usize,
    pub n_misoriented: usize,
}

impl Edges {
    pub fn of(triangles: &[[u32; 3]]) -> Self {
        let mut counts = Self { n_edges: 0, n_open: 0, n_non_manifold: 0, n_misoriented: 0 };
        for uses in sorted_half_edges(triangles).chunk_by(|a, b| a.ends() == b.ends()) {
            counts.n_edges += 1;
            match uses {
                [_] => counts.n_open += 1,
                [a, b] => counts.n_misoriented += usize::from(a.is_forward == b.is_forward),
                _ => counts.n_non_manifold += 1,
            }
        }
        counts
    }
}

/// The number of sets of triangles connected across edges.
pub(crate) fn count_bodies(triangles: &[[u32; 3]]) -> usize {
    bodies(triangles).len()
}

/// The sets of triangles connected across edges, each ascending, in order of their first triangle.
/// Triangles that repeat a corner belong to none.
pub(crate) fn bodies(triangles: &[[u32; 3]]) -> Vec<Vec<usize>> {
    let mut parent: Vec<usize> = (0..triangles.len()).collect();
    for uses in sorted_half_edges(triangles).chunk_by(|a, b| a.ends() == b.ends()) {
        for pair in uses.windows(2) {
            let [a, b] = [pair[0].triangle, pair[1].triangle].map(|t| root(&mut parent, t));
            parent[a.max(b)] = a.min(b);
        }
    }
    let mut number = vec![usize::MAX; triangles.len()];
    let mut sets: Vec<Vec<usize>> = Vec::new();
    for triangle in (0..triangles.len()).filter(|&t| !repeats(&triangles[t])) {
        let first = root(&mut parent, triangle);
        if number[first] == usize::MAX {
            number[first] = sets.len();
            sets.push(Vec::new());
        }
        sets[number[first]].push(triangle);
    }
    sets
}

/// Triangles with the same three vertices, in any order, as an earlier one.
pub(crate) fn count_doubled(triangles: &[[u32; 3]]) -> usize {
    let mut sorted: Vec<[u32; 3]> = triangles.iter().filter(|t| !repeats(t)).copied().collect();
    sorted.iter_mut().for_each(|t| t.sort_unstable());
    sorted.sort_unstable();
    sorted.windows(2).filter(|pair| pair[0] == pair[1]).count()
}

/// One side of a triangle.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct HalfEdge {
    pub low: u32,
    pub high: u32,
    pub triangle: usize,
    pub is_forward: bool,
}

impl HalfEdge {
    pub fn ends(&self) -> (u32, u32) {
        (self.low, self.high)
    }
}

pub(crate) fn sorted_half_edges(triangles: &[[u32; 3]]) -> Vec<HalfEdge> {
    let mut half_edges = Vec::with_capacity(3 * triangles.len());
    for (triangle, corners) in triangles.iter().enumerate().filter(|(_, t)| !repeats(t)) {
        for i in 0..3 {
            let (from, to) = (corners[i], corners[(i + 1) % 3]);
            let (low, high) = (from.min(to), from.max(to));
            half_edges.push(HalfEdge { low, high, triangle, is_forward: from < to });
        }
    }
    half_edges.sort_unstable();
    half_edges
}

/// The representative of the set that `member` is in; paths are halved on the way.
pub(crate) fn root(parent: &mut [usize], mut member: usize) -> usize {
    while parent[member] != member {
        parent[member] = parent[parent[member]];
        member = parent[member];
    }
    member
}
