//! How a shell is looked for in a solid.

use crate::{OuterSkinParams, SurfaceFault};

/// How the wall of a solid is found, and when the solid counts as a shell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolidShellParams {
    /// When a triangle sees the outside.
    pub outer: OuterSkinParams,
    /// A triangle sees the outside, too, if its free fraction is more than this above that of the
    /// surface straight behind it: so the inner side of a bend is outer skin.
    pub min_free_lead: f64,
    /// Half angle of the cone of rays inward, rad.
    pub wall_cone_half_angle_rad: f64,
    /// Rays inward per sample; there are four samples a triangle.
    pub n_wall_rays: usize,
    /// The far side of a wall faces away from the skin within this angle, rad.
    pub max_wall_angle_rad: f64,
    /// A wall is a shell's if it is at most this part of the limb's extent behind it: the way from
    /// the skin inward to the last surface there.
    pub max_thickness_ratio: f64,
    /// The largest share of the outer skin's area that may be no shell.
    pub max_not_shell_share: f64,
    /// The largest difference between the shell's and the solid's volume, relative.
    pub max_volume_difference: f64,
    /// Take a surface of any size; otherwise it must be 0.05 to 0.8 m long, like a limb.
    pub any_size: bool,
}

impl Default for SolidShellParams {
    /// Outer skin leads by a quarter; cone 20°, 7 rays, walls parallel within 45°, at most a quarter of the limb thick; up to a
    /// quarter of the skin may be no shell, and the volume may differ by a quarter.
    fn default() -> Self {
        Self {
            outer: OuterSkinParams::default(),
            min_free_lead: 0.25,
            wall_cone_half_angle_rad: 20.0_f64.to_radians(),
            n_wall_rays: 7,
            max_wall_angle_rad: std::f64::consts::FRAC_PI_4,
            max_thickness_ratio: 0.25,
            max_not_shell_share: 0.25,
            max_volume_difference: 0.25,
            any_size: false,
        }
    }
}

impl SolidShellParams {
    /// Refuses a parameter out of its range.
    pub(super) fn check(&self) -> Result<(), SurfaceFault> {
        let outer = &self.outer;
        for (name, found) in [
            ("outer.cone_half_angle_rad", outer.cone_half_angle_rad),
            ("wall_cone_half_angle_rad", self.wall_cone_half_angle_rad),
            ("max_wall_angle_rad", self.max_wall_angle_rad),
        ] {
            let is_acute = found > 0.0 && found < std::f64::consts::FRAC_PI_2;
            ask(is_acute, name, found, "between 0 and π/2, ends excluded")?;
        }
        for (name, found) in [
            ("outer.min_free_fraction", outer.min_free_fraction),
            ("min_free_lead", self.min_free_lead),
            ("max_thickness_ratio", self.max_thickness_ratio),
            ("max_not_shell_share", self.max_not_shell_share),
        ] {
            let is_share = (0.0..=1.0).contains(&found);
            ask(is_share, name, found, "between 0 and 1")?;
        }
        for (name, n) in [("outer.n_rays", outer.n_rays), ("n_wall_rays", self.n_wall_rays)] {
            ask(n > 0, name, n as f64, "at least 1")?;
        }
        let difference = self.max_volume_difference;
        let name = "max_volume_difference";
        ask(difference >= 0.0, name, difference, "at least 0")
    }
}

fn ask(
    is_met: bool,
    name: &'static str,
    found: f64,
    wanted: &'static str,
) -> Result<(), SurfaceFault> {
    if is_met { Ok(()) } else { Err(SurfaceFault::Parameter { name, found, wanted }) }
}
