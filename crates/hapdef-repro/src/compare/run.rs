//! The comparison, row by row.

use anyhow::Result;
use clap::Args;
use hapdef::touch::{
    LayoutParams, UncertainParams, UncertainResponse, estimator_params, study_layouts,
};
use hapdef::{Limb, Run, SceneArgs};
use hapdef_bench::Measurements;
use hapdef_bench::stats::{mean, quantile};
use hapdef_inverse::{ContactEstimator, EstimatorParams, NoiseParams, tip_ring_m};
use hapdef_sim::{GaugeSite, GaugeStrain};

use super::arrivals;
use super::cells::{self, Map};
use super::paper::{PaperPipeline, Ranking, VirtualGauges};
use super::score::{Row, Score};
use super::tables;
use super::world::{Draw, Frame, World, map_refinements};

/// Gauges of the layout for the static triple.
const N_MORE: usize = 16;

/// Their least distance from the edges of the wall, m; nearer ones may lie beyond it on the rig.
const MARGIN_M: f64 = 1e-3;

/// Presses of the calibration by few.
const N_FEW: usize = 300;

/// Largest friction coefficient of the friction row, and its tip: 8 mm across.
const FRICTION: f64 = 0.2;
const WIDE_TIP_M: f64 = 0.004;

/// Frames on which the covariance is judged.
const N_COVERAGE: usize = 10_000;

/// Stiffness modes of a calibration.
pub(crate) const N_STIFFNESS: usize = 32;

/// Arguments of `compare`.
#[derive(Args, Clone, Debug)]
pub(crate) struct CompareArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Frames of each row.
    #[arg(long, default_value_t = 400)]
    frames: usize,
    /// Seed of the presses and frames; nothing was tuned on the default.
    #[arg(long, default_value_t = 7000)]
    test_seed: u64,
    /// Scripts of each row of contacts that are followed.
    #[arg(long, default_value_t = 200)]
    scripts: usize,
    /// Presses that the map is calibrated with where nothing else is said, 300 at least.
    #[arg(long, default_value_t = 3000, value_parser = at_least_few)]
    presses: usize,
    /// Leave the paper's pipeline out: no compliance, no datasets, no nets.
    #[arg(long)]
    without_paper: bool,
}

fn at_least_few(word: &str) -> Result<usize, String> {
    let n: usize = word.parse().map_err(|_| "expected a number".to_owned())?;
    if n < N_FEW {
        return Err(format!("expected {N_FEW} at least"));
    }
    Ok(n)
}

impl CompareArgs {
    pub(super) fn scene(&self) -> &SceneArgs {
        &self.scene
    }

    pub(super) fn without_paper(&self) -> bool {
        self.without_paper
    }
}

/// Everything that was measured.
#[derive(Clone, Debug, Default)]
pub(crate) struct Measured {
    pub(crate) rows: Vec<Row>,
    pub(crate) coverage95_pct: Option<f64>,
    pub(crate) bound_ratio: Option<f64>,
    /// Presses that the map is calibrated with where nothing else is said.
    pub(crate) n_presses: usize,
    /// Relative errors of the maps at presses they were not calibrated with: with all presses,
    /// 300, and none.
    pub(crate) map_errors: [f64; 3],
    /// Times of all frames of contacts that arrive one after another, µs, rising.
    pub(crate) tracking_us: Vec<f64>,
    /// Name of the paper's better row on doubles.
    pub(crate) best_paper: Option<String>,
}

/// Measures, prints and writes the comparison.
pub(crate) fn run(args: &CompareArgs) -> Result<()> {
    let run = args.scene.prepare()?;
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let bench = Bench::build(&run, &limb, args)?;
    let mut measured = Measured { n_presses: args.presses, ..Measured::default() };
    bench.by_superposition(&mut measured)?;
    if !args.without_paper {
        bench.by_the_paper(&mut measured)?;
    }
    tables::write(&run, &args.scene.out, args.test_seed, &measured)
}

impl Measured {
    pub(super) fn add(&mut self, name: &str, score: &Score) {
        self.rows.push(score.row(name));
    }
}

impl Measurements for Measured {
    type Row = Row;

    fn row(&self, name: &str) -> Option<&Row> {
        self.rows.iter().find(|row| row.name == name)
    }
}

/// The rig, the training side's responses, the frames.
pub(super) struct Bench<'a> {
    run: &'a Run,
    limb: &'a Limb,
    args: &'a CompareArgs,
    world: World,
    ten: UncertainResponse,
    more: UncertainResponse,
}

impl<'a> Bench<'a> {
    pub(super) fn build(run: &'a Run, limb: &'a Limb, args: &'a CompareArgs) -> Result<Self> {
        let params = UncertainParams {
            tip_radius_m: run.scene.contact.tip_radius_m,
            refinements: map_refinements(run),
            n_stiffness: N_STIFFNESS,
            n_threads: run.threads,
        };
        run.say("solving the response and what may change it");
        let ten = UncertainResponse::solve(limb, &limb.sites, &limb.gauges, &params)?;
        let (sites, gauges) = placed_gauges(run, limb, N_MORE, MARGIN_M)?;
        let more = UncertainResponse::solve(limb, &sites, &gauges, &params)?;
        run.say("solving the simulated real limb");
        let world = World::build(run, limb, ten.map.skin(), &sites)?;
        Ok(Self { run, limb, args, world, ten, more })
    }

