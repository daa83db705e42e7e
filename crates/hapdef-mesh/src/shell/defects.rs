//! What keeps a triangle surface from being a clean manifold, counted, with the first place of each.

use std::fmt;

use crate::quality::is_flat;
use crate::topology::sorted_half_edges;
use crate::weld::repeats;
use crate::{LengthUnit, SurfaceFault, SurfaceMesh, UnitGuess};

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
    fn add(&mut self, place: P) {
        self.n += 1;
        self.first.get_or_insert(place);
    }
}

impl SurfaceDefects {
    /// Looks at every edge, vertex and triangle of `mesh`.
    #[must_use]
    pub fn of(mesh: &SurfaceMesh) -> Self {
        let mut defects =
            Self { area_m2: mesh.area_m2(), volume_m3: mesh.signed_volume_m3(), ..Self::default() };
        defects.count_edges(mesh);
        defects.count_triangles(mesh);
        defects.count_vertices(mesh);
        defects
    }

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

    fn count_edges(&mut self, mesh: &SurfaceMesh) {
        for uses in sorted_half_edges(mesh.triangles()).chunk_by(|a, b| a.ends() == b.ends()) {
            let edge = [uses[0].low, uses[0].high];
            match uses {
                [_] => self.open_edges.add(edge),
                [a, b] if a.is_forward == b.is_forward => self.misoriented_edges.add(edge),
                [_, _] => {}
                _ => self.non_manifold_edges.add(edge),
            }
        }
    }

    fn count_triangles(&mut self, mesh: &SurfaceMesh) {
        let mut keys: Vec<([u32; 3], usize)> = Vec::new();
        for (triangle, corners) in mesh.triangles().iter().enumerate() {
            if repeats(corners) || is_flat(mesh, triangle) {
                self.degenerate_triangles.add(triangle);
            }
            if !repeats(corners) {
                let mut key = *corners;
                key.sort_unstable();
                keys.push((key, triangle));
            }
        }
        keys.sort_unstable();
        let doubled = keys.windows(2).filter(|pair| pair[0].0 == pair[1].0);
        let mut doubled: Vec<usize> = doubled.map(|pair| pair[1].1).collect();
        doubled.sort_unstable();
        doubled.into_iter().for_each(|t| self.doubled_triangles.add(t));
    }

    /// A vertex is a manifold's if its triangles form one fan: they are connected across edges
    /// that end in it.
    fn count_vertices(&mut self, mesh: &SurfaceMesh) {
        let mut around: Vec<Vec<[u32; 2]>> = vec![Vec::new(); mesh.vertices().len()];
        for corners in mesh.triangles().iter().filter(|t| !repeats(t)) {
            for i in 0..3 {
                around[corners[i] as usize].push([corners[(i + 1) % 3], corners[(i + 2) % 3]]);
            }
        }
        for (vertex, links) in around.iter().enumerate() {
            if count_fans(links) > 1 {
                self.non_manifold_vertices.add(vertex as u32);
            }
        }
    }
}

/// Connected pieces of the edges opposite a vertex.
fn count_fans(links: &[[u32; 2]]) -> usize {
    let mut reached = vec![false; links.len()];
    let mut n_fans = 0;
    for start in 0..links.len() {
        if reached[start] {
            continue;
        }
        n_fans += 1;
        reached[start] = true;
        let mut open = vec![start];
        while let Some(link) = open.pop() {
            for other in 0..links.len() {
                let touches = links[other].iter().any(|v| links[link].contains(v));
                if touches && !reached[other] {
                    reached[other] = true;
                    open.push(other);
                }
            }
        }
    }
    n_fans
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

/// Refuses a surface that is not an oriented manifold; open edges are allowed.
pub(crate) fn check_manifold(mesh: &SurfaceMesh) -> Result<SurfaceDefects, SurfaceFault> {
    let defects = SurfaceDefects::of(mesh);
    if defects.is_manifold() {
        return Ok(defects);
    }
    Err(SurfaceFault::Defects { wanted: "a manifold surface", defects: Box::new(defects) })
}

/// Refuses a surface that is not closed, or whose volume no solid in its bounding box has.
pub(crate) fn check_closed(mesh: &SurfaceMesh) -> Result<SurfaceDefects, SurfaceFault> {
    let defects = SurfaceDefects::of(mesh);
    if !defects.is_closed() {
        return Err(SurfaceFault::Defects { wanted: "a closed solid", defects: Box::new(defects) });
    }
    let size = mesh.bounding_box().size_m();
    let (volume_m3, box_volume_m3) = (defects.volume_m3, size.x * size.y * size.z);
    if volume_m3 > 0.0 && volume_m3 <= box_volume_m3 * (1.0 + 1e-12) {
        Ok(defects)
    } else {
        Err(SurfaceFault::Volume { volume_m3, box_volume_m3 })
    }
}

/// Refuses a surface whose longest extent in metres is no limb's.
pub(crate) fn check_size(mesh: &SurfaceMesh) -> Result<(), SurfaceFault> {
    let longest_m = mesh.bounding_box().longest_m();
    let guess = UnitGuess::of_length(longest_m);
    if guess.candidates.contains(&LengthUnit::Metre) {
        return Ok(());
    }
    let names: Vec<&str> = guess.candidates.iter().map(|unit| unit.symbol()).collect();
    let candidates = match names[..] {
        [] => "none of m, mm, cm, in fits".to_owned(),
        _ => names.join(" or "),
    };
    Err(SurfaceFault::UnitUnknown { longest_m, candidates })
}
