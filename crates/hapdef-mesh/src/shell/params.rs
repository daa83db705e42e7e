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
        let right_angle = std::f64::consts::FRAC_PI_2;
        let angle = "between 0 and π/2, ends excluded";
        let share = "between 0 and 1";
        let open = |x: f64, high: f64| x > 0.0 && x < high;
        let share_ok = |x: f64| (0.0..=1.0).contains(&x);
        let outer = &self.outer;
        let checks = [
            (
                "outer.cone_half_angle_rad",
                outer.cone_half_angle_rad,
                angle,
                open(outer.cone_half_angle_rad, right_angle),
            ),
            (
                "outer.n_rays",
                outer.n_rays as f64,
                "at least 1",
                outer.n_rays > 0,
            ),
            (
                "outer.min_free_fraction",
                outer.min_free_fraction,
                share,
                share_ok(outer.min_free_fraction),
            ),
            (
                "min_free_lead",
                self.min_free_lead,
                share,
                share_ok(self.min_free_lead),
            ),
            (
                "wall_cone_half_angle_rad",
                self.wall_cone_half_angle_rad,
                angle,
                open(self.wall_cone_half_angle_rad, right_angle),
            ),
            (
                "n_wall_rays",
                self.n_wall_rays as f64,
                "at least 1",
                self.n_wall_rays > 0,
            ),
            (
                "max_wall_angle_rad",
                self.max_wall_angle_rad,
                angle,
                open(self.max_wall_angle_rad, right_angle),
            ),
            (
                "max_thickness_ratio",
                self.max_thickness_ratio,
                share,
                share_ok(self.max_thickness_ratio),
            ),
            (
                "max_not_shell_share",
                self.max_not_shell_share,
                share,
                share_ok(self.max_not_shell_share),
            ),
            (
                "max_volume_difference",
                self.max_volume_difference,
                "at least 0",
                self.max_volume_difference >= 0.0,
            ),
        ];
        match checks.into_iter().find(|check| !check.3) {
            None => Ok(()),
            Some((name, found, wanted, _)) => Err(SurfaceFault::Parameter {
                name,
                found,
                wanted,
            }),
        }
    }
}
