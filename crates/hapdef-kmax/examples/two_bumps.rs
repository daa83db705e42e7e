//! Where a field is largest of its neighbourhood, and which of those places to take: two bumps with
//! ripples on them.
//!
//! `cargo run --release --example two_bumps`
//!
//! ```text
//! points → KMaxGraph (who is whose neighbour) ─┐
//! field  ──────────────────────────────────────┴→ peaks → the two largest
//! ```
#![allow(clippy::print_stdout, reason = "an example shows what it does")]

use hapdef_kmax::{Candidate, KMaxError, KMaxGraph, KMaxParams, select_top};

/// Nodes a side, 2 mm apart.
const N: usize = 41;
const SPACING_M: f64 = 2e-3;
/// Nodes of the bumps' tops: row, column.
const TOPS: [(usize, usize); 2] = [(10, 12), (28, 30)];

fn main() -> Result<(), KMaxError> {
    let (n_peaks, top) = two_bumps()?;
    println!("{n_peaks} peaks; the largest two:");
    for candidate in top {
        let (row, column) = (candidate.node / N, candidate.node % N);
        println!("row {row}, column {column}: {:.3}", candidate.score);
    }
    Ok(())
}

/// How many peaks there are within 10 mm of which nothing is larger, and the two largest.
fn two_bumps() -> Result<(usize, Vec<Candidate>), KMaxError> {
    let nodes = (0..N * N).map(|i| (i / N, i % N));
    let at = |i: usize| i as f64 * SPACING_M;
    let points: Vec<[f64; 3]> = nodes.clone().map(|(r, c)| [at(r), at(c), 0.0]).collect();
    let field: Vec<f32> = nodes.map(|(row, column)| height(row, column)).collect();

    let graph = KMaxGraph::new(&points, KMaxParams::spanning_radius(&points, 0.010)?)?;
    let mut peaks = Vec::new();
    graph.peaks(&field, 0.0, &mut peaks)?;
    let candidates = peaks.iter().map(|peak| Candidate { node: peak.node, score: peak.value });
    let top = select_top(&candidates.collect::<Vec<_>>(), TOPS.len());
    Ok((peaks.len(), top))
}

/// Two bumps 15 mm wide, the second half as high, and ripples of a five-hundredth.
fn height(row: usize, column: usize) -> f32 {
    let bump = |(r, c): (usize, usize)| {
        let (dr, dc) = (row.abs_diff(r) as f64, column.abs_diff(c) as f64);
        (-(dr * dr + dc * dc) * (SPACING_M / 0.015).powi(2)).exp()
    };
    let ripple = ((row % 3) as f64 - 1.0) * ((column % 3) as f64 - 1.0);
    (bump(TOPS[0]) + 0.5 * bump(TOPS[1]) + 0.002 * ripple) as f32
}

#[test]
fn the_two_bumps_are_found_at_their_tops() {
    let (n_peaks, top) = two_bumps().unwrap();
    let nodes: Vec<usize> = top.iter().map(|candidate| candidate.node).collect();
    assert_eq!(nodes, TOPS.map(|(row, column)| row * N + column));
    assert!(n_peaks >= 2, "{n_peaks}");
}
