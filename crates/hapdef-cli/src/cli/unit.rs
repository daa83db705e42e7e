//! Units of length on the command line.

use clap::ValueEnum;
use hapdef_mesh::LengthUnit;

/// The unit of a file's coordinates.
#[derive(Clone, Copy, ValueEnum)]
pub(super) enum Unit {
    M,
    Mm,
    Cm,
    In,
}

impl From<Unit> for LengthUnit {
    fn from(unit: Unit) -> Self {
        match unit {
            Unit::M => Self::Metre,
            Unit::Mm => Self::Millimetre,
            Unit::Cm => Self::Centimetre,
            Unit::In => Self::Inch,
        }
    }
}
