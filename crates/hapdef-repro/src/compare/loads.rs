//! `compare --loads`: contacts beside loads on the whole limb that are no contacts.

use std::ops::Range;

use anyhow::Result;
use hapdef::Run;
use hapdef::scene::{FlangeSpec, LimbEnd, LoadsSpec, Mount, Scene};
use hapdef::touch::other_loads;
use hapdef_bench::stats::median;
use hapdef_bench::{Column, Figure, Goal, Metric, Named, Study, Wanted, page_table, table};
use hapdef_inverse::{ContactEstimator, OtherLoads, joint_bounds};
use hapdef_report::Report;
use hapdef_sim::LimbLoad;
use nalgebra::{DMatrix, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal, UnitSphere};
use serde::Serialize;

use super::cells::{Drawn, score};
use super::rig::Layout;
use super::score::Row;
use super::setup::{Bench, MORE};
use super::world::{Frame, TrueContact};
use crate::run::facts;

/// What acts on the limb beside contacts: a wrench through its free end, gravity of a pose unlike the tare's,
/// acceleration.
const FORCE_N: f64 = 30.0;
const MOMENT_NM: f64 = 1.0;
const GRAVITY_M_S2: f64 = 9.81;

/// How well loads are measured that are given, a share of each.
const GIVEN_ERROR: f64 = 0.02;

/// Frames in which nothing touches, of which loads are learned, and how much larger later ones may be.
const N_LEARNED: usize = 2000;
const MARGIN: f64 = 2.0;

/// Frames in which nothing touches for each with a contact, and the least force of what is taken for one that counts, N.
const UNTOUCHED_PER_FRAME: usize = 25;
const COUNTED_N: f64 = 0.5;

const NOTE: &str = "Simulated. In every frame a wrench of 30 N and 1 N m in random directions acts on the free end of \
    the limb, gravity of a random pose less that of another (the tare's), and 9.81 m/s² in a random direction. \
    Ignored: the estimator knows of no loads. Computed: all unknown, with the response of the limb as it is \
    drawn and the scene's error of the map. Learned: all unknown, their directions from 2,000 untouched frames. Given: each measured with an \
    error of 2 %, the response fitted to as many frames with such measurements. None: the same contacts \
    without any load. The bound is the median Cramér–Rao bound of the single contacts.";

/// What the estimator knows of the loads.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Known {
    None,
    Ignored,
    Computed,
    Learned,
    Given,
}

impl Known {
    fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Ignored => "ignored",
            Self::Computed => "computed",
            Self::Learned => "learned",
            Self::Given => "given",
        }
    }
}

/// Contacts of one kind on one layout.
#[derive(Clone, Debug, Serialize)]
struct Loaded {
    #[serde(flatten)]
    row: Row,
    /// Untouched frames with a contact above [`COUNTED_N`].
    n_false: Option<usize>,
    bound_mm: Option<f64>,
}

impl Named for Loaded {
    fn name(&self) -> &str {
        &self.row.name
    }
}

const STUDY: Study<Vec<Loaded>> =
    Study { folder: "loads", metrics: &METRICS, goals: &GOALS, goals_note: GOALS_NOTE, file: None };

const COLUMNS: [Column<Loaded>; 9] = [
    Column::new("frames of", |r| r.row.name.clone()),
    Column::new("n", |r| r.row.errors.n_frames.to_string()),
    Column::new("median, mm", |r| format!("{:.2}", r.row.errors.median_mm)),
    Column::new("90 %", |r| format!("{:.2}", r.row.errors.p90_mm)),
    Column::new("bound", |r| r.bound_mm.map_or("–".into(), |mm| format!("{mm:.2}"))),
    Column::new("mean, N", |r| format!("{:.2}", r.row.errors.mean_n)),
    Column::new("count right", |r| format!("{:.1} %", r.row.errors.count_pct)),
    Column::new("unsure", |r| format!("{:.1} %", r.row.unsure_pct)),
    Column::new("false", |r| r.n_false.map_or("–".into(), |n| n.to_string())),
];

const METRICS: [Metric<Vec<Loaded>>; 10] = [
    alone("loads.unknown10_false_frames", "untouched, 10 gauges, learned"),
    alone("loads.unknown16_false_frames", UNTOUCHED),
    median_mm("loads.unknown16_single_median_mm", "single, 16 gauges, learned"),
    median_mm("loads.given10_single_median_mm", "single, 10 gauges, given"),
    median_mm("loads.given16_single_median_mm", "single, 16 gauges, given"),
    median_mm("loads.given10_double_median_mm", "double, 10 gauges, given"),
    median_mm("loads.given16_double_median_mm", "double, 16 gauges, given"),
    count("loads.given10_double_count_pct", "double, 10 gauges, given"),
    count("loads.given16_double_count_pct", "double, 16 gauges, given"),
    count("loads.given10_single_count_pct", "single, 10 gauges, given"),
];

