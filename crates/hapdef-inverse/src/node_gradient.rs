//! Gradients of nodal values on three-node faces, by least squares over a neighbourhood.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use crate::dense::{cholesky, solve_lower, solve_upper};
use crate::skin::Skin;

/// Neighbours wanted for a quadratic fit of five unknowns.
const N_WANTED: usize = 9;

/// Rings of neighbours looked at.
const MAX_RINGS: usize = 3;

/// Who shares a face with whom.
pub(crate) struct Neighbourhood {
    ring: Vec<BTreeSet<u32>>,
}

impl Neighbourhood {
    pub(crate) fn new(skin: &Skin) -> Self {
        let mut ring = vec![BTreeSet::new(); skin.n_nodes()];
        for face in 0..skin.n_faces() {
            let nodes = skin.face_nodes(face);
            for &a in nodes {
                for &b in nodes {
                    if a != b {
                        ring[a as usize].insert(b);
                    }
                }
            }
        }
        Self { ring }
    }

    /// Nodes around `node`, ring by ring, until there are enough.
    fn around(&self, node: u32) -> Vec<u32> {
        let mut found = BTreeSet::from([node]);
        for _ in 0..MAX_RINGS {
            let next: Vec<u32> =
                found.iter().flat_map(|&n| self.ring[n as usize].iter().copied()).collect();
            found.extend(next);
            if found.len() > N_WANTED {
                break;
            }
        }
        found.remove(&node);
        found.into_iter().collect()
    }
}

/// Weights wⱼ with ∇f(node) ≈ Σ wⱼ fⱼ, the node's own among them: a quadratic through the node in
/// its tangent plane, fitted to the neighbours with weights 1/d², or a linear one where there are
/// too few of them.
pub(crate) fn gradient_weights(
    skin: &Skin,
    near: &Neighbourhood,
    node: u32,
) -> Vec<(u32, Vector3<f64>)> {
    let around = near.around(node);
    let normal = skin.normals()[node as usize];
    let axes = tangent_axes(&normal);
    let centre = skin.nodes()[node as usize];
    let offsets: Vec<[f64; 2]> = around
        .iter()
        .map(|&n| {
            let d = skin.nodes()[n as usize] - centre;
            axes.map(|axis| axis.dot(&d))
        })
        .collect();
    let solved = fit(&offsets, 5)
        .or_else(|| fit(&offsets, 2))
        .unwrap_or_else(|| vec![[0.0; 2]; offsets.len()]);
    let vector = |w: [f64; 2]| axes[0] * w[0] + axes[1] * w[1];
    let mut weights: Vec<_> = around.iter().zip(solved).map(|(&n, w)| (n, vector(w))).collect();
    let sum: Vector3<f64> = weights.iter().map(|(_, w)| *w).sum();
    weights.push((node, -sum));
    weights
}

pub(crate) fn tangent_axes(normal: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let helper = if normal.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() };
    let first = normal.cross(&helper);
    let first = first / first.norm().max(f64::MIN_POSITIVE);
    [first, normal.cross(&first)]
}

/// Weights of each neighbour's difference in the two slopes at the origin, from a fit of
/// `n_terms` (2 or 5) monomials; `None` where the neighbours don't determine them.
fn fit(offsets: &[[f64; 2]], n_terms: usize) -> Option<Vec<[f64; 2]>> {
    if offsets.len() < n_terms {
        return None;
    }
    let size = offsets.iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let terms = |[x, y]: [f64; 2]| {
        let (x, y) = (x / size, y / size);
        [x, y, x * x, x * y, y * y]
    };
    let weight = |[x, y]: [f64; 2]| 1.0 / ((x * x + y * y) / (size * size)).max(1e-12);
    let mut normal = vec![0.0; n_terms * n_terms];
    for &offset in offsets {
        let t = terms(offset);
        for i in 0..n_terms {
            for j in 0..n_terms {
                normal[i * n_terms + j] += weight(offset) * t[i] * t[j];
            }
        }
    }
    if !cholesky(&mut normal, n_terms, 1e-6) {
        return None;
    }
    let solved = offsets.iter().map(|&offset| {
        let mut x: Vec<f64> = terms(offset)[..n_terms].iter().map(|t| t * weight(offset)).collect();
        solve_lower(&normal, n_terms, &mut x);
        solve_upper(&normal, n_terms, &mut x);
        [x[0] / size, x[1] / size]
    });
    Some(solved.collect())
}
