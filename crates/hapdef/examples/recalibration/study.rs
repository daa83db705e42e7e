//! A limb whose gains drift, touched at known places, and how well its contacts are found meanwhile.

use std::fmt::{Display, Formatter};
use std::path::Path;

use anyhow::{Context, Result};
use hapdef::touch::{
    Calibration, DeclaredForce, DeclaredTouch, GainsSince, ProbeParams, ProbedPress, ProbedRig,
    Recalibrator, Superposition, TouchAssumptions, TouchScore,
};
use hapdef::{Limb, Profile, Progress, Run};
use hapdef_inverse::TouchZero;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

/// Touches after which contacts are looked for.
const LOOKS: [usize; 4] = [0, 10, 30, 100];

/// Each gain is off by up to this share when the first touch comes, and moves by up to as much until the last.
const DRIFT: f64 = 0.03;

/// One touch of so many is declared where it was not.
const EVERY_WRONG: usize = 10;

/// How well places and forces are known.
const POSITION_SD_M: f64 = 0.5e-3;
const FORCE_SD_N: f64 = 0.1;

/// Contacts after some touches, with or without what these showed.
#[derive(Clone, Debug)]
pub struct Row {
    /// What the estimator knows.
    pub name: String,
    /// Touches that were declared wrong and refused, right and refused, wrong and taken.
    pub n_refused: [usize; 3],
    /// Root mean square of the gains' error.
    pub gain_error: f64,
    /// The same in standard deviations as they are reported; none where no touch was taken.
    pub gain_error_sds: Option<f64>,
    /// Single presses, and two at a time.
    pub scores: [TouchScore; 2],
}

/// The drifting limb.
struct Drifting<'a> {
    run: &'a Run,
    limb: &'a Limb,
    /// When the first touch comes, and how much is added until the last `[n_gauges]`.
    gains: Vec<[f64; 2]>,
    /// Single presses, and two at a time, of gauges that have not drifted.
    tests: [Vec<ProbedPress>; 2],
}

/// Rows for a limb that does not drift, and for one that does without and with the touches so far.
pub fn study(scene: &Path, results: &Path, n_tests: usize) -> Result<Vec<Row>> {
    let run = Run::new(scene, Profile::quick(), results, 2, Progress::silent())?;
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let rig = ProbedRig::new(&run, &limb)?;
    let presses = |n_presses, n_contacts, seed| {
        rig.presses(&ProbeParams { n_presses, n_contacts, seed, n_rising: 0 })
    };
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut up_to = || rng.random_range(-DRIFT..=DRIFT);
    let gains = (0..limb.gauges.len()).map(|_| [up_to(), up_to()]).collect();
    let tests = [presses(n_tests, 1, 900)?, presses(n_tests / 2, 2, 901)?];
    let drifting = Drifting { run: &run, limb: &limb, gains, tests };
    let spec = run.scene.estimator.superposition();
    let named = run.scene_dir.join(spec.calibration.context("a scene with a calibration")?);
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("calibration.json");
    Calibration::read(&named, &limb)?.write(&path)?;
    drifting.rows(&path, &presses(LOOKS[3], 1, 902)?)
}

