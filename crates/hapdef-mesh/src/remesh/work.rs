//! A triangle surface that can be split, collapsed and flipped edge by edge.

use std::collections::BTreeSet;

use nalgebra::{Point3, Vector3};

use crate::surface::topology::sorted_half_edges;
use crate::{MeshError, SurfaceMesh};

/// How freely a vertex may move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    /// Anywhere on the surface.
    Free,
    /// Along its crease: a sharp edge or a rim.
    Crease,
    /// Nowhere: creases meet, end or bend here.
    Corner,
}

/// A crease that bends by more than this has a corner there, rad.
const CORNER_ANGLE_RAD: f64 = std::f64::consts::FRAC_PI_4;

/// A face that is gone.
const GONE: [u32; 3] = [u32::MAX; 3];

/// The surface being worked on. Faces that are gone keep their place.
pub(super) struct Work {
    pub points: Vec<Point3<f64>>,
    pub faces: Vec<[u32; 3]>,
    /// The faces around each vertex, in no order that matters but always the same one.
    pub around: Vec<Vec<u32>>,
    pub kinds: Vec<Kind>,
    /// Sharp edges and rims, ends ascending.
    pub creases: BTreeSet<[u32; 2]>,
    /// Vertices on a rim.
    pub is_rim: Vec<bool>,
    /// Crease vertices and corners that gave way to another one not along their crease.
    pub n_merged_features: usize,
}

impl Work {
    /// The surface with its open edges, and edges sharper than `feature_angle_rad`, as creases.
    pub fn new(mesh: &SurfaceMesh, feature_angle_rad: f64) -> Self {
        let n = mesh.vertices().len();
        let mut work = Self {
            points: mesh.vertices().to_vec(),
            faces: mesh.triangles().to_vec(),
            around: vec![Vec::new(); n],
            kinds: vec![Kind::Free; n],
            creases: BTreeSet::new(),
            is_rim: vec![false; n],
            n_merged_features: 0,
        };
        for (face, corners) in mesh.triangles().iter().enumerate() {
            corners.iter().for_each(|&v| work.around[v as usize].push(face as u32));
        }
        for uses in sorted_half_edges(mesh.triangles()).chunk_by(|a, b| a.ends() == b.ends()) {
            let edge = [uses[0].low, uses[0].high];
            match uses {
                [a, b] => {
                    let [n1, n2] = [a, b].map(|half| mesh.area_normal_m2(half.triangle));
                    if n1.angle(&n2) > feature_angle_rad {
                        work.creases.insert(edge);
                    }
                }
                _ => {
                    work.creases.insert(edge);
                    edge.iter().for_each(|&v| work.is_rim[v as usize] = true);
                }
            }
        }
        work.set_kinds();
        work
    }

    fn set_kinds(&mut self) {
        let mut ends: Vec<Vec<u32>> = vec![Vec::new(); self.points.len()];
        for &[a, b] in &self.creases {
            ends[a as usize].push(b);
            ends[b as usize].push(a);
        }
        for (vertex, ends) in ends.iter().enumerate() {
            let p = self.points[vertex];
            self.kinds[vertex] = match ends[..] {
                [] => Kind::Free,
                [a, b] => {
                    let (before, after) = (p - self.at(a), self.at(b) - p);
                    if before.angle(&after) > CORNER_ANGLE_RAD {
                        Kind::Corner
                    } else {
                        Kind::Crease
                    }
                }
                _ => Kind::Corner,
            };
        }
    }

    pub fn at(&self, vertex: u32) -> Point3<f64> {
        self.points[vertex as usize]
    }

    pub fn length(&self, [a, b]: [u32; 2]) -> f64 {
        (self.at(b) - self.at(a)).norm()
    }