/// What the figures should be.
const GOALS: [Goal<Vec<Loaded>>; 6] = [
    goal(
        "loads measured, one contact, 10 gauges, median, mm",
        "single, 10 gauges, given",
        MEDIAN,
        0.5,
    ),
    goal("loads measured, two, 10 gauges, median, mm", "double, 10 gauges, given", MEDIAN, 1.0),
    goal("nothing measured, untouched, 16 gauges, contacts that are none", UNTOUCHED, FALSE, 0.0),
    goal(
        "loads measured, one contact, 16 gauges, median, mm",
        "single, 16 gauges, given",
        MEDIAN,
        0.5,
    ),
    goal("loads measured, two, 16 gauges, median, mm", "double, 16 gauges, given", MEDIAN, 1.0),
    Goal {
        what: "loads measured, two, 10 gauges, count right, %",
        wanted: Wanted::AtLeast(94.0),
        figure: Figure::Row("double, 10 gauges, given", |r: &Loaded| r.row.errors.count_pct),
    },
];

const GOALS_NOTE: &str = "Measured: with an error of 2 %.";

const UNTOUCHED: &str = "untouched, 16 gauges, learned";
const MEDIAN: fn(&Loaded) -> f64 = |r| r.row.errors.median_mm;
const FALSE: fn(&Loaded) -> f64 = |r| r.n_false.map_or(f64::NAN, |n| n as f64);

const fn goal(
    what: &'static str,
    row: &'static str,
    of: fn(&Loaded) -> f64,
    most: f64,
) -> Goal<Vec<Loaded>> {
    Goal { what, wanted: Wanted::AtMost(most), figure: Figure::Row(row, of) }
}

const fn alone(name: &'static str, row: &'static str) -> Metric<Vec<Loaded>> {
    Metric::row(name, "1", row, FALSE)
}

const fn median_mm(name: &'static str, row: &'static str) -> Metric<Vec<Loaded>> {
    Metric::row(name, "mm", row, MEDIAN)
}

const fn count(name: &'static str, row: &'static str) -> Metric<Vec<Loaded>> {
    Metric::row(name, "%", row, |r: &Loaded| r.row.errors.count_pct)
}

/// The scene with loads through its free end, by weight and by acceleration, as this study draws them.
pub(super) fn load_scene(run: &mut Run) -> Result<()> {
    let end = match run.scene.mount {
        Mount::End { end: LimbEnd::High, .. } => LimbEnd::Low,
        _ => LimbEnd::High,
    };
    let per_axis = 1.0 / 3.0_f64.sqrt();
    let loads = LoadsSpec {
        flange: Some(FlangeSpec {
            at: Mount::End { end, length_m: 0.004 },
            force_sd_n: FORCE_N * per_axis,
            moment_sd_nm: MOMENT_NM * per_axis,
        }),
        // two poses and the acceleration
        specific_force_sd_m_s2: GRAVITY_M_S2,
        ..LoadsSpec::default()
    };
    Ok(run.set_scene(Scene { loads: Some(loads), ..run.scene.clone() })?)
}

/// Scores frames beside loads, prints and writes it.
pub(super) fn loads(bench: &mut Bench<'_>) -> Result<()> {
    let mut rows = Vec::new();
    let layouts = [(Layout::Scene, "10 gauges"), (MORE, "16 gauges")];
    let n_layouts = if bench.has_more() { layouts.len() } else { 1 };
    for (layout, gauges) in &layouts[..n_layouts] {
        rows.extend(on_layout(bench, *layout, gauges)?);
    }
    let title = "Contacts beside loads that are no contacts";
    let report = Report {
        tables: vec![
            page_table(title, NOTE, table(&COLUMNS, &rows), &rows)?,
            STUDY.goal_table(&rows)?,
        ],
        ..facts::study(bench.run, "contacts beside loads", bench.args.test_seed)?
    };
    STUDY.publish(
        &rows,
        report,
        &mut facts::log_of(bench.run, bench.args.test_seed),
        &bench.args.scene.results,
    )?;
    Ok(())
}

