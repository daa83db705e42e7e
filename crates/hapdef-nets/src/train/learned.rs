//! Whether a training came to anything.

use crate::checkpoint::TrainRecord;
use crate::error::NetsError;
use crate::mlp::Mlp;
use crate::net::Net;
use crate::train::batch::Batch;
use crate::train::loss::sum_of_squares;
use crate::train::network::Network;
use crate::train::source::BatchSource;

/// Fewer steps are a trial run, of which nothing is asked.
const LEAST_STEPS: u64 = 100;

/// Most training samples that are looked at, evenly over a pass.
const MOST_SAMPLES: usize = 512;

/// Samples that pass the network together.
const TOGETHER: usize = 256;

/// A net must come below this share of the √MSE of the means: trainings that are far too fast or hardly
/// move end at or above it (`a_training_that_learns_nothing_is_refused`).
const LARGEST_SHARE: f64 = 0.999;

/// Fails where the weights `mlp` between the scales of `net` are no better on training samples than
/// every output's mean. Outputs that never varied don't count.
pub(super) fn check_learned(
    net: &Net,
    mlp: &Mlp,
    samples: &mut dyn BatchSource,
    record: &TrainRecord,
) -> Result<(), NetsError> {
    if record.step < LEAST_STEPS {
        return Ok(());
    }
    let varies: Vec<bool> = net.output_scale().std().iter().map(|s| *s > 0.0).collect();
    let mut network = Network::new(mlp);
    let (mut batch, mut missed, mut spread) = (Batch::default(), 0.0, 0.0);
    let rows = some_rows(samples);
    for rows in rows.chunks(TOGETHER) {
        batch.rows.clear();
        batch.rows.extend(rows);
        let (x, y) = batch.load(samples, net, record.step)?;
        spread += sum_of_squares(y);
        let found = network.predict(x);
        for (found, y) in found.chunks_mut(varies.len()).zip(y.chunks(varies.len())) {
            for ((found, y), varies) in found.iter_mut().zip(y).zip(&varies) {
                *found = if *varies { *found - y } else { 0.0 };
            }
        }
        missed += sum_of_squares(found);
    }
    let n = rows.len() * varies.iter().filter(|varies| **varies).count();
    let root_mean = |sum: f64| (sum / n as f64).sqrt();
    let (after, of_means) = (root_mean(missed), root_mean(spread));
    if spread <= 0.0 || after < LARGEST_SHARE * of_means {
        return Ok(());
    }
    Err(NetsError::NothingLearned {
        steps: record.step,
        learning_rate: record.params.learning_rate,
        after,
        of_means,
    })
}

fn some_rows(samples: &dyn BatchSource) -> Vec<usize> {
    let n_all = samples.n_samples();
    let n = n_all.min(MOST_SAMPLES);
    (0..n).map(|i| i * n_all / n).collect()
}
