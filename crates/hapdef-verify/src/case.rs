//! One problem with a known answer.

use std::rc::Rc;

use crate::model::Model;
use crate::{Element, KnownMiss, Measured, Reference, Target, VerifyError};

/// A problem, its answer, and how well it must be met.
#[derive(Clone)]
pub struct Case {
    /// Unique among the cases of its element, such as `le10`.
    pub name: &'static str,
    /// The element it is meshed with.
    pub element: Element,
    /// What an engineer calls it.
    pub title: &'static str,
    /// The quantity compared, with the place.
    pub quantity: &'static str,
    /// The unit of value and reference; "1" for none.
    pub unit: &'static str,
    /// The answer.
    pub reference: Reference,
    /// Where the answer stands: author, work, place; or the formula.
    pub source: &'static str,
    /// What counts as met; within one percent where nothing else is stated.
    pub target: Target,
    /// A miss of the target that is known and accepted; none for a case that meets it.
    pub known_miss: Option<KnownMiss>,
    /// Cells of the meshes in sequence, coarse to fine.
    pub meshes: &'static [[usize; 3]],
    /// How it is solved.
    pub(crate) solve: Solve,
}

/// How a case is solved.
#[derive(Clone)]
pub(crate) enum Solve {
    /// Models on all their patterns; the value is the one furthest from the reference.
    Models(Vec<Model>),
    /// Anything else, from the cells of a mesh.
    Other(Rc<dyn Fn(Element, [usize; 3]) -> Result<Measured, VerifyError>>),
}

impl Default for Case {
    fn default() -> Self {
        Self {
            name: "",
            element: Element::Tet10,
            title: "",
            quantity: "",
            unit: "1",
            reference: Reference::Zero,
            source: "",
            target: Target::within(0.01),
            known_miss: None,
            meshes: &[[1; 3]],
            solve: Solve::Models(Vec::new()),
        }
    }
}

impl Case {
    /// Dotted and unique, such as `solid.le10`.
    pub fn id(&self) -> String {
        format!("{}.{}", self.element.family(), self.name)
    }

    /// The case for both kinds of shell.
    pub(crate) fn both(self) -> [Self; 2] {
        [Element::ThinShell, Element::ThickShell].map(|element| Self { element, ..self.clone() })
    }

    /// The case for both kinds of shell, which is known to miss its target by `rel_err` where that is
    /// given.
    pub(crate) fn both_missed(self, rel_err: [Option<f64>; 2], why: &'static str) -> [Self; 2] {
        let mut cases = self.both();
        for (case, rel_err) in cases.iter_mut().zip(rel_err) {
            case.known_miss = rel_err.map(|rel_err| KnownMiss { rel_err, why });
        }
        cases
    }

    /// Solves the problem on mesh `level` of its sequence.
    pub(crate) fn measure(&self, level: usize) -> Result<Measured, VerifyError> {
        let n = self.meshes[level];
        let models = match &self.solve {
            Solve::Other(solve) => return solve(self.element, n),
            Solve::Models(models) => models,
        };
        let mut worst: Option<(f64, Measured)> = None;
        for model in models {
            for &pattern in model.patterns() {
                let measured = model.measure(self.element, n, pattern)?;
                let apart = self.reference.rel_err(measured.value).unwrap_or(0.0);
                // a value that is not a number is the worst
                if worst.as_ref().is_none_or(|(w, _)| apart.is_nan() || apart > *w) {
                    worst = Some((apart, measured));
                }
            }
        }
        let worst = worst.map(|(_, measured)| measured);
        worst.ok_or_else(|| VerifyError::not_run("the case has no model"))
    }
}

impl Solve {
    /// One model.
    pub(crate) fn of(model: Model) -> Self {
        Self::Models(vec![model])
    }

    /// Anything else.
    pub(crate) fn by(
        solve: impl Fn(Element, [usize; 3]) -> Result<Measured, VerifyError> + 'static,
    ) -> Self {
        Self::Other(Rc::new(solve))
    }
}
