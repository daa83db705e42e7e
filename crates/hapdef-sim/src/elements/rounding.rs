//! The rounding in an element's matrix, seen on its rigid motions.

use nalgebra::{Point3, Vector3};

/// Six rigid motions, padded to whole vector registers.
type Row = [f64; 8];

/// The largest force that a rigid motion r leaves in an element, in its Jacobi scale:
/// max |s K r| / max |r / s|, which is 0 but for rounding.
///
/// `k` `[n, n]` is row-major over the motions of `nodes`, m: translations, each followed by a
/// rotation where `has_rotations`. Rounding that leaves rigid motions alone is a relative change of
/// the element's stiffness, and as harmless; rounding that does not holds the element back however
/// it deforms, and grows with its slenderness.
pub(crate) fn rigid_force(k: &[f64], nodes: &[Point3<f64>], has_rotations: bool) -> f64 {
    let n = k.len().isqrt();
    let motions = rigid_motions(nodes, has_rotations);
    let mut largest_force = [0.0_f64; 8];
    let mut largest_motion = [0.0_f64; 8];
    for ((i, row), motion) in k.chunks_exact(n).enumerate().zip(&motions) {
        let mut force = [0.0; 8];
        for (k, motion) in row.iter().zip(&motions) {
            for (f, m) in force.iter_mut().zip(motion) {
                *f += k * m;
            }
        }
        let root = row[i].sqrt();
        for l in 0..6 {
            largest_force[l] = largest_force[l].max(force[l].abs() / root);
            largest_motion[l] = largest_motion[l].max(motion[l].abs() * root);
        }
    }
    let ratios = largest_force.iter().zip(&largest_motion);
    ratios
        .filter(|(_, moved)| **moved > 0.0)
        .map(|(force, moved)| force / moved)
        .fold(0.0, f64::max)
}

/// Translations and rotations about the middle of `nodes`, a row per unknown.
fn rigid_motions(nodes: &[Point3<f64>], has_rotations: bool) -> Vec<Row> {
    let sum: Vector3<f64> = nodes.iter().map(|p| p - nodes[0]).sum();
    let centre = nodes[0] + sum / nodes.len() as f64;
    let mut rows = Vec::with_capacity(6 * nodes.len());
    for node in nodes {
        let [x, y, z] = (node - centre).into();
        rows.extend([
            [1.0, 0.0, 0.0, 0.0, z, -y, 0.0, 0.0],
            [0.0, 1.0, 0.0, -z, 0.0, x, 0.0, 0.0],
            [0.0, 0.0, 1.0, y, -x, 0.0, 0.0, 0.0],
        ]);
        if has_rotations {
            rows.extend([3, 4, 5].map(|axis| {
                let mut row = [0.0; 8];
                row[axis] = 1.0;
                row
            }));
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two nodes joined by a spring along x.
    fn spring(error: f64) -> f64 {
        let mut k = [0.0; 36];
        for (i, j, value) in [(0, 0, 1.0), (3, 3, 1.0), (0, 3, -1.0), (3, 0, -1.0 + error)] {
            k[6 * i + j] = value;
        }
        rigid_force(&k, &[Point3::origin(), Point3::new(2.0, 0.0, 0.0)], false)
    }

    #[test]
    fn only_what_holds_a_rigid_motion_back_counts() {
        assert_eq!(spring(0.0), 0.0);
        assert!((spring(1e-6) / 1e-6 - 1.0).abs() < 1e-6);
    }
}
