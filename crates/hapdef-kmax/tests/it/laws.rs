//! Laws of k-Max that hold for any points and any field.

use hapdef_kmax::{KMaxError, KMaxGraph, KMaxParams, Peak};
use proptest::prelude::*;

fn graph(points: &[[f64; 3]], k_neighbours: usize) -> KMaxGraph {
    KMaxGraph::new(points, KMaxParams { k_neighbours }).unwrap()
}

fn peaks(graph: &KMaxGraph, field: &[f32], floor: f32) -> Vec<Peak> {
    let mut out = vec![];
    graph.peaks(field, floor, &mut out).unwrap();
    out
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

/// A square sheet of n × n points, 1 mm apart.
fn sheet(n: usize) -> Vec<[f64; 3]> {
    (0..n * n).map(|i| [(i % n) as f64 * 1e-3, (i / n) as f64 * 1e-3, 0.0]).collect()
}

fn cloud() -> impl Strategy<Value = Vec<[f64; 3]>> {
    prop::collection::vec(prop::array::uniform3(-0.1..0.1f64), 12..60)
}

/// Few distinct levels, so that ties and plateaus are common, and now and then a NaN.
fn levels(n: usize) -> impl Strategy<Value = Vec<f32>> {
    prop::collection::vec(
        prop_oneof![9 => (0..6i32).prop_map(|v| v as f32), 1 => Just(f32::NAN)],
        n,
    )
}

/// A cloud with one random, distinct value per point.
fn cloud_with_distinct_values() -> impl Strategy<Value = (Vec<[f64; 3]>, Vec<f32>)> {
    cloud().prop_flat_map(|points| {
        let ranks: Vec<f32> = (1..=points.len()).map(|i| i as f32).collect();
        (Just(points), Just(ranks).prop_shuffle())
    })
}

/// The definition, by brute force: strictly above the floor, no larger value among the k nearest.
fn brute_force(points: &[[f64; 3]], field: &[f32], k: usize) -> Vec<usize> {
    let is_peak = |i: usize| {
        let mut others: Vec<usize> = (0..points.len()).filter(|&j| j != i).collect();
        others.sort_by(|&a, &b| {
            distance(points[i], points[a]).total_cmp(&distance(points[i], points[b]))
        });
        others[..k].iter().all(|&j| field[j] < field[i])
    };
    (0..points.len()).filter(|&i| is_peak(i)).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn agrees_with_the_definition((points, field) in cloud_with_distinct_values(), k in 1..11usize) {
        let mut found: Vec<_> = peaks(&graph(&points, k), &field, 0.0).iter().map(|p| p.node).collect();
        found.sort_unstable();
        prop_assert_eq!(found, brute_force(&points, &field, k));
    }

    #[test]
    fn no_neighbour_of_a_peak_is_larger(
        (points, field) in cloud().prop_flat_map(|p| { let n = p.len(); (Just(p), levels(n)) }),
        k in 1..11usize,
    ) {
        let graph = graph(&points, k);
        let found = peaks(&graph, &field, 0.0);
        for peak in &found {
            prop_assert!(field[peak.node] == peak.value && peak.value > 0.0);
            for j in graph.neighbours(peak.node) {
                prop_assert!(field[j].is_nan() || field[j] <= peak.value, "{peak:?}, neighbour {j}");
            }
        }
        prop_assert!(found.is_sorted_by(|a, b| a.value >= b.value));
        let top = field.iter().copied().filter(|v| v.is_finite()).fold(0.0, f32::max);
        if top > 0.0 {
            prop_assert_eq!(found[0].value, top, "the largest value of all is always a peak");
        }
    }

    #[test]
    fn reordering_the_nodes_reorders_the_peaks(
        (points, field, order) in cloud_with_distinct_values().prop_flat_map(|(p, f)| {
            let order: Vec<usize> = (0..p.len()).collect();
            (Just(p), Just(f), Just(order).prop_shuffle())
        }),
        k in 1..11usize,
    ) {
        let reordered_points: Vec<_> = order.iter().map(|&i| points[i]).collect();
        let reordered_field: Vec<_> = order.iter().map(|&i| field[i]).collect();
        let found = peaks(&graph(&points, k), &field, 0.0);
        let reordered = peaks(&graph(&reordered_points, k), &reordered_field, 0.0);
        let back: Vec<_> = reordered.iter().map(|p| order[p.node]).collect();
        prop_assert_eq!(found.iter().map(|p| p.node).collect::<Vec<_>>(), back);
    }

    #[test]
    fn scale_of_the_field_and_of_the_points_does_not_matter(
        (points, field) in cloud_with_distinct_values(), k in 1..11usize, power in -20..20i32,
    ) {
        let nodes = |points: &[[f64; 3]], field: &[f32], floor| -> Vec<usize> {
            peaks(&graph(points, k), field, floor).iter().map(|p| p.node).collect()
        };
        let factor = 2f32.powi(power);
        let scaled_field: Vec<_> = field.iter().map(|v| v * factor).collect();
        let scaled_points: Vec<_> = points.iter().map(|p| p.map(|x| x * f64::from(factor))).collect();
        prop_assert_eq!(
            nodes(&points, &field, 3.0),
            nodes(&scaled_points, &scaled_field, 3.0 * factor)
        );
    }

    #[test]
    fn one_bump_gives_one_peak(centre in prop::array::uniform2(0.0..0.019f64)) {
        let points = sheet(20);
        let top = [centre[0], centre[1], 0.0];
        let field: Vec<f32> = points.iter().map(|p| (-(distance(*p, top) / 5e-3).powi(2)).exp() as f32).collect();
        let found = peaks(&graph(&points, 8), &field, 1e-9);
        prop_assert_eq!(found.len(), 1);
        prop_assert!(distance(points[found[0].node], top) < 0.8e-3, "{:?}", found);
    }

    #[test]
    fn every_plateau_gives_one_peak(low in 0..10usize, high in 10..20usize, value in 1..5i32) {
        let (points, n) = (sheet(20), 20);
        let inside = |i: usize| (low..=high).contains(&(i % n)) && (low..=high).contains(&(i / n));
        let field: Vec<f32> = (0..n * n).map(|i| if inside(i) { value as f32 } else { 0.5 }).collect();
        let found = peaks(&graph(&points, 8), &field, 0.0);
        prop_assert_eq!(found, vec![Peak { node: low * n + low, value: value as f32 }]);
    }
}

#[test]
fn two_bumps_farther_apart_than_the_neighbourhood_give_two_peaks() {
    let points = sheet(30);
    let (a, b) = ([6e-3, 6e-3, 0.0], [22e-3, 20e-3, 0.0]);
    let bump = |p, c, width: f64| (-(distance(p, c) / width).powi(2)).exp();
    let field: Vec<f32> =
        points.iter().map(|p| (bump(*p, a, 4e-3) + 0.5 * bump(*p, b, 4e-3)) as f32).collect();
    let found = peaks(&graph(&points, 24), &field, 1e-3);
    let nodes: Vec<_> = found.iter().map(|p| p.node).collect();
    assert_eq!(nodes, [6 * 30 + 6, 20 * 30 + 22]);
}

#[test]
fn an_untouched_field_has_no_peak() {
    let graph = graph(&sheet(5), 4);
    assert_eq!(peaks(&graph, &[0.0; 25], 0.0), []);
    assert_eq!(peaks(&graph, &[1e-7; 25], 1e-6), []);
    assert_eq!(peaks(&graph, &[f32::NAN; 25], 0.0), []);
    assert_eq!(peaks(&graph, &[f32::INFINITY; 25], 0.0), []);
}

#[test]
fn a_missing_value_neither_leads_nor_blocks() {
    let graph = graph(&sheet(5), 8);
    let mut field = [0.1; 25];
    (field[12], field[13]) = (1.0, f32::NAN);
    assert_eq!(peaks(&graph, &field, 0.2), [Peak { node: 12, value: 1.0 }]);
}

#[test]
fn k_spans_the_radius_on_a_sheet() {
    // Inside a square grid of 1 mm, 28 other points lie within 3 mm; most of 40 × 40 are inside.
    let params = KMaxParams::spanning_radius(&sheet(40), 3.0e-3 + 1e-9).unwrap();
    assert_eq!(params.k_neighbours, 28);
}

#[test]
fn neighbours_at_the_same_distance_come_together() {
    let graph = graph(&sheet(5), 3);
    assert_eq!(graph.neighbours(12).collect::<Vec<_>>(), [7, 11, 13, 17]);
}

#[test]
fn bad_arguments_are_refused_with_their_numbers() {
    let points = sheet(2);
    let count = KMaxError::NeighbourCount { k_neighbours: 4, n_points: 4 };
    assert_eq!(KMaxGraph::new(&points, KMaxParams { k_neighbours: 4 }).unwrap_err(), count);
    assert!(KMaxGraph::new(&[], KMaxParams { k_neighbours: 1 }).is_err());
    assert!(KMaxParams::spanning_radius(&points, f64::NAN).is_err());
    let mut broken = points.clone();
    broken[3][1] = f64::NAN;
    assert!(matches!(
        KMaxGraph::new(&broken, KMaxParams { k_neighbours: 2 }),
        Err(KMaxError::PointNotFinite { index: 3, .. })
    ));
    let got = graph(&points, 2).peaks(&[0.0; 3], 0.0, &mut vec![]);
    assert_eq!(got, Err(KMaxError::FieldLength { expected: 4, got: 3 }));
}

/// A graph of the neighbours that another one lists finds what that one finds.
#[test]
fn a_graph_comes_back_from_its_neighbours() {
    let points = sheet(12);
    let whole = graph(&points, 12);
    let rows = (0..whole.n_nodes()).map(|i| whole.neighbours(i).map(|j| j as u32));
    let again = KMaxGraph::from_neighbours(rows).unwrap();
    let field: Vec<f32> = (0..144).map(|i| (i * 37 % 23) as f32).collect();
    let found = peaks(&whole, &field, 0.0);
    assert!(!found.is_empty());
    assert_eq!(peaks(&again, &field, 0.0), found);
    let stray = KMaxGraph::from_neighbours([vec![1], vec![2]]).unwrap_err();
    let expected = KMaxError::NeighbourOutOfRange { neighbour: 2, n_nodes: 2 };
    assert_eq!(stray, expected);
}
