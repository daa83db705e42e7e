//! The rigid motions of a model, seen by its unknowns.

use nalgebra::{Matrix3, Point3, Vector3};

use super::aggregate::Modes;
use crate::supports::unknowns::{Link, Unknowns};

/// Three translations, and three rotations about the middle of the nodes in units of their extent,
/// at each place; what a symmetry plane holds is zero.
pub(crate) fn rigid_modes(positions: &[Point3<f64>], unknowns: &Unknowns) -> Vec<Modes<3>> {
    let n = positions.len().max(1) as f64;
    let centre: Vector3<f64> = positions.iter().map(|p| p.coords / n).sum();
    let distances = positions.iter().map(|p| (p.coords - centre).norm());
    let extent = distances.fold(f64::MIN_POSITIVE, f64::max);
    let modes = |owner: &crate::supports::unknowns::Owner| {
        let at = positions[owner.node.index()].coords;
        let own = match unknowns.translation(owner.node) {
            Link::Tied { arm, .. } => at - arm,
            _ => at,
        };
        let motion = if owner.is_rotation {
            unknowns.rotation(owner.node)
        } else {
            Some(unknowns.translation(owner.node))
        };
        let projector = match motion {
            Some(Link::Roller(_, projector)) => **projector,
            _ => Matrix3::identity(),
        };
        let (translation, rotation) = if owner.is_rotation {
            (Matrix3::zeros(), Matrix3::identity() / extent)
        } else {
            let arm: Vector3<f64> = (own - centre) / extent;
            (Matrix3::identity(), -arm.cross_matrix())
        };
        let (translation, rotation) = (projector * translation, projector * rotation);
        std::array::from_fn(|i| {
            std::array::from_fn(|c| match c {
                0..3 => translation[(i, c)],
                _ => rotation[(i, c - 3)],
            })
        })
    };
    unknowns.owners().iter().map(modes).collect()
}
