//! The comparison, row by row.

use anyhow::Result;
use hapdef::Limb;
use hapdef_inverse::{ContactEstimator, EstimatorParams, tip_ring_m};

use super::arrivals;
use super::cells::Map;
use super::measured::Measured;
use super::paper::{PaperPipeline, VirtualGauges};
use super::setup::{Bench, CompareArgs, FRICTION, N_FEW, N_MORE, WIDE_TIP_M};
use super::tables;

/// Frames on which the covariance is judged.
const N_COVERAGE: usize = 10_000;

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
    tables::write(&run, &args.scene.out, args.test_seed, &measured)?;
    if args.diagnose {
        bench.diagnose(&args.scene.out)?;
    }
    Ok(())
}

impl Bench<'_> {
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
            let with_count = more.estimator(given)?;
            measured.add(&format!("{name}, count given"), &more.score(&with_count, &frames)?);
        }
        Ok(())
    }

    fn static_rows(&self, many: &Map, few: &Map, measured: &mut Measured) -> Result<()> {
        let estimator = many.estimator(self.params())?;
        let (drawn, n) = (self.drawn(), self.args.frames);
        let (singles, doubles) = (drawn.singles(n)?, drawn.doubles(n)?);
        measured.add("single", &many.score(&estimator, &singles)?);
        measured.add("double", &many.score(&estimator, &doubles)?);
        measured.add("triple", &many.score(&estimator, &self.apart(3, 13)?)?);
        measured.add("quadruple", &many.score(&estimator, &self.apart(4, 14)?)?);
        let of_few = few.estimator(self.params())?;
        measured.add("single, 300 presses", &few.score(&of_few, &singles)?);
        measured.add("double, 300 presses", &few.score(&of_few, &doubles)?);
        let ring_m = tip_ring_m(WIDE_TIP_M, self.run.scene.contact.tip_radius_m);
        let with_friction = many.estimator_with_friction(self.params(), FRICTION, ring_m)?;
        let rough = drawn.rough_doubles(n, FRICTION, WIDE_TIP_M)?;
        measured.add("double, friction and wide tip", &many.score(&with_friction, &rough)?);
        self.coverage(many, &estimator, measured)
    }

    /// Coverage of the 95 % regions over many frames, and how near the bound is.
    fn coverage(
        &self,
        many: &Map,
        estimator: &ContactEstimator,
        measured: &mut Measured,
    ) -> Result<()> {
        self.run.say("judging the covariance");
        let singles = self.drawn().singles(N_COVERAGE)?;
        let score = many.score(estimator, &singles)?;
        let row = score.row("single, many frames");
        measured.coverage95_pct = row.coverage95_pct;
        measured.rows.push(row);
        let n = self.args.frames.min(singles.len());
        measured.bound_ratio = many.bound_ratio(estimator, &singles[..n])?;
        Ok(())
    }

    fn by_the_paper(&self, measured: &mut Measured) -> Result<()> {
        let mut paper = PaperPipeline::train(self.run, self.limb)?;
        let (drawn, n) = (self.drawn(), self.args.frames);
        let (singles, doubles) = (drawn.singles(n)?, drawn.doubles(n)?);
        for (what, frames) in [("single", singles), ("double", doubles)] {
            for of in [VirtualGauges::Transferred, VirtualGauges::Exact] {
                let mut rows = self.paper_rows(&mut paper, &frames, of)?;
                for row in &mut rows {
                    row.name.push_str(&format!(", {what}"));
                }
                rows.sort_by(|a, b| a.errors.mean_mm.total_cmp(&b.errors.mean_mm));
                if of == VirtualGauges::Transferred {
                    measured.best_paper = rows.first().map(|row| row.name.clone());
                }
                measured.rows.extend(rows);
            }
        }
        Ok(())
    }
}
