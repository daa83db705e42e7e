//! Stage: the paper's datasets, by superposition.

use std::path::PathBuf;

use hapdef_contact::DrawnContact;
use hapdef_data::{DatasetWriter, Manifest, Split, TensorSpec};
use hapdef_rig::{DoublePressParams, SinglePressParams, double_presses, single_presses};
use nalgebra::Point3;
use rayon::prelude::*;
use serde_json::json;

use super::dataset_kind::DatasetKind;
use super::keys;
use super::rig::read_response;
use super::rig_channels::RigChannels;
use super::simulate::COMPLIANCE_FILE;
use crate::cache::Stage;
use crate::compliance::ComplianceTable;
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::run::Run;
use crate::sampling::draw_contacts;
use crate::work::{Work, table_bytes};

const DATASET_FILE: &str = "samples.safetensors";
/// Samples computed between two writes; also the grain of the parallel work.
const BLOCK: usize = 256;

/// The finished datasets of a scene.
#[derive(Clone, Debug)]
pub struct Datasets {
    /// Simulated sets by number of contacts, the single contacts first.
    pub simulated: Vec<Stage>,
    /// Single presses on the rig.
    pub rig_single: Stage,
    /// Double presses on the rig; absent when the scene has one contact at most.
    pub rig_double: Option<Stage>,
}

/// Path of the samples in a dataset stage's folder.
#[must_use]
pub fn samples_path(stage: &Stage) -> PathBuf {
    stage.dir.join(DATASET_FILE)
}

/// Makes every dataset that the scene's contact count calls for.
///
/// # Errors
/// [`HapdefError`] when contacts don't fit on the skin or the disk refuses.
pub fn datasets(
    run: &Run,
    limb: &Limb,
    compliance: &Stage,
    rig: &Stage,
) -> Result<Datasets, HapdefError> {
    let maker = Maker::new(run, limb, compliance, rig);
    let n_sets = run.scene.contact.max_contacts;
    let simulated = (1..=n_sets)
        .map(|n_contacts| maker.make(DatasetKind::Simulated { n_contacts }))
        .collect::<Result<_, _>>()?;
    let rig_single = maker.make(DatasetKind::RigSingle)?;
    let rig_double = if n_sets >= 2 { Some(maker.make(DatasetKind::RigDouble)?) } else { None };
    Ok(Datasets { simulated, rig_single, rig_double })
}

/// Makes datasets; the compliance table is read when the first is not cached.
struct Maker<'a> {
    run: &'a Run,
    limb: &'a Limb,
    compliance: &'a Stage,
    rig: &'a Stage,
    points: Vec<Point3<f64>>,
    table: std::cell::OnceCell<ComplianceTable>,
}

impl<'a> Maker<'a> {
    fn new(run: &'a Run, limb: &'a Limb, compliance: &'a Stage, rig: &'a Stage) -> Self {
        let points = limb.surface_points();
        Self { run, limb, compliance, rig, points, table: std::cell::OnceCell::new() }
    }

    fn make(&self, kind: DatasetKind) -> Result<Stage, HapdefError> {
        let stages = [&self.compliance.key, &self.rig.key];
        let inputs = keys::dataset(kind, stages, &self.run.scene, &self.run.profile);
        self.run.cache.stage("dataset", &inputs, |dir| {
            let contacts = self.contacts(kind)?;
            let work = self.work(&contacts);
            self.run.say(&format!("writing {} samples: {}", contacts.len(), title(kind)));
            let mut electronics = self.electronics(kind)?;
            let path = dir.join(DATASET_FILE);
            let specs = self.tensors(kind, contacts[0].len());
            let mut writer = DatasetWriter::create(&path, contacts.len(), &specs)?;
            for block in contacts.chunks(BLOCK) {
                self.run.check_stop("the datasets")?;
                self.append_simulated(&mut writer, block)?;
                self.append_contacts(&mut writer, block)?;
                if let Some(electronics) = &mut electronics {
                    writer.append("readings", &electronics.readings(block))?;
                }
            }
            writer.finish()?;
            self.manifest(kind, contacts.len(), specs)?.write(&path)?;
            let n_saturated = electronics.map_or(0, |e| e.n_saturated());
            Ok(json!({
                "n_samples": contacts.len(), "n_saturated": n_saturated,
                "work": work.done(self.run.threads),
            }))
        })
    }

    fn table(&self) -> Result<&ComplianceTable, HapdefError> {
        if let Some(table) = self.table.get() {
            return Ok(table);
        }
        let path = self.compliance.dir.join(COMPLIANCE_FILE);
        let table = ComplianceTable::read(&path, self.limb.n_surface_nodes())?;
        Ok(self.table.get_or_init(|| table))
    }

    /// That of superposing and writing them, and of reading the table before the first.
    fn work(&self, contacts: &[Vec<DrawnContact>]) -> Work {
        let (n_surface, n_nodes) = (self.points.len(), self.limb.wanted_nodes().len());
        let work = Work::samples(contacts.len(), contacts[0].len(), n_nodes);
        if self.table.get().is_some() {
            return work;
        }
        work.reading(table_bytes(n_surface, n_nodes))
    }

