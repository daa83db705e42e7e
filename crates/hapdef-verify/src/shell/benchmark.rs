//! A benchmark that both kinds of shell can be put to.

use std::rc::Rc;

use hapdef_sim::ShellKind;

use super::grid::{Mesh, Pattern};
use crate::{Case, KnownMiss, Measured, Reference, Target, VerifyError};

/// The value of a kind on a mesh.
pub(super) type Solve = Rc<dyn Fn(ShellKind, Mesh) -> Result<Measured, VerifyError>>;

/// What a case is, but for the kind of shell.
#[derive(Clone)]
pub(super) struct Benchmark {
    /// The ids of the thin and the thick kind, see [`ids!`].
    pub(super) ids: [&'static str; 2],
    pub(super) title: &'static str,
    pub(super) quantity: &'static str,
    pub(super) unit: &'static str,
    pub(super) reference: Reference,
    pub(super) source: &'static str,
    pub(super) target: Target,
    /// [`Mesh::n`] of each level.
    pub(super) n: &'static [usize],
    /// The value of a level is that of the pattern furthest from the reference.
    pub(super) patterns: &'static [Pattern],
    pub(super) solve: Solve,
}

/// The ids `shell.thin.…` and `shell.thick.…`.
macro_rules! ids {
    ($name:literal) => {
        [concat!("shell.thin.", $name), concat!("shell.thick.", $name)]
    };
}
pub(super) use ids;

impl Benchmark {
    /// A case for both kinds.
    pub(super) fn both(&self) -> Vec<Case> {
        vec![self.case(ShellKind::Thin), self.case(ShellKind::Thick)]
    }

    /// A case for each kind, which is known to miss its target by `rel_err` where that is given.
    pub(super) fn missed(&self, rel_err: [Option<f64>; 2], why: &'static str) -> Vec<Case> {
        let miss = |(case, rel_err): (Case, Option<f64>)| Case {
            known_miss: rel_err.map(|rel_err| KnownMiss { rel_err, why }),
            ..case
        };
        self.both().into_iter().zip(rel_err).map(miss).collect()
    }

    /// The case of one kind.
    pub(super) fn case(&self, kind: ShellKind) -> Case {
        let thick = usize::from(kind == ShellKind::Thick);
        let this = self.clone();
        Case {
            id: self.ids[thick],
            title: self.title,
            element: ["thin shell", "thick shell"][thick],
            quantity: self.quantity,
            unit: self.unit,
            reference: self.reference,
            source: self.source,
            target: self.target,
            known_miss: None,
            n_levels: self.n.len(),
            run: Box::new(move |level| this.worst(kind, this.n[level])),
        }
    }

    /// The value of the pattern furthest from the reference.
    fn worst(&self, kind: ShellKind, n: usize) -> Result<Measured, VerifyError> {
        let mut worst: Option<(f64, Measured)> = None;
        for &pattern in self.patterns {
            let measured = (self.solve)(kind, Mesh { n, pattern })?;
            let apart = self.reference.rel_err(measured.value).unwrap_or(0.0);
            // a value that is not a number is the worst
            if worst.as_ref().is_none_or(|(w, _)| apart.is_nan() || apart > *w) {
                worst = Some((apart, measured));
            }
        }
        let worst = worst.map(|(_, measured)| measured);
        worst.ok_or_else(|| VerifyError::not_run("the case has no mesh"))
    }
}