/// Frames of one layout.
struct Frames {
    gauges: &'static str,
    channels: Range<usize>,
    singles: Vec<Frame>,
    doubles: Vec<Frame>,
    loaded_singles: Vec<LoadedFrame>,
    loaded_doubles: Vec<LoadedFrame>,
    untouched: Vec<LoadedFrame>,
    learned: Vec<LoadedFrame>,
    /// Standard deviation of each load `[n_loads]`.
    spec_sd: Vec<f64>,
}

impl Frames {
    fn draw(bench: &Bench<'_>, layout: Layout, gauges: &'static str) -> Result<Self> {
        let (drawn, n) = (bench.drawn(), bench.args.frames);
        let spec = bench.run.scene.loads.clone().unwrap_or_default();
        let (singles, doubles) = (drawn.singles(n)?, drawn.doubles(n)?);
        let contacts = |frames: &[Frame]| frames.iter().map(|f| f.contacts.clone()).collect();
        Ok(Self {
            gauges,
            channels: bench.rig.channels(layout),
            loaded_singles: drawn.loaded(contacts(&singles), 42)?,
            loaded_doubles: drawn.loaded(contacts(&doubles), 43)?,
            untouched: drawn.loaded(vec![Vec::new(); UNTOUCHED_PER_FRAME * n], 41)?,
            learned: drawn.loaded(vec![Vec::new(); N_LEARNED], 44)?,
            singles,
            doubles,
            spec_sd: spec.loads().into_iter().map(|(_, sd)| sd).collect(),
        })
    }

    /// The loads as `known`, of the response `computed`.
    fn loads(&self, known: Known, computed: &OtherLoads, gauge_sd: &[f64]) -> Result<OtherLoads> {
        let learned = self.learned.iter().map(|f| &f.frame.readings_ue[self.channels.clone()]);
        Ok(match known {
            Known::None | Known::Ignored => OtherLoads::default(),
            Known::Computed => computed.clone(),
            Known::Learned => {
                let frames: Vec<f64> = learned.flatten().copied().collect();
                OtherLoads::learned(&frames, gauge_sd, MARGIN)?
            }
            Known::Given => fitted(&self.learned, learned.collect(), &self.spec_sd)?,
        })
    }

    /// Frames with contacts, and without where it is known what loads are.
    fn rows(&self, estimator: &ContactEstimator, known: Known) -> Result<Vec<Loaded>> {
        let name = |what: &str| format!("{what}, {}, {}", self.gauges, known.name());
        let (singles, doubles) = match known {
            Known::None => (self.singles.clone(), self.doubles.clone()),
            _ => (
                self.seen(&self.loaded_singles, estimator, known)?,
                self.seen(&self.loaded_doubles, estimator, known)?,
            ),
        };
        let found =
            |frames: &[Frame]| score(estimator, self.channels.clone(), frames, |_, _, _, _| Ok(()));
        let bound_mm = Some(bound_mm(estimator, &singles)?);
        let (single, double) =
            (found(&singles)?.row(&name("single")), found(&doubles)?.row(&name("double")));
        let mut rows = vec![
            Loaded { row: single, n_false: None, bound_mm },
            Loaded { row: double, n_false: None, bound_mm: None },
        ];
        let untouched = match known {
            Known::None | Known::Ignored => return Ok(rows),
            // most of them are searched for contacts, which takes long: as many as of the others show that
            Known::Computed => &self.untouched[..self.singles.len()],
            Known::Learned | Known::Given => &self.untouched[..],
        };
        let frames = self.seen(untouched, estimator, known)?;
        let mut n_false = 0;
        let scored = score(estimator, self.channels.clone(), &frames, |_, _, _, found| {
            n_false += usize::from(found.contacts.iter().any(|c| c.force_n > COUNTED_N));
            Ok(())
        })?;
        let row = scored.row(&name("untouched"));
        rows.push(Loaded { row, n_false: Some(n_false), bound_mm: None });
        Ok(rows)
    }

    /// Frames as the estimator gets them: what is measured of loads that are given is taken off.
    fn seen(
        &self,
        frames: &[LoadedFrame],
        estimator: &ContactEstimator,
        known: Known,
    ) -> Result<Vec<Frame>> {
        let seen = |loaded: &LoadedFrame| {
            let mut frame = loaded.frame.clone();
            if known == Known::Given {
                let readings = &mut frame.readings_ue[self.channels.clone()];
                estimator.loads().take_off(&loaded.measured, readings)?;
            }
            Ok(frame)
        };
        frames.iter().map(seen).collect()
    }
}