    fn contacts(&self, kind: DatasetKind) -> Result<Vec<Vec<DrawnContact>>, HapdefError> {
        let profile = &self.run.profile;
        let scene = &self.run.scene;
        let presses = &scene.rig.presses;
        let [low, high] = scene.contact.force_range_n;
        match kind {
            DatasetKind::Simulated { n_contacts } => {
                let n = if n_contacts == 1 { profile.n_single } else { profile.n_multi };
                draw_contacts(&self.points, &scene.contact, n_contacts, n, scene.seed)
            }
            DatasetKind::RigSingle => {
                let params = SinglePressParams {
                    n_presses: profile.n_real_single,
                    force_range_n: (low, high),
                    seed: presses.single_seed,
                };
                let presses = single_presses(self.points.len(), &params);
                Ok(presses.into_iter().map(|press| vec![press]).collect())
            }
            DatasetKind::RigDouble => {
                let params = DoublePressParams {
                    n_pairs: profile.n_pairs,
                    n_amplitudes: profile.n_amplitudes,
                    spacing_range_m: presses.spacing_range_m.into(),
                    held_force_n: presses.held_force_n,
                    held_spread_n: presses.held_spread_n,
                    varied_range_n: (0.0, high),
                    seed: presses.double_seed,
                };
                let presses = double_presses(&self.points, &params)?;
                Ok(presses.into_iter().map(|pair| pair.to_vec()).collect())
            }
        }
    }

    fn electronics(&self, kind: DatasetKind) -> Result<Option<RigChannels>, HapdefError> {
        let stream = match kind {
            DatasetKind::Simulated { .. } => return Ok(None),
            DatasetKind::RigSingle => 0,
            DatasetKind::RigDouble => 1,
        };
        let response = read_response(&self.rig.dir, self.limb)?;
        RigChannels::new(self.run, response, self.limb.gauges.len(), stream).map(Some)
    }

    /// Deformation map and virtual gauges of a block, computed in parallel, row by row.
    fn append_simulated(
        &self,
        writer: &mut DatasetWriter,
        block: &[Vec<DrawnContact>],
    ) -> Result<(), HapdefError> {
        let table = self.table()?;
        let mut surface = vec![0.0_f32; block.len() * table.n_surface()];
        let mut virtual_um = vec![0.0_f32; block.len() * table.n_virtual()];
        surface
            .par_chunks_mut(table.n_surface())
            .zip(virtual_um.par_chunks_mut(table.n_virtual()))
            .zip(block)
            .for_each_init(
                || table.scratch(),
                |scratch, ((surface, virtual_um), contacts)| {
                    table.superpose(contacts, scratch, surface, virtual_um);
                },
            );
        writer.append("deformation", &surface)?;
        writer.append("virtual_gauges", &virtual_um)?;
        Ok(())
    }

    fn append_contacts(
        &self,
        writer: &mut DatasetWriter,
        block: &[Vec<DrawnContact>],
    ) -> Result<(), HapdefError> {
        let all = || block.iter().flatten();
        let positions: Vec<f32> =
            all().flat_map(|c| self.points[c.node].coords.iter().map(|x| *x as f32)).collect();
        let forces: Vec<f32> = all().map(|c| c.force_n as f32).collect();
        let nodes: Vec<i32> = all().map(|c| c.node as i32).collect();
        writer.append("contact_positions", &positions)?;
        writer.append("contact_forces", &forces)?;
        writer.append("contact_nodes", &nodes)?;
        Ok(())
    }

    fn tensors(&self, kind: DatasetKind, n_contacts: usize) -> Vec<TensorSpec> {
        let n_virtual: usize = self.limb.patches.iter().map(|p| p.nodes.len()).sum();
        let mut specs = vec![
            TensorSpec::f32("deformation", self.limb.n_surface_nodes(), "µm"),
            TensorSpec::f32("virtual_gauges", n_virtual, "µm"),
            TensorSpec::f32("contact_positions", n_contacts * 3, "m"),
            TensorSpec::f32("contact_forces", n_contacts, "N"),
            TensorSpec::i32("contact_nodes", n_contacts),
        ];
        if !matches!(kind, DatasetKind::Simulated { .. }) {
            specs.push(TensorSpec::f32("readings", self.limb.gauges.len(), "µε"));
        }
        specs
    }

    fn manifest(
        &self,
        kind: DatasetKind,
        n: usize,
        tensors: Vec<TensorSpec>,
    ) -> Result<Manifest, HapdefError> {
        let version = env!("CARGO_PKG_VERSION").to_owned();
        Ok(Manifest {
            format_version: hapdef_data::MANIFEST_FORMAT_VERSION,
            kind: title(kind),
            seed: self.seed(kind),
            scene_hash: self.run.scene_hash.clone(),
            crate_versions: [("hapdef".to_owned(), version)].into(),
            tensors,
            n,
            split: Split::of(n)?,
            created_by: "hapdef dataset".into(),
        })
    }

    fn seed(&self, kind: DatasetKind) -> u64 {
        let scene = &self.run.scene;
        match kind {
            DatasetKind::Simulated { .. } => scene.seed,
            DatasetKind::RigSingle => scene.rig.presses.single_seed,
            DatasetKind::RigDouble => scene.rig.presses.double_seed,
        }
    }
}

fn title(kind: DatasetKind) -> String {
    match kind {
        DatasetKind::Simulated { n_contacts } => format!("simulated, {n_contacts} at a time"),
        DatasetKind::RigSingle => "simulated rig, single presses".into(),
        DatasetKind::RigDouble => "simulated rig, double presses".into(),
    }
}
