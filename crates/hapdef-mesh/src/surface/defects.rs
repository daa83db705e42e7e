//! What keeps a triangle surface from being a clean manifold, counted, with the first place of each.

use std::fmt;

/// How often a defect occurs, and where first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Defect<P> {
    /// How often.
    pub n: usize,
    /// The first place: an edge's two vertices, a vertex or a triangle, counted from 0.
    pub first: Option<P>,
}

/// The defects of a triangle surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceDefects {
    /// Edges with one triangle.
    pub open_edges: Defect<[u32; 2]>,
    /// Edges with more than two triangles.
    pub non_manifold_edges: Defect<[u32; 2]>,
    /// Edges whose two triangles disagree on which side is outside.
    pub misoriented_edges: Defect<[u32; 2]>,
    /// Vertices where separate fans of triangles touch.
    pub non_manifold_vertices: Defect<u32>,
    /// Triangles without area ([`QualityReport`](crate::QualityReport)).
    pub degenerate_triangles: Defect<usize>,
    /// Triangles with the corners of an earlier one.
    pub doubled_triangles: Defect<usize>,
    /// The area of all triangles, m².
    pub area_m2: f64,
    /// V = ⅓ ∮ x·n dA over the triangles there are, m³: the enclosed volume if the surface is
    /// closed, else a number to compare with.
    pub volume_m3: f64,
}

impl<P> Defect<P> {
    pub(super) fn add(&mut self, place: P) {
        self.n += 1;
        self.first.get_or_insert(place);
    }
}

impl SurfaceDefects {
    /// Whether there is nothing but, at most, open edges.
    #[must_use]
    pub fn is_manifold(&self) -> bool {
        self.non_manifold_edges.n == 0
            && self.misoriented_edges.n == 0
            && self.non_manifold_vertices.n == 0
            && self.degenerate_triangles.n == 0
            && self.doubled_triangles.n == 0
    }

    /// Whether the surface is a manifold without open edges.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.is_manifold() && self.open_edges.n == 0
    }
}

impl fmt::Display for SurfaceDefects {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let edge = |d: &Defect<[u32; 2]>| d.first.map(|[a, b]| (d.n, format!("first {a}-{b}")));
        let one = |n: usize, first: Option<usize>| first.map(|t| (n, format!("first {t}")));
        let vertices = &self.non_manifold_vertices;
        let rows = [
            ("open edges", edge(&self.open_edges)),
            ("non-manifold edges", edge(&self.non_manifold_edges)),
            ("misoriented edges", edge(&self.misoriented_edges)),
            ("non-manifold vertices", one(vertices.n, vertices.first.map(|v| v as usize))),
            (
                "degenerate triangles",
                one(self.degenerate_triangles.n, self.degenerate_triangles.first),
            ),
            ("doubled triangles", one(self.doubled_triangles.n, self.doubled_triangles.first)),
        ];
        let found = rows.iter().filter_map(|(what, row)| row.as_ref().map(|row| (what, row)));
        for (i, (what, (n, first))) in found.enumerate() {
            let separator = if i == 0 { "" } else { ", " };
            write!(f, "{separator}{n} {what} ({first})")?;
        }
        let closed = if self.is_closed() { "" } else { " as if it were closed" };
        let (area, volume) = (self.area_m2 * 1e4, self.volume_m3 * 1e6);
        write!(f, "; area {area:.2} cm2, volume {volume:.3} cm3{closed}")
    }
}
