//! The largest connected piece of a skin, and vertices where two fans of it touch.

use super::walls::WallKind;
use crate::surface::topology::bodies;
use crate::{MeshError, SurfaceMesh};

/// The triangles of the largest piece by area of [`WallKind::Shell`], ascending; those of the other
/// pieces become [`WallKind::Island`]. Empty if there is no shell.
pub(super) fn largest_piece(solid: &SurfaceMesh, kinds: &mut [WallKind]) -> Vec<usize> {
    let shell: Vec<usize> = (0..kinds.len()).filter(|&t| kinds[t] == WallKind::Shell).collect();
    let triangles: Vec<[u32; 3]> = shell.iter().map(|&t| solid.triangles()[t]).collect();
    let mut best = (0.0, Vec::new());
    for piece in bodies(&triangles) {
        let piece: Vec<usize> = piece.into_iter().map(|i| shell[i]).collect();
        let area: f64 = piece.iter().map(|&t| solid.area_normal_m2(t).norm()).sum();
        if area > best.0 {
            best = (area, piece);
        }
    }
    for &triangle in &shell {
        kinds[triangle] = WallKind::Island;
    }
    for &triangle in &best.1 {
        kinds[triangle] = WallKind::Shell;
    }
    best.1
}

/// The surface with every vertex that joins several fans of triangles given to the first of them,
/// and a new one at the same place to each other; and how many such vertices there were.
pub(super) fn split_pinched(mesh: &SurfaceMesh) -> Result<(SurfaceMesh, usize), MeshError> {
    let mut vertices = mesh.vertices().to_vec();
    let mut triangles = mesh.triangles().to_vec();
    let mut around: Vec<Vec<usize>> = vec![Vec::new(); vertices.len()];
    for (triangle, corners) in triangles.iter().enumerate() {
        corners.iter().for_each(|&v| around[v as usize].push(triangle));
    }
    let mut n_split = 0;
    for (vertex, fan) in around.iter().enumerate() {
        let fans = fans(mesh, vertex as u32, fan);
        n_split += usize::from(fans.len() > 1);
        for other in fans.iter().skip(1) {
            let new = vertices.len() as u32;
            vertices.push(vertices[vertex]);
            for &triangle in other {
                for corner in &mut triangles[triangle] {
                    if *corner == vertex as u32 {
                        *corner = new;
                    }
                }
            }
        }
    }
    Ok((SurfaceMesh::new(vertices, triangles)?, n_split))
}

/// The triangles around a vertex, in sets connected across edges that end in it.
fn fans(mesh: &SurfaceMesh, vertex: u32, around: &[usize]) -> Vec<Vec<usize>> {
    let mut left: Vec<usize> = around.to_vec();
    let mut fans = Vec::new();
    while !left.is_empty() {
        let mut fan = vec![left.remove(0)];
        let mut next = 0;
        while next < fan.len() {
            let corners = mesh.triangles()[fan[next]];
            let touches = |&t: &usize| {
                let shared = mesh.triangles()[t].into_iter().filter(|v| *v != vertex);
                shared.into_iter().any(|v| corners.contains(&v))
            };
            let (touching, others): (Vec<usize>, Vec<usize>) =
                left.iter().partition(|t| touches(t));
            fan.extend(touching);
            left = others;
            next += 1;
        }
        fans.push(fan);
    }
    fans
}
