//! k-Max on fields and points at their extremes.

use hapdef_kmax::{KMaxGraph, KMaxParams, Peak};

use crate::error::ReproError;
use crate::robustness::table::Trials;

/// Points along each side of the plate, and the gap between them, m.
const SIDE: usize = 20;
const GAP_M: f64 = 0.004;

/// Nodes that are peaks of the field with two hills.
const HILLS: [usize; 2] = [5 + SIDE * 5, 14 + SIDE * 12];

pub(super) fn add(rows: &mut Trials<u64>) {
    let tops = ("peaks that are not the hills' tops", 0.0);
    for scale in [1e-38_f32, 1e-6, 1.0, 1e6, 1e38] {
        let extreme = format!("two hills of {scale:e} µm");
        rows.accurate(extreme, tops, move |_| wrong_peaks(GAP_M, &hills(scale), 0.0));
    }
    for gap_m in [1e-9, 1e-3, 1e6] {
        let extreme = format!("points {gap_m:e} m apart");
        rows.accurate(extreme, tops, move |_| wrong_peaks(gap_m, &hills(1.0), 0.0));
    }
    type Field = (&'static str, &'static str, f64, fn() -> Vec<f32>, f32);
    let fields: [Field; 4] = [
        ("a field of NaN", "peaks", 0.0, || vec![f32::NAN; SIDE * SIDE], 0.0),
        ("a field of 0", "peaks", 0.0, || vec![0.0; SIDE * SIDE], 0.0),
        ("a floor of NaN", "peaks", 0.0, || hills(1.0), f32::NAN),
        (
            "one value everywhere",
            "peaks more or less than one",
            1.0,
            || vec![3.0; SIDE * SIDE],
            0.0,
        ),
    ];
    for (extreme, must_hold, n, make, floor) in fields {
        rows.accurate(extreme, (must_hold, 0.0), move |_| {
            Ok((peaks(GAP_M, &make(), floor)?.len() as f64 - n).abs())
        });
    }
    rows.accurate("NaN and infinities beside the hills", tops, |_| {
        let mut field = hills(1.0);
        (field[HILLS[0] + 1], field[HILLS[1] - 1]) = (f32::NAN, f32::INFINITY);
        wrong_peaks(GAP_M, &field, 0.0)
    });
    rows.all_refused([
        ("one point", "1 points", || graph_of(&[[0.0; 3]])),
        ("a point is NaN", "point 1", || graph_of(&[[0.0; 3], [f64::NAN; 3], [1.0; 3]])),
        ("a radius of 0", "radius", || {
            Ok(KMaxParams::spanning_radius(&plate(GAP_M), 0.0)?.k_neighbours as f64)
        }),
        ("a field of another length", "field", || Ok(peaks(GAP_M, &[1.0], 0.0)?.len() as f64)),
    ]);
}

fn graph_of(points: &[[f64; 3]]) -> Result<f64, ReproError> {
    let params = KMaxParams { k_neighbours: 1 };
    Ok(KMaxGraph::new(points, params)?.n_nodes() as f64)
}

fn plate(gap_m: f64) -> Vec<[f64; 3]> {
    let at = |i: usize| [(i % SIDE) as f64 * gap_m, (i / SIDE) as f64 * gap_m, 0.0];
    (0..SIDE * SIDE).map(at).collect()
}

/// Two bells, the second half as high.
fn hills(scale: f32) -> Vec<f32> {
    let bell = |i: usize, top: usize| {
        let along = (i % SIDE).abs_diff(top % SIDE) as f32;
        let across = (i / SIDE).abs_diff(top / SIDE) as f32;
        (-(along * along + across * across) / 8.0).exp()
    };
    let value = |i: usize| scale * (bell(i, HILLS[0]) + 0.5 * bell(i, HILLS[1]));
    (0..SIDE * SIDE).map(value).collect()
}

fn peaks(gap_m: f64, field: &[f32], floor: f32) -> Result<Vec<Peak>, ReproError> {
    let graph = KMaxGraph::new(&plate(gap_m), KMaxParams { k_neighbours: 20 })?;
    let mut found = Vec::new();
    graph.peaks(field, floor, &mut found)?;
    Ok(found)
}

fn wrong_peaks(gap_m: f64, field: &[f32], floor: f32) -> Result<f64, ReproError> {
    let found = peaks(gap_m, field, floor)?;
    let missing = HILLS.iter().filter(|top| found.iter().all(|p| p.node != **top));
    let further = found.iter().filter(|p| !HILLS.contains(&p.node));
    Ok((missing.count() + further.count()) as f64)
}