fn on_layout(bench: &mut Bench<'_>, layout: Layout, gauges: &'static str) -> Result<Vec<Loaded>> {
    let (params, n_presses) = (bench.params(), bench.args.presses);
    let spec = bench.run.scene.loads.clone().unwrap_or_default();
    let error = bench.run.scene.estimator.superposition().map_error;
    let (sites, glued) = bench.rig.gauges(layout);
    let computed = other_loads(bench.limb, sites, glued, &spec, error, bench.run.threads)?;
    let plain = bench.map(layout, n_presses)?.estimator(params)?;
    let frames = Frames::draw(bench, layout, gauges)?;
    let mut rows = Vec::new();
    for known in [Known::None, Known::Ignored, Known::Computed, Known::Learned, Known::Given] {
        bench.run.say(&format!("{gauges}, loads {}", known.name()));
        let loads = frames.loads(known, &computed, plain.gauge_sd())?;
        rows.extend(frames.rows(&plain.with_loads(loads)?, known)?);
    }
    Ok(rows)
}

/// Median bound of the position of single contacts, mm.
fn bound_mm(estimator: &ContactEstimator, frames: &[Frame]) -> Result<f64> {
    let mut all = Vec::new();
    for frame in frames {
        let truth: Vec<_> = frame.contacts.iter().map(|c| (c.point, c.force_n)).collect();
        let bounds = joint_bounds(estimator, &truth)?;
        all.push(bounds.map_or(f64::INFINITY, |bounds| bounds[0].position_sd_m * 1e3));
    }
    Ok(median(all))
}

/// A frame beside loads, their amounts and what is measured of them.
pub(super) struct LoadedFrame {
    frame: Frame,
    measured: Vec<f64>,
}

impl Drawn<'_> {
    /// Frames of these contacts beside loads; `row` seeds noise and loads.
    fn loaded(&self, drawn: Vec<Vec<TrueContact>>, row: u64) -> Result<Vec<LoadedFrame>> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed.wrapping_add(row));
        let spec = self.scene.loads.clone().unwrap_or_default();
        let loads: Vec<LimbLoad> = spec.loads().into_iter().map(|(load, _)| load).collect();
        let amounts: Vec<Vec<f64>> = drawn.iter().map(|_| amounts(&loads, &mut rng)).collect();
        let frames = self.world.loaded_frames(drawn, &amounts, row)?;
        let measured = |amounts: Vec<f64>| -> Vec<f64> {
            let mut error = || -> f64 { StandardNormal.sample(&mut rng) };
            amounts.into_iter().map(|a| a * (1.0 + GIVEN_ERROR * error())).collect()
        };
        let both = frames.into_iter().zip(amounts.into_iter().map(measured));
        Ok(both.map(|(frame, measured)| LoadedFrame { frame, measured }).collect())
    }
}

fn amounts(loads: &[LimbLoad], rng: &mut ChaCha8Rng) -> Vec<f64> {
    let mut anywhere = |size: f64| Vector3::from(UnitSphere.sample(rng)) * size;
    let (force, moment) = (anywhere(FORCE_N), anywhere(MOMENT_NM));
    let specific = anywhere(GRAVITY_M_S2) - anywhere(GRAVITY_M_S2) + anywhere(GRAVITY_M_S2);
    let amount = |load: &LimbLoad| match *load {
        LimbLoad::FlangeForce(i) => force[i],
        LimbLoad::FlangeMoment(i) => moment[i],
        LimbLoad::SpecificForce(i) => specific[i],
        _ => 0.0,
    };
    loads.iter().map(amount).collect()
}

/// The response that explains untouched frames best by what was measured of the loads, by least squares; the
/// loads are as sure as they are measured.
fn fitted(frames: &[LoadedFrame], readings: Vec<&[f64]>, sd: &[f64]) -> Result<OtherLoads> {
    let (n, n_loads, m) = (frames.len(), sd.len(), readings[0].len());
    let loads = DMatrix::from_fn(n, n_loads, |i, k| frames[i].measured[k]);
    let read = DMatrix::from_fn(n, m, |i, g| readings[i][g]);
    let response = loads.svd(true, true).solve(&read, 1e-12).map_err(anyhow::Error::msg)?;
    Ok(OtherLoads {
        response: response.transpose().as_slice().to_vec(),
        sd: sd.iter().map(|sd| GIVEN_ERROR * sd).collect(),
    })
}
