//! Figure 5A: map error against the number of virtual gauges around each gauge.
//!
//! For each size F_R is trained briefly on the simulated sets, in the profile's modes of the map, and
//! F_T is linear regression, k nearest neighbours or a net, on single presses. A compliance table with the largest patches
//! serves every size, as the smaller are the beginnings of the larger.

mod source;

use std::cell::LazyCell;
use std::ops::Range;

use anyhow::{Context, Result};
use hapdef::stages::compliance;
use hapdef::{ComplianceTable, DrawnContact, Limb, MapError, MapErrorSum, Pipeline, Run, Stage};
use hapdef_nets::{MlpSpec, Net};
use serde::{Deserialize, Serialize};
use serde_json::json;

use self::source::{Patches, SuperposedSource};
use super::dataset::{Dataset, Rows, rig_singles};
use super::fit::{Training, fit};
use super::kept::kept;
use crate::baselines::LinearParams;
use crate::search::{Fitted, Learner, forward};

const VERSION: u32 = 4;

/// Virtual gauges around each gauge, full and quick profile.
const SIZES: [usize; 11] = [1, 2, 4, 8, 12, 16, 24, 32, 40, 50, 60];
const QUICK_SIZES: [usize; 4] = [1, 8, 24, 60];

/// One in so many of the profile's single samples is the most presses of a test set.
const TEST_SHARE: usize = 20;

/// Presses computed together.
const BLOCK: usize = 250;

/// The methods for F_T, in the order of [`SizePoint::errors`].
pub(crate) const METHODS: [&str; 3] = ["LR", "k-NN", "FNN"];

/// Errors at one size.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(crate) struct SizePoint {
    /// Virtual gauges around each gauge.
    pub(crate) size: usize,
    /// Single and double presses for each of [`METHODS`].
    pub(crate) errors: [[MapError; 2]; 3],
}

/// Errors at every size, and the stages that made them.
pub(crate) fn sweep(run: &Run, done: &Pipeline) -> Result<(Vec<SizePoint>, Vec<Stage>)> {
    let sizes: &[usize] = match run.profile.name.as_str() {
        "quick" => &QUICK_SIZES,
        _ => &SIZES,
    };
    let (wide, limb, stage) = widest(run, sizes)?;
    let key = stage.key.clone();
    let mut stages = vec![stage];
    let mut points = vec![];
    let path = stages[0].dir.join("compliance.safetensors");
    let table = LazyCell::new(|| ComplianceTable::read(&path, limb.n_surface_nodes()));
    for &size in sizes.iter().filter(|size| **size <= wide.scene.gauges.patch_nodes) {
        run.check_stop("figure 5A")?;
        let trainings = [in_modes(run), Training::transfer(run)];
        let inputs = json!({
            "version": VERSION, "limb": key, "size": size, "trainings": trainings,
            "keys": super::keys_of(run, done), "doubles": doubles(done)?.key,
        });
        let (point, stage) = kept(run, "patch-size", &inputs, |_| {
            let table = table.as_ref().map_err(|error| anyhow::anyhow!("{error}"))?;
            let patches = Patches::new(table, limb.gauges.len(), size);
            AtSize { run, done, patches, key: &key }.point()
        })?;
        points.push(point);
        stages.push(stage);
    }
    Ok((points, stages))
}

/// A brief training of F_R in the profile's modes of the map.
fn in_modes(run: &Run) -> Training {
    let (scale, modes) = (run.profile.output_scale, run.profile.output_modes);
    Training { scale, modes, ..Training::reconstruction(run) }
}

fn doubles(done: &Pipeline) -> Result<&Stage> {
    let data = done.data.as_ref().context("no datasets")?;
    data.rig_double.as_ref().context("no double presses")
}

/// The scene with the largest patches that the limb has room for.
fn widest(run: &Run, sizes: &[usize]) -> Result<(Run, Limb, Stage)> {
    let mut refused = None;
    for &size in sizes.iter().rev() {
        let mut scene = run.scene.clone();
        scene.gauges.patch_nodes = size;
        match Limb::load(&scene, &run.scene_dir) {
            Ok(limb) => {
                let wide = Run { scene, ..run.clone() };
                let stage = compliance(&wide, &limb)?;
                return Ok((wide, limb, stage));
            }
            Err(error) => refused = Some(error),
        }
    }
    Err(refused.map_or_else(|| anyhow::anyhow!("no patch size to try"), Into::into))
}