    pub(super) fn run(&self) -> &Run {
        self.run
    }

    pub(super) fn world(&self) -> &World {
        &self.world
    }

    pub(super) fn n_scripts(&self) -> usize {
        self.args.scripts
    }

    pub(super) fn n_presses(&self) -> usize {
        self.args.presses
    }

    pub(super) fn test_seed(&self) -> u64 {
        self.args.test_seed
    }

    pub(super) fn params(&self) -> EstimatorParams {
        estimator_params(&self.run.scene)
    }

    /// The scene's gauges, calibrated with all presses.
    pub(super) fn calibrated(&self) -> Result<Map> {
        self.calibrate(&self.ten, &self.presses()?, 0..self.limb.gauges.len())
    }

    fn presses(&self) -> Result<Vec<Frame>> {
        let range = self.run.scene.contact.force_range_n;
        cells::presses(&self.world, &mut self.draw(1), self.args.presses, range)
    }

    /// Frames of a row are drawn from a seed of their own.
    pub(super) fn draw(&self, row: u64) -> Draw<'_> {
        Draw::new(self.ten.map.skin(), self.args.test_seed.wrapping_add(row))
    }

    fn calibrate(
        &self,
        response: &UncertainResponse,
        presses: &[Frame],
        channels: std::ops::Range<usize>,
    ) -> Result<Map> {
        self.run.say(&format!("calibrating with {} presses", presses.len()));
        let steps = self.world.resolution_ue()?;
        let noise = NoiseParams {
            quantisation_step: steps[channels.clone()].to_vec(),
            ..NoiseParams::uniform(channels.len(), self.run.scene.rig.electronics.noise_ue)
        };
        Map::calibrate(response, presses, channels, noise, self.run.threads)
    }

    fn by_superposition(&self, measured: &mut Measured) -> Result<()> {
        let n_gauges = self.limb.gauges.len();
        let presses = self.presses()?;
        let many = self.calibrate(&self.ten, &presses, 0..n_gauges)?;
        let few = self.calibrate(&self.ten, &presses[..N_FEW], 0..n_gauges)?;
        measured.map_errors = [&many, &few, &few].map(|m| m.calibrated.info.relative_error);
        measured.map_errors[2] = many.calibrated.info.relative_error_before;
        self.static_rows(&many, &few, measured)?;
        arrivals::add(self, &many, measured)?;
        let n_all = n_gauges + N_MORE;
        let more = self.calibrate(&self.more, &presses, n_gauges..n_all)?;
        for (k, name) in [(3, "triple, 16 gauges"), (4, "quadruple, 16 gauges")] {
            let estimator = more.estimator(self.params())?;
            let frames = self.apart(k, 30 + k as u64)?;
            measured.add(name, &more.score(&estimator, &frames)?);
            let given = EstimatorParams { known_count: Some(k), ..self.params() };
            let told = more.estimator(given)?;
            measured.add(&format!("{name}, count given"), &more.score(&told, &frames)?);
        }
        Ok(())
    }

    fn static_rows(&self, many: &Map, few: &Map, measured: &mut Measured) -> Result<()> {
        let estimator = many.estimator(self.params())?;
        let (singles, doubles) = (self.singles(self.args.frames)?, self.doubles()?);
        measured.add("single", &many.score(&estimator, &singles)?);
        measured.add("double", &many.score(&estimator, &doubles)?);
        measured.add("triple", &many.score(&estimator, &self.apart(3, 13)?)?);
        measured.add("quadruple", &many.score(&estimator, &self.apart(4, 14)?)?);
        let of_few = few.estimator(self.params())?;
        measured.add("single, 300 presses", &few.score(&of_few, &singles)?);
        measured.add("double, 300 presses", &few.score(&of_few, &doubles)?);
        let ring_m = tip_ring_m(WIDE_TIP_M, self.run.scene.contact.tip_radius_m);
        let told = many.estimator_told(self.params(), FRICTION, ring_m)?;
        let rough = self.rough_doubles()?;
        measured.add("double, friction and wide tip", &many.score(&told, &rough)?);
        self.honesty(many, &estimator, measured)
    }

    /// Coverage of the 95 % regions over many frames, and how near the bound is.
    fn honesty(
        &self,
        many: &Map,
        estimator: &ContactEstimator,
        measured: &mut Measured,
    ) -> Result<()> {
        self.run.say("judging the covariance");
        let singles = self.singles(N_COVERAGE)?;
        let score = many.score(estimator, &singles)?;
        measured.coverage95_pct = score.coverage_with(&Score::default());
        measured.add("single, many frames", &score);
        let n = self.args.frames.min(singles.len());
        measured.bound_ratio = many.bound_ratio(estimator, &singles[..n])?;
        Ok(())
    }

    fn by_the_paper(&self, measured: &mut Measured) -> Result<()> {
        let mut paper = PaperPipeline::train(self.run, self.limb)?;
        let (singles, doubles) = (self.singles(self.args.frames)?, self.doubles()?);
        for (what, frames) in [("single", singles), ("double", doubles)] {
            for of in [VirtualGauges::Transferred, VirtualGauges::Exact] {
                let mut rows = self.paper_rows(&mut paper, &frames, of)?;
                for row in &mut rows {
                    row.name.push_str(&format!(", {what}"));
                }
                rows.sort_by(|a, b| a.mean_mm.total_cmp(&b.mean_mm));
                if of == VirtualGauges::Transferred {
                    measured.best_paper = rows.first().map(|row| row.name.clone());
                }
                measured.rows.extend(rows);
            }
        }
        Ok(())
    }

    /// The paper's pipeline on frames, a row for each ranking.
    pub(super) fn paper_rows(
        &self,
        paper: &mut PaperPipeline,
        frames: &[Frame],
        of: VirtualGauges,
    ) -> Result<Vec<Row>> {
        let (skin, n_gauges) = (self.ten.map.skin(), self.limb.gauges.len());
        let row = |ranking: Ranking| {
            let score = paper.score(skin, frames, n_gauges, of, ranking)?;
            Ok(score.row(&format!("{}, {}", of.name(), ranking.name())))
        };
        Ranking::ALL.into_iter().map(row).collect()
    }

    fn singles(&self, n: usize) -> Result<Vec<Frame>> {
        let strongest = self.run.scene.contact.force_range_n[1];
        let drawn = cells::singles(&mut self.draw(11), n, [5.0, strongest]);
        self.world.frames(drawn, 11)
    }

    fn doubles(&self) -> Result<Vec<Frame>> {
        let (presses, range) = (&self.run.scene.rig.presses, self.run.scene.contact.force_range_n);
        let n = self.args.frames;
        let drawn = cells::doubles(&mut self.draw(12), n, presses, range, 0.0);
        self.world.frames(drawn, 12)
    }

    fn rough_doubles(&self) -> Result<Vec<Frame>> {
        let (presses, range) = (&self.run.scene.rig.presses, self.run.scene.contact.force_range_n);
        let n = self.args.frames;
        let drawn = cells::doubles(&mut self.draw(20), n, presses, range, FRICTION);
        self.world.frames_under(drawn, WIDE_TIP_M, 20)
    }

    /// `k` contacts of 5 N to the strongest, 20 mm apart.
    pub(super) fn apart(&self, k: usize, row: u64) -> Result<Vec<Frame>> {
        let forces = [[5.0, self.run.scene.contact.force_range_n[1]]; 4];
        let n = self.args.frames;
        let gap_m = [0.02, f64::MAX];
        let drawn = cells::sets(&mut self.draw(row), n, k, forces, gap_m, 0.0);
        self.world.frames(drawn, row)
    }
}

