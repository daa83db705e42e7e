//! A shell of one thickness under a deck's outer skin, without ribs and rings.

use hapdef_mesh::{OuterSkinParams, SkinRegion, outer_skin, wall};

use crate::error::HapdefError;
use crate::limb::Limb;
use crate::wall_shell::WallShell;

/// The shell of the median wall behind the touchable skin, of material up to `max_wall_m` thick.
///
/// # Errors
/// [`HapdefError::Mesh`] where the skin has no wall behind it or the wall folds.
pub(super) fn even_shell(limb: &Limb, max_wall_m: f64) -> Result<WallShell, HapdefError> {
    let behind = wall(&limb.mesh, &limb.boundary, &limb.skin, max_wall_m)?;
    let thickness_m = behind.thickness_quantile_m(0.5).unwrap_or(0.0);
    let outside = sides(limb)?;
    let all_m = vec![thickness_m; outside.nodes.len()];
    WallShell::new(&limb.mesh, &outside, &all_m)
}

/// The outer skin without end faces: behind those lies more material than half the limb's width.
fn sides(limb: &Limb) -> Result<SkinRegion, HapdefError> {
    let (mesh, boundary) = (&limb.mesh, &limb.boundary);
    let outer = outer_skin(mesh, boundary, &OuterSkinParams::default())?;
    let half_width_m = 0.5 * outer.surface(mesh)?.bounding_box().size_m().min();
    let behind = wall(mesh, boundary, &outer, half_width_m)?;
    let faces = outer.faces.iter().zip(&behind.skin_thickness_m);
    let sides = faces.filter(|(_, thickness_m)| **thickness_m < half_width_m);
    let sides = sides.map(|(face, _)| *face).collect();
    Ok(SkinRegion::new(mesh, sides)?)
}