/// Everything at one size.
struct AtSize<'a> {
    run: &'a Run,
    done: &'a Pipeline,
    patches: Patches<'a>,
    key: &'a str,
}

impl AtSize<'_> {
    fn point(&self) -> Result<SizePoint> {
        let size = self.patches.size;
        let data = self.done.data.as_ref().context("no datasets")?;
        let keys: Vec<&str> = data.simulated.iter().map(|s| s.key.as_str()).collect();
        let of = json!({ "limb": self.key, "size": size, "sets": keys });
        let (map_net, _) = fit(
            self.run,
            &format!("F_R for {size} virtual gauges"),
            &of,
            &in_modes(self.run),
            MlpSpec::reconstruction,
            || Ok(SuperposedSource::new(self.patches, training_contacts(self.done)?)),
        )?;
        let (mut singles, split) = rig_singles(self.done)?;
        let transfers = self.transfers(&mut singles, split.train)?;
        let mut doubles = Dataset::open(doubles(self.done)?)?;
        let all = 0..doubles.n();
        let on_singles = self.errors(&mut singles, split.test, &transfers, &map_net)?;
        let on_doubles = self.errors(&mut doubles, all, &transfers, &map_net)?;
        Ok(SizePoint {
            size,
            errors: std::array::from_fn(|method| [on_singles[method], on_doubles[method]]),
        })
    }

    /// Map error of each of [`METHODS`] over presses spread evenly over `rows`.
    fn errors(
        &self,
        presses: &mut Dataset,
        rows: Range<usize>,
        transfers: &[Fitted; 3],
        map_net: &Net,
    ) -> Result<[MapError; 3]> {
        let most = (self.run.profile.n_single / TEST_SHARE).max(1);
        let rows: Vec<usize> = rows.clone().step_by(rows.len().div_ceil(most)).collect();
        let none = MapErrorSum::new(presses.n_surface);
        let mut sums = [none.clone(), none.clone(), none];
        for rows in rows.chunks(BLOCK) {
            self.run.check_stop("figure 5A")?;
            let (mut readings, mut truth) = (vec![], vec![]);
            for &row in rows {
                readings.extend(presses.readings(row..row + 1)?);
                truth.extend(presses.maps(row..row + 1)?);
            }
            for (sum, transfer) in sums.iter_mut().zip(transfers) {
                let virtual_um = transfer.predictions(&readings, rows.len())?;
                sum.add(&truth, &forward(map_net, &virtual_um)?);
            }
        }
        Ok(sums.map(|sum| sum.finish()))
    }

    /// F_T by each of [`METHODS`], on the rig's single training presses.
    fn transfers(&self, presses: &mut Dataset, train: Range<usize>) -> Result<[Fitted; 3]> {
        let x = presses.readings(train.clone())?;
        let y = self.patches.virtual_gauges(&presses.drawn(train.clone())?);
        let rows = Rows { n: train.len(), x, y };
        let fit_to = |learner: Learner| learner.fit(&rows.samples(), &|| false);
        let linear = fit_to(Learner::Linear(LinearParams::default()))?;
        let nearest = fit_to(Learner::Knn { k: 6 })?;
        let data = self.done.data.as_ref().context("no datasets")?;
        let size = self.patches.size;
        let of = json!({ "limb": self.key, "size": size, "presses": data.rig_single.key });
        let (net, _) = fit(
            self.run,
            &format!("F_T for {size} virtual gauges"),
            &of,
            &Training::transfer(self.run),
            MlpSpec::transfer,
            || rows.source(),
        )?;
        Ok([linear, nearest, Fitted::Net(Box::new(net))])
    }
}

/// Contacts of the training samples of all simulated sets.
pub(crate) fn training_contacts(done: &Pipeline) -> Result<Vec<Vec<DrawnContact>>> {
    let data = done.data.as_ref().context("no datasets")?;
    let mut contacts = vec![];
    for mut set in Dataset::open_all(data)? {
        let train = set.split()?.train;
        contacts.extend(set.drawn(train)?);
    }
    Ok(contacts)
}
