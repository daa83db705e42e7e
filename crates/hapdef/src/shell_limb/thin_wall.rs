//! Whether a wall is thin enough for a shell, from its measures alone.

use std::fmt;

use serde::Serialize;

use super::ShellLimb;
use super::differences::GOOD_DIFFERENCE;

/// A wall's thickness against the limb's narrowest half.
///
/// The inner side of a wall of thickness t with radius R at its middle is shorter by t / 2R than
/// the middle, which a shell of flat facets leaves out: by that its readings are off, even if all
/// else were right (the next term of ε(z) = (ε₀ + z κ) / (1 + z/R) at z = −t/2; Flügge, Stresses in
/// Shells, 2nd ed., 1973, chapter 5).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ThinWall {
    /// The thickest wall, m.
    pub thickness_m: f64,
    /// Half of the bounding box's shortest edge, m.
    pub radius_m: f64,
}

impl ThinWall {
    /// t / 2R.
    #[must_use]
    pub fn left_out(&self) -> f64 {
        0.5 * self.thickness_m / self.radius_m
    }

    /// What to take instead of a shell; nothing where the wall is thin. Ribs, rings and cores don't
    /// show in a wall's thickness.
    #[must_use]
    pub fn recommendation(&self) -> Option<String> {
        (self.left_out() > GOOD_DIFFERENCE).then(|| {
            format!(
                "use the solid: a wall of {:.2} mm on a limb {:.1} mm across is no thin one, a shell \
                 leaves out t/2R = {:.0} % (10 % is allowed; from the measures alone, not compared)",
                1e3 * self.thickness_m,
                2e3 * self.radius_m,
                100.0 * self.left_out()
            )
        })
    }
}

impl fmt::Display for ThinWall {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "t/2R = {:.1} % (thickest wall {:.2} mm, limb {:.1} mm across)",
            100.0 * self.left_out(),
            1e3 * self.thickness_m,
            2e3 * self.radius_m
        )
    }
}

impl ShellLimb {
    /// The measures of its wall.
    #[must_use]
    pub fn thin_wall(&self) -> ThinWall {
        ThinWall {
            thickness_m: self.mesh.thickness_m().iter().copied().fold(0.0, f64::max),
            radius_m: 0.5 * self.skin.bounding_box().size_m().min(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fifth_of_the_radius_is_the_limit() {
        let of = |thickness_m| ThinWall { thickness_m, radius_m: 0.025 };
        assert_eq!(of(1e-3).recommendation(), None);
        assert_eq!(of(4.9e-3).recommendation(), None);
        let text = of(8e-3).recommendation().unwrap();
        assert!(text.contains("t/2R = 16 %"), "{text}");
    }
}
