//! Training in the modes of the outputs, and the way back to all of them.

use std::path::Path;

use hapdef_nets::train::{BatchSource, OutputModes, TrainInfo};
use hapdef_nets::{Net, Scale, load, save};

use super::nets::CHECKPOINT_FILE;
use crate::error::HapdefError;

/// Folder of the net of coordinates while it is trained.
const COORDINATES: &str = "coordinates";

/// Samples that the modes are found with.
const MODE_SAMPLES: usize = 4096;

/// Trains a net of `rank` coordinates of the outputs by `fit` and unfolds it into `dir`. `fit` gets the
/// net's checkpoint, its scales, the modes, for a validation, and the samples with their outputs in modes.
pub(super) fn train_in_modes(
    dir: &Path,
    rank: usize,
    [input, output]: [Scale; 2],
    samples: &mut dyn BatchSource,
    fit: impl FnOnce(
        &Path,
        [Scale; 2],
        &OutputModes,
        &mut dyn BatchSource,
    ) -> Result<(TrainInfo, Net), HapdefError>,
) -> Result<(TrainInfo, Net), HapdefError> {
    let rows = mode_rows(samples);
    let modes = OutputModes::of_samples(samples, &rows, &output, rank)?;
    let folder = dir.join(COORDINATES);
    let file_error = |source| HapdefError::File { path: folder.clone(), source };
    std::fs::create_dir_all(&folder).map_err(file_error)?;
    let checkpoint = folder.join(CHECKPOINT_FILE);
    let scales = [input, Scale::identity(rank)];
    let (info, net) = fit(&checkpoint, scales, &modes, &mut modes.source(samples))?;
    let net = modes.unfold(&net)?;
    if !info.stopped_early {
        let record = load(&checkpoint)?.1;
        save(&dir.join(CHECKPOINT_FILE), &net, &record, None)?;
        std::fs::remove_dir_all(&folder).map_err(file_error)?;
    }
    Ok((info, net))
}

/// Samples spread over all there are, or the first of an endless source.
fn mode_rows(samples: &dyn BatchSource) -> Vec<usize> {
    if samples.is_endless() {
        return (0..MODE_SAMPLES).collect();
    }
    let n = samples.n_samples();
    (0..n).step_by(n.div_ceil(MODE_SAMPLES)).collect()
}
