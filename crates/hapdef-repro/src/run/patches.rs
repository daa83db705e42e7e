//! Figure 5A: map error against the number of virtual gauges around each gauge.
//!
//! For each size F_R is trained briefly on the simulated sets, and F_T is linear regression, k
//! nearest neighbours or a net, on single presses. A compliance table with the largest patches
//! serves every size, as the smaller are the beginnings of the larger.

mod source;

use anyhow::{Context, Result};
use hapdef::stages::compliance;
use hapdef::{
    ComplianceTable, DrawnContact, HapdefError, Limb, MapError, MapErrorSum, Pipeline, Progress,
    Run, Stage,
};
use hapdef_data::{Split, StandardiserFit};
use hapdef_nets::MlpSpec;
use hapdef_nets::train::MemorySource;
use hapdef_repro::{Knn, KnnParams, LinearAccumulator, LinearParams};
use serde::{Deserialize, Serialize};
use serde_json::json;

use self::source::{Patches, SuperposedSource};
use super::chain::forward;
use super::fit::{Brief, fit};
use super::presses::Presses;

const VERSION: u32 = 1;

/// Virtual gauges around each gauge, full and quick profile.
const SIZES: [usize; 11] = [1, 2, 4, 8, 12, 16, 24, 32, 40, 50, 60];
const QUICK_SIZES: [usize; 4] = [1, 8, 24, 60];

/// Most presses of a test set.
const MAX_TEST: usize = 1500;

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
    let mut stages = vec![stage];
    let mut points = vec![];
    let mut table = None;
    for &size in sizes
        .iter()
        .filter(|size| **size <= wide.scene.gauges.patch_nodes)
    {
        run.check_stop("figure 5A")?;
        let briefs = [
            Brief::reconstruction(&run.profile),
            Brief::transfer(&run.profile),
        ];
        let inputs = json!({
            "version": VERSION, "limb": stages[0].key, "size": size, "briefs": briefs,
            "keys": super::keys_of(run, done), "doubles": doubles(done)?.key,
        });
        let stage = run.cache.stage("patch-size", &inputs, |_| {
            let at = AtSize::open(run, done, &limb, &stages[0], &mut table, size);
            let point = at.and_then(|at| Ok(serde_json::to_value(at.point()?)?));
            point.map_err(|error| match error.downcast::<HapdefError>() {
                Ok(error) => error,
                Err(error) => HapdefError::Stale {
                    path: "figure 5A".into(),
                    what: format!("{error:#}"),
                },
            })
        })?;
        points.push(SizePoint::deserialize(&stage.record.info).context("the patch-size stage")?);
        stages.push(stage);
    }
    Ok((points, stages))
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
                let wide = with_scene(run, scene);
                let stage = compliance(&wide, &limb)?;
                return Ok((wide, limb, stage));
            }
            Err(error) => refused = Some(error),
        }
    }
    Err(refused.map_or_else(|| anyhow::anyhow!("no patch size to try"), Into::into))
}

fn with_scene(run: &Run, scene: hapdef::scene::Scene) -> Run {
    Run {
        scene,
        scene_dir: run.scene_dir.clone(),
        scene_hash: run.scene_hash.clone(),
        profile: run.profile.clone(),
        cache: run.cache.clone(),
        threads: run.threads,
        progress: Progress::clone(&run.progress),
        stop: run.stop.clone(),
    }
}

/// Everything at one size.
struct AtSize<'a> {
    run: &'a Run,
    done: &'a Pipeline,
    patches: Patches<'a>,
    key: &'a str,
}

impl<'a> AtSize<'a> {
    fn open(
        run: &'a Run,
        done: &'a Pipeline,
        limb: &Limb,
        stage: &'a Stage,
        table: &'a mut Option<ComplianceTable>,
        size: usize,
    ) -> Result<Self> {
        if table.is_none() {
            let path = stage.dir.join("compliance.safetensors");
            *table = Some(ComplianceTable::read(&path, limb.n_surface_nodes())?);
        }
        let table = table.as_ref().context("the compliance table")?;
        Ok(Self {
            run,
            done,
            patches: Patches::new(table, limb.gauges.len(), size),
            key: &stage.key,
        })
    }

