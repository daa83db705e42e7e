//! The ablations as one table: the chain with one thing changed, a row each.

mod configurations;
mod modes;
mod nets;
mod refine;
mod score;
mod target;

use anyhow::{Context, Result};
use hapdef::stages::NetKind;
use hapdef::{
    ChainNets, ComplianceTable, ContactStats, Hapdefx, Limb, Pipeline, Run, Stage, hapdefx,
};
use hapdef_bench::{Column, or_dash, page_table, table};
use hapdef_nets::Net;
use hapdef_report::{ReportTable, StageTime};
use serde::{Deserialize, Serialize};
use serde_json::json;

use self::configurations::{Configuration, MapsFrom};
use self::nets::{AblationNets, World};
use self::refine::Refiner;
use self::score::{AblationRow, Tests};
use self::target::{Target, TrueMaps};
use super::chain::{Choice, chain, reconstruction};
use super::kept::kept;

const VERSION: u32 = 1;

/// Names of the rows that others are compared with.
const CHAIN: &str = "the chain";
const BRIEF: &str = "the chain, F_R trained briefly";

/// The table's rows, and the time of a frame in each.
#[derive(Deserialize, Serialize)]
pub(crate) struct Ablations {
    rows: Vec<AblationRow>,
    frame_s: Vec<f64>,
    /// What the modes leave out of the variance, by target.
    left_out: Vec<(String, f64)>,
}

/// Trains what is missing and tests every row, or reads the rows from the cache.
pub(crate) fn ablation_table(
    run: &Run,
    limb: &Limb,
    done: &Pipeline,
) -> Result<(Ablations, Vec<Stage>)> {
    let data = done.data.as_ref().context("no datasets")?;
    let nets = done.nets.as_ref().context("no nets")?;
    let path = done.compliance.dir.join("compliance.safetensors");
    let table = ComplianceTable::read(&path, limb.n_surface_nodes())?;
    let truth = TrueMaps { table: &table, directions: &limb.directions };
    let chain = chain(run, limb, done)?;
    let world = World { run, limb, done, data, nets, truth: &truth, chain: &chain };
    let (made, mut stages) = world.train_all()?;
    let keys: Vec<&str> = stages.iter().map(|stage| stage.key.as_str()).collect();
    let inputs = json!({
        "version": VERSION, "keys": super::keys_of(run, done), "nets": keys,
        "singles": data.rig_single.key, "doubles": data.rig_double.as_ref().map(|s| &s.key),
        "estimator": run.scene.estimator,
    });
    let (found, stage) = kept(run, "ablations", &inputs, |_| {
        run.say("the ablations, row by row");
        world.rows(&made, &Tests::read(data)?)
    })?;
    stages.push(stage);
    Ok((found, stages))
}

impl World<'_> {
    fn rows(&self, made: &AblationNets, tests: &Tests) -> Result<Ablations> {
        let transfer = self.nets.load(NetKind::Transfer)?;
        let whole = reconstruction(self.done)?;
        let points = self.limb.surface_points();
        let refiner = Refiner { points: &points, across: self.truth.directions };
        let chain_of = |sensitivity: &Net| {
            let points = points.iter().map(|p| p.coords.into()).collect();
            let spec = self.run.scene.estimator.hapdefx();
            let nets = ChainNets {
                transfer: transfer.clone(),
                reconstruction: made.brief.clone(),
                sensitivity: sensitivity.clone(),
            };
            hapdefx(nets, points, &spec)
        };
        let (on_predicted, on_normal) = (chain_of(&made.on_predicted)?, chain_of(&made.on_normal)?);
        let mut configurations =
            self.whole_configurations(&transfer, &whole, made, &on_predicted, &refiner);
        configurations.extend(self.brief_configurations(&transfer, made, &on_normal));
        let (mut rows, mut frame_s) = (vec![], vec![]);
        for configuration in &configurations {
            self.run.check_stop("the ablations")?;
            rows.push(tests.row(configuration, self.truth)?);
            frame_s.push(tests.frame_s(configuration, self.truth)?);
        }
        let left_out = made.by_modes.iter();
        let left_out = left_out.map(|(target, _, modes)| (target.name().into(), modes.left_out));
        Ok(Ablations { rows, frame_s, left_out: left_out.collect() })
    }

    /// Rows that keep the run's own F_R.
    fn whole_configurations<'a>(
        &'a self,
        transfer: &'a Net,
        whole: &'a Net,
        made: &'a AblationNets,
        on_predicted: &'a Hapdefx,
        refiner: &'a Refiner<'a>,
    ) -> Vec<Configuration<'a>> {
        let maps = MapsFrom::Gauges(Some(transfer), whole, None);
        let row = |name: &str, maps| Configuration {
            name: name.into(),
            against: CHAIN,
            maps,
            chain: self.chain,
            choice: Choice::Force,
            refiner: None,
        };
        vec![
            Configuration { against: "", ..row(CHAIN, maps) },
            Configuration {
                choice: Choice::ForceWithSpread,
                ..row("point T + 1 exchanged for T", maps)
            },
            Configuration {
                choice: Choice::Displacement,
                ..row("candidates ranked by displacement", maps)
            },
            Configuration { refiner: Some(refiner), ..row("peaks refined between nodes", maps) },
            Configuration { chain: on_predicted, ..row("F_S trained on predicted maps", maps) },
            row(
                "F_T trained on superposed presses, too",
                MapsFrom::Gauges(Some(&made.transfer), whole, None),
            ),
            row("true virtual gauges", MapsFrom::Gauges(None, whole, None)),
            row("true map", MapsFrom::Truth),
        ]
    }

    /// Rows with an F_R of their own, all trained equally briefly.
    fn brief_configurations<'a>(
        &'a self,
        transfer: &'a Net,
        made: &'a AblationNets,
        on_normal: &'a Hapdefx,
    ) -> Vec<Configuration<'a>> {
        let row = |name: String, against, maps| Configuration {
            name,
            against,
            maps,
            chain: self.chain,
            choice: Choice::Force,
            refiner: None,
        };
        let brief = MapsFrom::Gauges(Some(transfer), &made.brief, None);
        let mut configurations = vec![
            row(BRIEF.into(), CHAIN, brief),
            row(
                "readings straight to the map".into(),
                BRIEF,
                MapsFrom::Readings(&made.without_gauges),
            ),
        ];
        for (target, net, modes) in &made.by_modes {
            let name = format!("map of the {} by {} modes", target.name(), modes.n());
            let maps = MapsFrom::Gauges(Some(transfer), net, Some((*target, modes)));
            configurations.push(Configuration {
                chain: match target {
                    Target::Normal => on_normal,
                    _ => self.chain,
                },
                ..row(name, BRIEF, maps)
            });
            if *target == Target::Vector {
                let name = "the same, virtual gauges as vectors, F_T on superposed presses".into();
                let maps = MapsFrom::Vectors(&made.by_vectors, modes);
                configurations.push(row(name, BRIEF, maps));
            }
        }
        configurations
    }
}