    /// All edges, ends ascending, in order.
    pub fn edges(&self) -> Vec<[u32; 2]> {
        let mut edges: Vec<[u32; 2]> = self
            .faces
            .iter()
            .filter(|face| **face != GONE)
            .flat_map(|&[a, b, c]| [key(a, b), key(b, c), key(c, a)])
            .collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    /// The faces on both sides of an edge: two, one on a rim, none if there is no such edge.
    pub fn faces_at(&self, [a, b]: [u32; 2]) -> Vec<u32> {
        let has_b = |face: &&u32| self.faces[**face as usize].contains(&b);
        self.around[a as usize].iter().filter(has_b).copied().collect()
    }

    /// Vertices joined to `vertex` by an edge, ascending.
    pub fn neighbours(&self, vertex: u32) -> Vec<u32> {
        let mut found: Vec<u32> = self.around[vertex as usize]
            .iter()
            .flat_map(|&face| self.faces[face as usize])
            .filter(|v| *v != vertex)
            .collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The vertices that a crease joins to `vertex`, ascending.
    pub fn crease_neighbours(&self, vertex: u32) -> Vec<u32> {
        let mut found = self.neighbours(vertex);
        found.retain(|other| self.creases.contains(&key(vertex, *other)));
        found
    }

    /// Corners of a face, `vertex` taken to be at `place`.
    pub fn corners_with(&self, face: u32, vertex: u32, place: Point3<f64>) -> [Point3<f64>; 3] {
        self.faces[face as usize].map(|v| if v == vertex { place } else { self.at(v) })
    }

    pub fn corners(&self, face: u32) -> [Point3<f64>; 3] {
        self.faces[face as usize].map(|v| self.at(v))
    }

    /// Puts a vertex in the middle of an edge.
    pub fn split(&mut self, edge: [u32; 2]) {
        let [a, b] = edge;
        let new = self.points.len() as u32;
        self.points.push(nalgebra::center(&self.at(a), &self.at(b)));
        self.around.push(Vec::new());
        let sides = self.faces_at(edge);
        self.is_rim.push(sides.len() == 1);
        let is_crease = self.creases.remove(&edge);
        self.kinds.push(if is_crease { Kind::Crease } else { Kind::Free });
        if is_crease {
            self.creases.insert(key(a, new));
            self.creases.insert(key(b, new));
        }
        for face in sides {
            let old = self.faces[face as usize];
            let second = self.faces.len() as u32;
            let swapped = |from: u32| old.map(|v| if v == from { new } else { v });
            self.faces[face as usize] = swapped(b);
            self.faces.push(swapped(a));
            self.around[b as usize].retain(|f| *f != face);
            self.around[b as usize].push(second);
            self.around[new as usize].extend([face, second]);
            let opposite = old.into_iter().find(|v| *v != a && *v != b);
            if let Some(opposite) = opposite {
                self.around[opposite as usize].push(second);
            }
        }
    }

    /// Draws vertex `gone` onto `kept`, which moves to `place`. The caller has made sure that the
    /// surface stays a manifold.
    pub fn collapse(&mut self, gone: u32, kept: u32, place: Point3<f64>) {
        let crease_ends = self.crease_neighbours(gone);
        let is_along = self.kinds[gone as usize] == Kind::Crease && crease_ends.contains(&kept);
        let merges = self.kinds[gone as usize] != Kind::Free && !is_along;
        for face in self.faces_at(key(gone, kept)) {
            for v in self.faces[face as usize] {
                self.around[v as usize].retain(|f| *f != face);
            }
            self.faces[face as usize] = GONE;
        }
        for other in crease_ends {
            self.creases.remove(&key(gone, other));
            if other != kept {
                self.creases.insert(key(kept, other));
            }
        }
        for face in std::mem::take(&mut self.around[gone as usize]) {
            let corners = &mut self.faces[face as usize];
            *corners = corners.map(|v| if v == gone { kept } else { v });
            self.around[kept as usize].push(face);
        }
        self.points[kept as usize] = place;
        if merges {
            self.n_merged_features += 1;
            let kind = &self.kinds[kept as usize];
            self.kinds[kept as usize] = match (kind, self.crease_neighbours(kept).len()) {
                (_, 0) => Kind::Free,
                (Kind::Crease, 2) => Kind::Crease,
                _ => Kind::Corner,
            };
        }
    }

    /// Turns the edge between two faces to join the vertices opposite to it.
    pub fn flip(&mut self, [a, b]: [u32; 2], faces: [u32; 2], new_faces: [[u32; 3]; 2]) {
        for v in [a, b] {
            self.around[v as usize].retain(|f| !faces.contains(f));
        }
        for (face, corners) in faces.into_iter().zip(new_faces) {
            self.faces[face as usize] = corners;
            for v in corners {
                if !self.around[v as usize].contains(&face) {
                    self.around[v as usize].push(face);
                }
            }
        }
    }

    /// The surface as it is, unused vertices left out, order kept.
    pub fn surface(&self) -> Result<SurfaceMesh, MeshError> {
        let mut new_vertex = vec![0; self.points.len()];
        let mut vertices = Vec::new();
        for (old, faces) in self.around.iter().enumerate() {
            if !faces.is_empty() {
                new_vertex[old] = vertices.len() as u32;
                vertices.push(self.points[old]);
            }
        }
        let alive = self.faces.iter().filter(|face| **face != GONE);
        let triangles = alive.map(|face| face.map(|v| new_vertex[v as usize]));
        SurfaceMesh::new(vertices, triangles.collect())
    }
}

pub(super) fn key(a: u32, b: u32) -> [u32; 2] {
    if a < b { [a, b] } else { [b, a] }
}

/// The normal of a face with twice its area as length, m².
pub(super) fn normal([a, b, c]: &[Point3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}

/// 4√3 area / Σ edge²: 1 for an equilateral triangle, 0 for one without area.
pub(super) fn shape([a, b, c]: &[Point3<f64>; 3]) -> f64 {
    let squares = (b - a).norm_squared() + (c - b).norm_squared() + (a - c).norm_squared();
    if squares > 0.0 { 2.0 * 3.0_f64.sqrt() * normal(&[*a, *b, *c]).norm() / squares } else { 0.0 }
}
