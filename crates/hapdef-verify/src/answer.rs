//! Elements, references, targets, and what a mesh gives.

use hapdef_sim::ShellKind;

/// An element of the solver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Element {
    /// The ten-node tetrahedron.
    #[default]
    Tet10,
    /// The same, beside another program's.
    C3d10,
    /// The triangular shell without transverse shear.
    ThinShell,
    /// The triangular shell with it.
    ThickShell,
}

/// What a case's value is compared with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reference {
    /// An exact value: the observed order comes from errors against it.
    Exact(f64),
    /// A published value of some digits: the observed order comes from the differences between
    /// three meshes, since the last digit's rounding would spoil errors.
    Published(f64),
    /// The value is itself a relative error and should be zero.
    Zero,
    /// Nothing: the value is reported, not judged, such as a time ratio. It depends on the machine and
    /// stays out of the committed file.
    Reported,
}

/// What counts as met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Largest relative error allowed on the finest mesh.
    pub rel_err: f64,
    /// Smallest observed order allowed between the two finest meshes; none asks for none.
    pub order: Option<f64>,
}

/// A target that is missed for a known reason.
///
/// The case fails once it meets its target, so that the mark goes, and when its error grows beyond
/// the one recorded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnownMiss {
    /// Relative error on the finest mesh when the miss was recorded.
    pub rel_err: f64,
    /// Why it is missed.
    pub why: &'static str,
}

/// What one mesh gave.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// The quantity, in the case's unit.
    pub value: f64,
    /// The mesh in a few words, such as `12 × 4 × 2 cells`.
    pub mesh: String,
    /// Nodes of the mesh.
    pub n_nodes: usize,
    /// Equations solved.
    pub n_equations: usize,
    /// Element size on any scale; only ratios between levels count.
    pub h: f64,
}

impl Element {
    /// In words.
    pub fn word(self) -> &'static str {
        match self {
            Self::Tet10 => "TET10",
            Self::C3d10 => "C3D10",
            Self::ThinShell => "thin shell",
            Self::ThickShell => "thick shell",
        }
    }

    /// What the ids of its cases begin with.
    pub(crate) fn family(self) -> &'static str {
        match self {
            Self::Tet10 | Self::C3d10 => "solid",
            Self::ThinShell => "shell.thin",
            Self::ThickShell => "shell.thick",
        }
    }

    /// The bending theory of a shell.
    pub(crate) fn shell_kind(self) -> ShellKind {
        match self {
            Self::ThinShell => ShellKind::Thin,
            _ => ShellKind::Thick,
        }
    }
}

impl Target {
    /// A relative error on the finest mesh, and no order.
    pub fn within(rel_err: f64) -> Self {
        Self { rel_err, order: None }
    }

    /// The same with an observed order of at least `order`.
    pub fn and_order(self, order: f64) -> Self {
        Self { order: Some(order), ..self }
    }
}

impl Reference {
    /// The reference value; none where there is none.
    pub fn value(self) -> Option<f64> {
        match self {
            Self::Exact(r) | Self::Published(r) => Some(r),
            Self::Zero => Some(0.0),
            Self::Reported => None,
        }
    }

    /// The relative error of `value`; none where nothing is compared.
    pub fn rel_err(self, value: f64) -> Option<f64> {
        match self {
            Self::Exact(r) | Self::Published(r) => Some((value - r).abs() / r.abs()),
            Self::Zero => Some(value.abs()),
            Self::Reported => None,
        }
    }
}
