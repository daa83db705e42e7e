//! The nets that only the ablations need.

use anyhow::{Context, Result};
use hapdef::stages::{Datasets, NetKind, TrainedNets};
use hapdef::{DrawnContact, Hapdefx, Limb, OutputScale, Pipeline, Run, Stage};
use hapdef_nets::train::MemorySource;
use hapdef_nets::{MlpSpec, Net};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde_json::{Value, json};

use super::super::ablation::readings_to_map;
use super::super::chain::MapFrom;
use super::super::dataset::{Dataset, blocks, evenly};
use super::super::fit::{Training, fit};
use super::super::patches::training_contacts;
use super::modes::Modes;
use super::target::{Target, TrueMaps};

/// Modes of a map.
const N_MODES: usize = 128;

/// Training samples that tell the modes.
const N_SNAPSHOTS: usize = 600;

/// Samples computed together.
const BLOCK: usize = 512;

/// Set into the scene's seed to choose which presses are superposed.
const SUPERPOSED_SEED: u64 = 0x7375_7065;

/// Everything that rows are made from, beside the pipeline's own nets.
pub(super) struct AblationNets {
    /// F_R of the paper, trained briefly.
    pub(super) brief: Net,
    /// F_R to the coefficients of modes, for each of [`Target::ALL`], trained as briefly.
    pub(super) by_modes: Vec<(Target, Net, Modes)>,
    /// F_T to the virtual gauges' vectors on superposed presses, and F_R from them to modes of the
    /// map of vectors, trained as briefly.
    pub(super) by_vectors: [Net; 2],
    /// Readings straight to the map, trained as briefly.
    pub(super) without_gauges: Net,
    /// F_T on superposed presses, too.
    pub(super) transfer: Net,
    /// F_S on maps that the chain predicted.
    pub(super) on_predicted: Net,
    /// F_S for the displacement along the press.
    pub(super) on_normal: Net,
}

/// What F_R gets of each virtual gauge.
#[derive(Clone, Copy)]
enum Inputs {
    /// How far it moves, as in the paper.
    Magnitudes,
    /// Where to, as well.
    Vectors,
}

impl Inputs {
    /// Numbers of a gauge.
    fn per_gauge(self) -> usize {
        match self {
            Self::Magnitudes => 1,
            Self::Vectors => 3,
        }
    }
}

/// What nets and rows are made from.
pub(super) struct World<'a> {
    pub(super) run: &'a Run,
    pub(super) limb: &'a Limb,
    pub(super) done: &'a Pipeline,
    pub(super) data: &'a Datasets,
    pub(super) nets: &'a TrainedNets,
    pub(super) truth: &'a TrueMaps<'a>,
    pub(super) chain: &'a Hapdefx,
}