    fn point(&self) -> Result<SizePoint> {
        let size = self.patches.size;
        let data = self.done.data.as_ref().context("no datasets")?;
        let keys: Vec<&str> = data.simulated.iter().map(|s| s.key.as_str()).collect();
        let of = json!({ "limb": self.key, "size": size, "sets": keys });
        let (map_net, _) = fit(
            self.run,
            &format!("F_R for {size} virtual gauges"),
            &of,
            Brief::reconstruction(&self.run.profile),
            MlpSpec::reconstruction,
            || {
                Ok(SuperposedSource::new(
                    self.patches,
                    training_contacts(self.done)?,
                ))
            },
        )?;
        let (mut singles, test) = super::singles::open(self.done)?;
        let transfers = self.transfers(&mut singles)?;
        let mut doubles = Presses::open(doubles(self.done)?)?;
        let all = 0..doubles.n();
        let none = MapErrorSum::new(singles.n_surface);
        let mut errors: [[MapErrorSum; 2]; 3] =
            std::array::from_fn(|_| [none.clone(), none.clone()]);
        for (i, (presses, rows)) in [(&mut singles, test), (&mut doubles, all)]
            .into_iter()
            .enumerate()
        {
            let rows = rows.start..rows.end.min(rows.start + MAX_TEST);
            for rows in super::samples::blocks(rows, BLOCK) {
                self.run.check_stop("figure 5A")?;
                let readings = presses.read("readings", rows.clone())?;
                let truth = presses.read("deformation", rows)?;
                for (sums, transfer) in errors.iter_mut().zip(&transfers) {
                    let maps = forward(&map_net, &transfer.predict(&readings)?)?;
                    sums[i].add(&truth, &maps);
                }
            }
        }
        Ok(SizePoint {
            size,
            errors: errors.map(|sums| sums.map(|sum| sum.finish())),
        })
    }

    /// F_T by each of [`METHODS`], on the rig's single training presses.
    fn transfers(&self, presses: &mut Presses) -> Result<[Transfer; 3]> {
        let train = Split::of(presses.n())?.train;
        let x = presses.read("readings", train.clone())?;
        let n_gauges = x.len() / train.len();
        let contacts = presses.drawn(train)?;
        let y = self.patches.virtual_gauges(&contacts);
        let mut linear = LinearAccumulator::new(n_gauges, self.patches.width());
        linear.add_block(&x, &y)?;
        let (linear, _) = linear.solve(&LinearParams::default())?;
        let data = self.done.data.as_ref().context("no datasets")?;
        let size = self.patches.size;
        let of = json!({ "limb": self.key, "size": size, "presses": data.rig_single.key });
        let (net, _) = fit(
            self.run,
            &format!("F_T for {size} virtual gauges"),
            &of,
            Brief::transfer(&self.run.profile),
            MlpSpec::transfer,
            || {
                Ok(MemorySource::new(
                    n_gauges,
                    self.patches.width(),
                    x.clone(),
                    y.clone(),
                )?)
            },
        )?;
        Ok([
            Transfer::Linear(linear),
            Transfer::nearest(&x, y, n_gauges)?,
            Transfer::Net(net),
        ])
    }
}

/// Contacts of the training samples of all simulated sets.
fn training_contacts(done: &Pipeline) -> Result<Vec<Vec<DrawnContact>>> {
    let data = done.data.as_ref().context("no datasets")?;
    let mut contacts = vec![];
    for stage in &data.simulated {
        let mut presses = Presses::open(stage)?;
        let train = Split::of(presses.n())?.train;
        contacts.extend(presses.drawn(train)?);
    }
    Ok(contacts)
}

/// From readings to virtual gauges.
enum Transfer {
    Linear(hapdef_repro::LinearRegression),
    Nearest {
        knn: Knn,
        mean: Vec<f32>,
        std: Vec<f32>,
        y: Vec<f32>,
        width: usize,
    },
    Net(hapdef_nets::Net),
}

impl Transfer {
    /// k nearest presses by standardised readings, k = 6, weights 1/distance.
    fn nearest(x: &[f32], y: Vec<f32>, n_gauges: usize) -> Result<Self> {
        let mut fit = StandardiserFit::new(n_gauges);
        fit.push(x)?;
        let (scale, _) = fit.finish()?;
        let mut x = x.to_vec();
        super::table1::standardise(&mut x, &scale.mean, &scale.std);
        Ok(Self::Nearest {
            width: y.len() / (x.len() / n_gauges),
            knn: Knn::new(&x, n_gauges)?,
            mean: scale.mean,
            std: scale.std,
            y,
        })
    }

    /// Virtual gauges, `[n, n_virtual]`, µm, of readings, `[n, n_gauges]`, µε.
    fn predict(&self, readings: &[f32]) -> Result<Vec<f32>> {
        match self {
            Self::Net(net) => forward(net, readings),
            Self::Linear(linear) => {
                let n = readings.len() / linear.n_inputs();
                let mut out = vec![0.0; n * linear.n_outputs()];
                linear.predict(readings, &mut out)?;
                Ok(out)
            }
            Self::Nearest {
                knn,
                mean,
                std,
                y,
                width,
            } => {
                let mut x = readings.to_vec();
                super::table1::standardise(&mut x, mean, std);
                let found = knn.neighbours(&x, &KnnParams::default())?;
                let mut out = vec![0.0; found.n_queries() * width];
                for (query, out) in out.chunks_exact_mut(*width).enumerate() {
                    let fetch = |row: usize, buffer: &mut [f32]| {
                        buffer.copy_from_slice(&y[row * width..(row + 1) * width]);
                        Ok::<(), std::convert::Infallible>(())
                    };
                    found.predict(query, fetch, out)?;
                }
                Ok(out)
            }
        }
    }
}