impl Drifting<'_> {
    fn rows(&self, path: &Path, presses: &[ProbedPress]) -> Result<Vec<Row>> {
        let pressed = Calibration::read(path, self.limb)?;
        let mut recalibrator = Recalibrator::open(path, self.limb)?;
        let mut rows = vec![self.row("no drift", &pressed, None, [0; 3])?];
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let mut n_refused = [0; 3];
        for n in 0..=presses.len() {
            if LOOKS.contains(&n) {
                let name = format!("none, at touch {n}");
                rows.push(self.row(&name, &pressed, Some(n), [0; 3])?);
                if n > 0 {
                    let now = recalibrator.calibration();
                    rows.push(self.row(&n.to_string(), &now, Some(n), n_refused)?);
                }
            }
            let Some(press) = presses.get(n) else {
                break;
            };
            let is_wrong = n % EVERY_WRONG == EVERY_WRONG - 1;
            let place = if is_wrong { &presses[n - 5] } else { press };
            let touch = self.declared(n, press, place.contacts[0].0, &mut rng)?;
            let taken = recalibrator.touch(&touch, &TouchAssumptions::default(), n as u64)?;
            match (is_wrong, taken.is_accepted) {
                (true, false) => n_refused[0] += 1,
                (false, false) => n_refused[1] += 1,
                (true, true) => n_refused[2] += 1,
                (false, true) => {}
            }
        }
        recalibrator.write()?;
        Ok(rows)
    }

    /// Relative change of each gain at a touch.
    fn gains_at(&self, touch: usize) -> Vec<f64> {
        let part = touch as f64 / LOOKS[3] as f64;
        self.gains.iter().map(|[first, more]| first + part * more).collect()
    }

    /// What the gauges read of a press at a touch.
    fn readings_ue(&self, press: &ProbedPress, touch: usize) -> Vec<f64> {
        let readings = press.frames_ue[0].iter().zip(self.gains_at(touch));
        readings.map(|(reading, gain)| reading * (1.0 + gain)).collect()
    }

    /// A touch as it is declared: force and place are as well known as is said.
    fn declared(
        &self,
        n: usize,
        press: &ProbedPress,
        place_m: [f64; 3],
        rng: &mut ChaCha8Rng,
    ) -> Result<DeclaredTouch> {
        let (along, force) = (Normal::new(0.0, POSITION_SD_M)?, Normal::new(0.0, FORCE_SD_N)?);
        Ok(DeclaredTouch {
            from: format!("touch {n}"),
            t_s: None,
            position_m: place_m.map(|x| x + along.sample(rng)),
            force: DeclaredForce::Normal(press.contacts[0].1 + force.sample(rng)),
            position_sd_m: POSITION_SD_M,
            force_sd_n: FORCE_SD_N,
            readings_ue: self.readings_ue(press, n),
            zero: TouchZero::Tared,
        })
    }

    /// Contacts by `calibration` at a touch; of gauges that have not drifted without one.
    fn row(
        &self,
        name: &str,
        calibration: &Calibration,
        touch: Option<usize>,
        n_refused: [usize; 3],
    ) -> Result<Row> {
        let (scene, spec) = (&self.run.scene, self.run.scene.estimator.superposition());
        let estimator = calibration.estimator(scene, &spec, self.limb)?;
        let score = |presses: &Vec<ProbedPress>| {
            let drifted = |press: &ProbedPress| match touch {
                Some(touch) => {
                    let frames_ue = vec![self.readings_ue(press, touch)];
                    ProbedPress { frames_ue, ..press.clone() }
                }
                None => press.clone(),
            };
            let presses: Vec<ProbedPress> = presses.iter().map(drifted).collect();
            TouchScore::of(&presses, || Ok(Superposition::new(estimator.clone())))
        };
        let (n, since) = (self.gains.len(), calibration.since.as_ref());
        let truth = touch.map_or_else(|| vec![0.0; n], |touch| self.gains_at(touch));
        let off = |i: usize| truth[i] - since.map_or(0.0, |since| since.gains[i]);
        let rms = |of: &dyn Fn(usize) -> f64| {
            ((0..n).map(|i| of(i).powi(2)).sum::<f64>() / n as f64).sqrt()
        };
        let in_sds = |since: &GainsSince| rms(&|i| off(i) / since.covariance[i * (n + 1)].sqrt());
        Ok(Row {
            name: name.to_owned(),
            n_refused,
            gain_error: rms(&off),
            gain_error_sds: since.map(in_sds),
            scores: [score(&self.tests[0])?, score(&self.tests[1])?],
        })
    }
}

impl Display for Row {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let [wrong, right, taken] = self.n_refused;
        let sds = self.gain_error_sds.map_or("–".to_owned(), |sds| format!("{sds:.1}"));
        let off_pct = 100.0 * self.gain_error;
        write!(f, "| {} | {wrong} | {right} | {taken} | {off_pct:.2} | {sds} |", self.name)?;
        for score in &self.scores {
            write!(f, " {:.2} | {:.1} |", score.median_mm, 100.0 * score.share_count_right)?;
        }
        Ok(())
    }
}