impl World<'_> {
    /// Trains all nets, or reads them from the cache; and their stages.
    pub(super) fn train_all(&self) -> Result<(AblationNets, Vec<Stage>)> {
        let brief = &Training::reconstruction(self.run);
        let to_modes = &Training { scale: OutputScale::One, ..brief.clone() };
        let mut stages = vec![];
        let mut keep = |(net, stage): (Net, Stage)| {
            stages.push(stage);
            net
        };
        let sets: Vec<&str> = self.data.simulated.iter().map(|s| s.key.as_str()).collect();
        let of = json!({ "sets": sets });
        let spec = MlpSpec::reconstruction;
        let whole = || self.map_samples(Inputs::Magnitudes, None);
        let whole = keep(fit(self.run, "F_R", &of, brief, spec, whole)?);
        let mut by_modes = vec![];
        for target in Target::ALL {
            let modes = self.modes(target)?;
            let name = format!("F_R to modes, {}", target.name());
            let of = json!({ "sets": sets, "modes": N_MODES, "snapshots": N_SNAPSHOTS });
            let open = || self.map_samples(Inputs::Magnitudes, Some((target, &modes)));
            let net = keep(fit(self.run, &name, &of, to_modes, spec, open)?);
            by_modes.push((target, net, modes));
        }
        let vectors = by_modes.iter().find(|(target, ..)| *target == Target::Vector);
        let (_, _, modes) = vectors.context("no modes of the map of vectors")?;
        let open = || self.map_samples(Inputs::Vectors, Some((Target::Vector, modes)));
        let of = json!({ "sets": sets, "modes": N_MODES, "snapshots": N_SNAPSHOTS });
        let name = "F_R to modes, from vectors";
        let from_vectors = keep(fit(self.run, name, &of, to_modes, spec, open)?);
        let to_vectors =
            keep(self.transfer("F_T to vectors", |all| self.truth.virtual_vectors(all))?);
        let nets = AblationNets {
            brief: whole,
            by_modes,
            by_vectors: [to_vectors, from_vectors],
            without_gauges: keep(readings_to_map(self.run, self.done)?),
            transfer: keep(
                self.transfer("F_T on superposed presses", |all| self.truth.virtual_gauges(all))?,
            ),
            on_predicted: keep(self.on_predicted()?),
            on_normal: keep(self.on_normal()?),
        };
        Ok((nets, stages))
    }

    /// Modes of an even choice of the training samples of all sets.
    fn modes(&self, target: Target) -> Result<Modes> {
        let contacts = training_contacts(self.done)?;
        let chosen = evenly(0..contacts.len(), N_SNAPSHOTS).map(|i| contacts[i].clone());
        let snapshots = self.truth.of(target, &chosen.collect::<Vec<_>>());
        let width = target.width(self.truth.directions.len());
        Modes::of(&snapshots, width, N_MODES)
    }

    /// Virtual gauges → map, or → the coefficients of modes, of all simulated training samples.
    fn map_samples(&self, inputs: Inputs, by: Option<(Target, &Modes)>) -> Result<MemorySource> {
        let (mut x, mut y) = (vec![], vec![]);
        let mut n_in = 0;
        for mut set in Dataset::open_all(self.data)? {
            n_in = set.n_virtual * inputs.per_gauge();
            for rows in blocks(set.split()?.train, BLOCK) {
                self.run.check_stop("the ablations")?;
                x.extend(match inputs {
                    Inputs::Magnitudes => set.inputs(rows.clone())?,
                    Inputs::Vectors => self.truth.virtual_vectors(&set.drawn(rows.clone())?),
                });
                y.extend(match by {
                    None => set.maps(rows)?,
                    Some((target, modes)) => {
                        modes.encode(self.truth.of(target, &set.drawn(rows)?))?
                    }
                });
            }
        }
        let n_out = y.len() / (x.len() / n_in);
        Ok(MemorySource::new(n_in, n_out, x, y)?)
    }

    /// F_T on the rig's single training presses and on sums of several of them, to what `gauges_of`
    /// gives of them.
    fn transfer(
        &self,
        name: &str,
        gauges_of: impl Fn(&[Vec<DrawnContact>]) -> Vec<f32>,
    ) -> Result<(Net, Stage)> {
        let n_sets = self.data.simulated.len();
        let of = json!({ "presses": self.data.rig_single.key, "superposed": n_sets });
        let training = Training::whole(self.run, &self.run.profile.transfer);
        let open = || self.superposed(n_sets, &gauges_of);
        fit(self.run, name, &of, &training, MlpSpec::transfer, open)
    }

    /// Readings → virtual gauges of the presses themselves and, for each number of contacts from 2
    /// to `n_sets`, as many sums of readings of presses drawn with replacement.
    fn superposed(
        &self,
        n_sets: usize,
        gauges_of: &impl Fn(&[Vec<DrawnContact>]) -> Vec<f32>,
    ) -> Result<MemorySource> {
        let mut presses = Dataset::open(&self.data.rig_single)?;
        let train = presses.split()?.train;
        let readings = presses.readings(train.clone())?;
        let contacts = presses.drawn(train)?;
        let n_gauges = readings.len() / contacts.len();
        let mut rng = ChaCha8Rng::seed_from_u64(self.run.scene.seed ^ SUPERPOSED_SEED);
        let (mut x, mut all) = (readings.clone(), contacts.clone());
        for n_contacts in 2..=n_sets {
            for _ in 0..contacts.len() {
                let mut sum = vec![0.0; n_gauges];
                let mut together: Vec<DrawnContact> = vec![];
                for _ in 0..n_contacts {
                    let press = (rng.next_u64() % contacts.len() as u64) as usize;
                    let row = &readings[press * n_gauges..(press + 1) * n_gauges];
                    sum.iter_mut().zip(row).for_each(|(sum, r)| *sum += r);
                    together.extend(&contacts[press]);
                }
                x.extend(sum);
                all.push(together);
            }
        }
        let y = gauges_of(&all);
        Ok(MemorySource::new(n_gauges, y.len() / all.len(), x, y)?)
    }

    /// F_S on the displacements that the chain predicts where the rig's training presses were.
    fn on_predicted(&self) -> Result<(Net, Stage)> {
        let nets = self.nets.nets.iter();
        let behind: Vec<&str> = nets
            .filter(|net| net.kind != NetKind::Sensitivity && net.kind != NetKind::Direct)
            .map(|net| net.stage.key.as_str())
            .collect();
        let of = json!({ "presses": self.data.rig_single.key, "nets": behind });
        let displacement = |presses: &mut Dataset, rows: std::ops::Range<usize>| {
            MapFrom::Readings(self.chain).maps(presses, rows)
        };
        let stage = &self.data.rig_single;
        self.sensitivity("F_S on predicted maps", &of, stage, displacement)
    }

    /// F_S on the true displacements along the press of simulated single contacts.
    fn on_normal(&self) -> Result<(Net, Stage)> {
        let stage = &self.data.simulated[0];
        let of = json!({ "set": stage.key });
        let displacement = |presses: &mut Dataset, rows: std::ops::Range<usize>| {
            Ok(self.truth.of(Target::Normal, &presses.drawn(rows)?))
        };
        self.sensitivity("F_S along the press", &of, stage, displacement)
    }

    /// F_S on single presses of a set, with the maps that `maps_of` gives.
    fn sensitivity(
        &self,
        name: &str,
        of: &Value,
        stage: &Stage,
        maps_of: impl Fn(&mut Dataset, std::ops::Range<usize>) -> Result<Vec<f32>>,
    ) -> Result<(Net, Stage)> {
        let training = Training::whole(self.run, &self.run.profile.sensitivity);
        let open = || {
            let mut presses = Dataset::open(stage)?;
            let (mut x, mut y) = (vec![], vec![]);
            for rows in blocks(presses.split()?.train, BLOCK) {
                self.run.check_stop("the ablations")?;
                let maps = maps_of(&mut presses, rows.clone())?;
                let drawn = presses.drawn(rows.clone())?;
                let truth = presses.truth(rows)?;
                let each = maps.chunks_exact(presses.n_surface).zip(drawn.iter().zip(&truth));
                for (map, (drawn, truth)) in each {
                    let (place, force_n) = *truth.first().context("a press of no contact")?;
                    x.push(map[drawn[0].node]);
                    x.extend(place.map(|v| v as f32));
                    y.push(force_n as f32);
                }
            }
            Ok(MemorySource::new(4, 1, x, y)?)
        };
        fit(self.run, name, of, &training, |_, _| MlpSpec::sensitivity(), open)
    }
}
