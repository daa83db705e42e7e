//! What cases are made of.

pub(super) use crate::case::{Case, Solve};
pub(super) use crate::meshes::{Blocks, Body, Pattern, Place};
pub(super) use crate::model::On::{Where, X, Y, Z};
pub(super) use crate::model::{Load, Map, Mesh, Model, On, Probe};
pub(super) use crate::problem::Held::{All, Mirror, Only};
pub(super) use crate::problem::{Held, Problem, Solution, same};
pub(super) use crate::{Element, Measured, Reference, Target, VerifyError};
