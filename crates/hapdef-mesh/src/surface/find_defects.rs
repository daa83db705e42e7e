//! Where a triangle surface is no clean manifold, and refusals of surfaces that are none.

use super::defects::SurfaceDefects;
use crate::surface::quality::is_flat;
use crate::surface::topology::{repeats, sorted_half_edges};
use crate::{LengthUnit, SurfaceFault, SurfaceMesh, UnitGuess};

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