impl Ablations {
    /// For people.
    pub(crate) fn table(&self) -> Result<ReportTable> {
        let left_out: Vec<String> = self
            .left_out
            .iter()
            .map(|(target, share)| format!("{target} {:.2} %", share * 100.0))
            .collect();
        let note = format!(
            "At most 400 test presses of each kind on the rig, T given. Map and FVU: the row's \
             own map (magnitude, part along the press, or vector, per component) on simulated \
             samples, from true virtual gauges; double: FVU is from readings. Nets behind \
             \"{BRIEF}\" all have half of F_R's steps, at most 1,500; the others are trained \
             as long as the run's own. Modes are those of standardised training maps; they \
             leave out of the variance: {}. Contacts on the rig lie on nodes, so refining \
             peaks can only make up for errors of the map. The time of a frame in each row is \
             among the times below.",
            left_out.join(", ")
        );
        let title = "Ablations: the chain with one thing changed";
        Ok(page_table(title, note, table(&COLUMNS, &self.rows), &self.rows)?)
    }

    /// Median time of a frame, one core, without preparation for fast single passes.
    pub(crate) fn times(&self) -> impl Iterator<Item = StageTime> + '_ {
        let rows = self.rows.iter().zip(&self.frame_s);
        rows.map(|(row, frame_s)| StageTime {
            name: format!("a frame, {}", row.name),
            elapsed_s: *frame_s,
            cached: false,
        })
    }
}

const COLUMNS: [Column<AblationRow>; 12] = [
    Column::new("changed", |r| r.name.clone()),
    Column::new("compare with", |r| r.against.clone()),
    Column::new("map, µm", |r| or_dash(r.simulated.map(|m| format!("{:.2}", m.mean_abs_um)))),
    Column::new("FVU", |r| or_dash(r.simulated.map(|m| percent(m.fvu)))),
    Column::new("double: FVU", |r| or_dash(r.double_map.map(|m| percent(m.fvu)))),
    Column::new("single, mm", |r| of_found(Some(r.single), |s| s.mean_mm)),
    Column::new("single, N", |r| of_found(Some(r.single), |s| s.mean_n)),
    Column::new("double, lenient, mm", |r| of_found(r.lenient, |s| s.mean_mm)),
    Column::new("one-to-one, mm", |r| of_found(r.one_to_one, |s| s.mean_mm)),
    Column::new("one-to-one, N", |r| of_found(r.one_to_one, |s| s.mean_n)),
    Column::new("found", |r| {
        let found = r.single.n + r.one_to_one.map_or(0, |s| s.n);
        let expected = r.single.n_expected + r.one_to_one.map_or(0, |s| s.n_expected);
        format!("{found} of {expected}")
    }),
    Column::new("weights, M", |r| format!("{:.2}", r.n_weights as f64 * 1e-6)),
];

fn percent(share: f64) -> String {
    format!("{:.1} %", share * 100.0)
}

/// A mean over the contacts that were found, if any was.
fn of_found(stats: Option<ContactStats>, of: fn(&ContactStats) -> f64) -> String {
    or_dash(stats.filter(|stats| stats.n > 0).map(|stats| format!("{:.1}", of(&stats))))
}
