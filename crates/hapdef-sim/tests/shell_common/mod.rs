//! Shell benchmark problems and their meshes.
#![allow(dead_code, reason = "each test uses a part")]
#![expect(clippy::unwrap_used, reason = "a broken benchmark must stop its test")]

pub mod beams;
pub mod grid;
pub mod irregular;
pub mod problem;
pub mod shells;

use hapdef_sim::ShellKind;

/// How a benchmark is meshed.
#[derive(Clone, Copy, Debug)]
pub struct Mesh {
    /// Cells along the shortest direction that the case divides.
    pub n: usize,
    pub pattern: Pattern,
}

/// Where the diagonals run, and whether nodes are moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pattern {
    Up,
    Down,
    /// Inner nodes moved by up to 0.18 of a cell, diagonals alternating.
    Distorted,
}

/// One row of the table.
#[derive(Clone, Debug)]
pub struct CaseResult {
    pub value: f64,
    pub reference: f64,
    pub n_nodes: usize,
}

impl CaseResult {
    pub fn ratio(&self) -> f64 {
        self.value / self.reference
    }
}

pub type Case = fn(ShellKind, Mesh) -> CaseResult;
