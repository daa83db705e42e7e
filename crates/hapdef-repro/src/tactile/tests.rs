//! The baselines and a net on a real tactile skin, against the figures of a reference that nobody
//! here made: scikit-learn on the same presses.

use std::path::PathBuf;

use hapdef_nets::{Activation, TrainParams};

use super::methods::tactile_distances_mm;
use super::{TactileRun, numpy_permutations, read_tactile_runs, tactile_folder};
use crate::baselines::LinearParams;
use crate::search::{Learner, NetSettings};

/// Both runs with the reference's order of presses; none, with the reason printed, where the
/// shared inputs are absent.
fn runs() -> Option<Vec<(TactileRun, Vec<usize>)>> {
    let shared = std::env::var_os("HAPDEF_SHARED").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared")),
        PathBuf::from,
    );
    let folder = tactile_folder(&shared);
    if !folder.exists() {
        println!("skipped: {} is absent; set HAPDEF_SHARED", folder.display());
        return None;
    }
    let runs = read_tactile_runs(&folder).unwrap();
    let sizes: Vec<usize> = runs.iter().map(TactileRun::n).collect();
    let orders = numpy_permutations(0, &sizes);
    Some(runs.into_iter().zip(orders).collect())
}

fn mean_mm(run: &TactileRun, order: &[usize], learner: &Learner) -> f64 {
    let (train, test) = order.split_at(order.len() * 4 / 5);
    let distances = tactile_distances_mm(run, learner, train, test).unwrap();
    distances.iter().sum::<f64>() / distances.len() as f64
}

#[test]
fn nearest_neighbours_and_linear_regression_reach_the_references_figures() {
    let linear = Learner::Linear(LinearParams::default());
    let expected = [(0.95, 4.22), (0.39, 1.87)];
    for ((run, order), (knn_mm, linear_mm)) in runs().into_iter().flatten().zip(expected) {
        let found = [mean_mm(&run, &order, &Learner::Knn { k: 6 }), mean_mm(&run, &order, &linear)];
        println!("{}: k-NN {:.4} mm, LR {:.4} mm", run.name, found[0], found[1]);
        for (found, expected) in found.into_iter().zip([knn_mm, linear_mm]) {
            assert!(
                (found / expected - 1.0).abs() < 0.02,
                "{}: {found} mm, the reference has {expected} mm",
                run.name
            );
        }
    }
}

#[test]
fn a_net_beats_nearest_neighbours() {
    let net = Learner::Net(NetSettings {
        hidden: vec![128; 3],
        activation: Activation::Tanh,
        training: TrainParams {
            steps: 2500,
            batch: 100,
            learning_rate: 2e-3,
            final_learning_rate: Some(2e-5),
            ..TrainParams::paper(0)
        },
    });
    for (run, order) in runs().into_iter().flatten() {
        let knn_mm = mean_mm(&run, &order, &Learner::Knn { k: 6 });
        let net_mm = mean_mm(&run, &order, &net);
        println!("{}: net {net_mm:.4} mm, k-NN {knn_mm:.4} mm", run.name);
        assert!(net_mm < knn_mm, "{}: net {net_mm} mm, k-NN {knn_mm} mm", run.name);
    }
}
