//! Units of length, and which one a file was probably made in.

use std::fmt;

/// The length of a plausible limb, m: from a robot finger to a leg.
pub(crate) const LIMB_LENGTH_M: std::ops::RangeInclusive<f64> = 0.05..=0.8;

/// A unit of length that meshes are exported in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LengthUnit {
    /// m
    Metre,
    /// mm
    Millimetre,
    /// cm
    Centimetre,
    /// in
    Inch,
}

impl LengthUnit {
    /// All units, the likeliest first.
    pub const ALL: [Self; 4] = [Self::Metre, Self::Millimetre, Self::Centimetre, Self::Inch];

    /// The unit's length, m.
    #[must_use]
    pub fn metres(self) -> f64 {
        match self {
            Self::Metre => 1.0,
            Self::Millimetre => 1e-3,
            Self::Centimetre => 1e-2,
            // The international inch of 1959.
            Self::Inch => 0.0254,
        }
    }

    /// The usual sign: `m`, `mm`, `cm`, `in`.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Metre => "m",
            Self::Millimetre => "mm",
            Self::Centimetre => "cm",
            Self::Inch => "in",
        }
    }
}

impl fmt::Display for LengthUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.symbol())
    }
}

/// The units in which a surface would be as long as a limb, 0.05 to 0.8 m.
///
/// A guess to be confirmed by someone who knows the limb: ranges overlap (60 units may be
/// millimetres or centimetres), and a part of another machine may have any length.
#[derive(Clone, Debug, PartialEq)]
pub struct UnitGuess {
    /// The longest edge of the bounding box, in the file's unit.
    pub longest: f64,
    /// The units that fit, the likeliest first; empty when none does.
    pub candidates: Vec<LengthUnit>,
}

impl UnitGuess {
    /// The guess for a surface whose bounding box is `longest` units long.
    #[must_use]
    pub fn of_length(longest: f64) -> Self {
        let fits = |unit: &LengthUnit| LIMB_LENGTH_M.contains(&(longest * unit.metres()));
        Self { longest, candidates: LengthUnit::ALL.into_iter().filter(fits).collect() }
    }

    /// The only unit that fits, or nothing when none or several do.
    #[must_use]
    pub fn only(&self) -> Option<LengthUnit> {
        match self.candidates[..] {
            [unit] => Some(unit),
            _ => None,
        }
    }
}

impl fmt::Display for UnitGuess {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.4} units long: ", self.longest)?;
        if self.candidates.is_empty() {
            return f.write_str("not a limb's length in m, mm, cm or in; state the unit");
        }
        for (i, unit) in self.candidates.iter().enumerate() {
            let separator = if i == 0 { "" } else { " or " };
            write!(f, "{separator}{unit} ({:.3} m)", self.longest * unit.metres())?;
        }
        f.write_str(" fits a limb; confirm the unit")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use LengthUnit::*;

    #[track_caller]
    fn check(longest: f64, expected: &[LengthUnit]) {
        assert_eq!(UnitGuess::of_length(longest).candidates, expected, "{longest}");
    }

    #[test]
    fn lengths_and_the_units_that_fit() {
        check(0.123, &[Metre]);
        check(122.4, &[Millimetre]);
        check(67.0, &[Millimetre, Centimetre]);
        check(40.0, &[Centimetre]);
        check(12.0, &[Centimetre, Inch]);
        check(4.8, &[Inch]);
        check(1.5, &[]);
        check(0.0, &[]);
        check(5000.0, &[]);
    }

    #[test]
    fn several_candidates_are_no_answer() {
        assert_eq!(UnitGuess::of_length(67.0).only(), None);
        assert_eq!(UnitGuess::of_length(0.2).only(), Some(Metre));
        assert_eq!(
            UnitGuess::of_length(67.0).to_string(),
            "67.0000 units long: mm (0.067 m) or cm (0.670 m) fits a limb; confirm the unit"
        );
    }
}