/// `n_gauges` gauges where log-det puts them, no nearer than `margin_m` to the edges of the wall.
pub(crate) fn placed_gauges(
    run: &Run,
    limb: &Limb,
    n_gauges: usize,
    margin_m: f64,
) -> Result<(Vec<GaugeSite>, Vec<GaugeStrain>)> {
    let params = LayoutParams {
        n_gauges,
        margin_m,
        noise_ue: run.scene.rig.electronics.noise_ue,
        seed: run.scene.seed,
        compares: false,
        other_counts: Vec::new(),
        ..LayoutParams::default()
    };
    let study = study_layouts(run, limb, &params)?;
    let mut sites = Vec::with_capacity(n_gauges);
    let mut gauges = Vec::with_capacity(n_gauges);
    for placed in study.layouts.last().map_or(&[][..], |layout| &layout.gauges) {
        let site = run.scene.gauges.site(placed.position_m, placed.axis);
        let faces = &limb.boundary.faces;
        gauges.push(GaugeStrain::with_params(&limb.mesh, faces, &site, &limb.gauge_params)?);
        sites.push(site);
    }
    Ok((sites, gauges))
}

/// The mean position error of the paper's pipeline with two contacts over superposition's.
pub(super) fn double_vs_paper(measured: &Measured) -> Option<f64> {
    let paper = measured.row(measured.best_paper.as_ref()?)?;
    Some(paper.mean_mm / measured.row("double")?.mean_mm)
}

/// The time of a frame of the paper's pipeline over that of a followed one.
pub(super) fn time_vs_paper(measured: &Measured) -> Option<f64> {
    let rows = measured.rows.iter().filter(|r| r.name.starts_with("paper"));
    let times: Vec<f64> = rows.map(|r| r.p50_us).collect();
    let paper_us = mean(times.iter().copied());
    (!times.is_empty()).then(|| paper_us / quantile(&measured.tracking_us, 0.5))
}
