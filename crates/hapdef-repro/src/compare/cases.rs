//! The rows by superposition: what is pressed, and by what it is found.

use anyhow::Result;
use hapdef_inverse::{ContactEstimate, ContactEstimator, EstimatorParams, tip_ring_m};

use super::cells::{Map, score};
use super::score::Score;
use super::setup::{Bench, N_FEW, N_MORE};
use super::world::Frame;

/// Frames on which the covariance is judged.
const N_COVERAGE: usize = 10_000;

/// Largest friction coefficient of the friction row, and its tip: 8 mm across.
const FRICTION: f64 = 0.2;
const WIDE_TIP_M: f64 = 0.004;

/// A row: frames, and the map that their contacts are found on.
pub(super) struct Case {
    pub(super) name: &'static str,
    on: On,
    pressed: Pressed,
    is_count_given: bool,
}

/// A calibrated map.
enum On {
    /// The scene's gauges, all presses.
    Many,
    /// The scene's gauges, [`N_FEW`] presses.
    Few,
    /// [`N_MORE`] gauges, all presses.
    More,
}

/// What presses.
enum Pressed {
    Singles,
    ManySingles,
    Doubles,
    /// The doubles with friction and under a wide tip; the covariance assumes both.
    RoughDoubles,
    /// So many contacts of 5 N to the strongest, 20 mm apart, and the seed of their row.
    Apart(usize, u64),
}

/// Rows before those of contacts that arrive.
pub(super) const CASES: [Case; 8] = [
    case("single", On::Many, Pressed::Singles),
    case("double", On::Many, Pressed::Doubles),
    case("triple", On::Many, Pressed::Apart(3, 13)),
    case("quadruple", On::Many, Pressed::Apart(4, 14)),
    case("single, 300 presses", On::Few, Pressed::Singles),
    case("double, 300 presses", On::Few, Pressed::Doubles),
    case("double, friction and wide tip", On::Many, Pressed::RoughDoubles),
    case("single, many frames", On::Many, Pressed::ManySingles),
];

/// Rows behind them.
pub(super) const CASES_OF_MORE_GAUGES: [Case; 4] = [
    case("triple, 16 gauges", On::More, Pressed::Apart(3, 33)),
    given("triple, 16 gauges, count given", On::More, Pressed::Apart(3, 33)),
    case("quadruple, 16 gauges", On::More, Pressed::Apart(4, 34)),
    given("quadruple, 16 gauges, count given", On::More, Pressed::Apart(4, 34)),
];

/// Rows whose frames are taken apart.
pub(super) const DIAGNOSED: [Case; 8] = [
    case("quadruple, 16 gauges", On::More, Pressed::Apart(4, 34)),
    given("quadruple, 16 gauges, count given", On::More, Pressed::Apart(4, 34)),
    case("triple, 16 gauges", On::More, Pressed::Apart(3, 33)),
    given("triple, 16 gauges, count given", On::More, Pressed::Apart(3, 33)),
    case("triple, 10 gauges", On::Many, Pressed::Apart(3, 13)),
    given("triple, 10 gauges, count given", On::Many, Pressed::Apart(3, 13)),
    case("double", On::Many, Pressed::Doubles),
    case("double, friction and wide tip", On::Many, Pressed::RoughDoubles),
];

const fn case(name: &'static str, on: On, pressed: Pressed) -> Case {
    Case { name, on, pressed, is_count_given: false }
}

const fn given(name: &'static str, on: On, pressed: Pressed) -> Case {
    Case { name, on, pressed, is_count_given: true }
}

/// The calibrated maps.
pub(super) struct Maps {
    pub(super) many: Map,
    few: Map,
    more: Map,
}

impl Maps {
    pub(super) fn calibrate(bench: &Bench<'_>) -> Result<Self> {
        let n_gauges = bench.limb.gauges.len();
        let presses = bench.presses()?;
        Ok(Self {
            many: bench.calibrate(&bench.ten, &presses, 0..n_gauges)?,
            few: bench.calibrate(&bench.ten, &presses[..N_FEW], 0..n_gauges)?,
            more: bench.calibrate(&bench.more, &presses, n_gauges..n_gauges + N_MORE)?,
        })
    }

    /// Relative errors of the scene's gauges' maps at presses they were not calibrated with: with all
    /// presses, with few, and none.
    pub(super) fn errors(&self) -> [f64; 3] {
        let [many, few] = [&self.many, &self.few].map(|map| &map.calibrated.info);
        [many.relative_error, few.relative_error, many.relative_error_before]
    }
}

impl Bench<'_> {
    /// Finds the contacts of a row's frames, and shows `also` each frame with its estimate.
    pub(super) fn found(
        &self,
        maps: &Maps,
        case: &Case,
        also: impl FnMut(&ContactEstimator, &[f64], &Frame, &ContactEstimate) -> Result<()>,
    ) -> Result<Score> {
        self.run.say(case.name);
        let map = match case.on {
            On::Many => &maps.many,
            On::Few => &maps.few,
            On::More => &maps.more,
        };
        let frames = self.pressed(&case.pressed)?;
        let estimator = self.estimator(map, case)?;
        score(&estimator, map.channels.clone(), &frames, also)
    }

    fn pressed(&self, pressed: &Pressed) -> Result<Vec<Frame>> {
        let (drawn, n) = (self.drawn(), self.args.frames);
        match *pressed {
            Pressed::Singles => drawn.singles(n),
            Pressed::ManySingles => drawn.singles(N_COVERAGE),
            Pressed::Doubles => drawn.doubles(n),
            Pressed::RoughDoubles => drawn.rough_doubles(n, FRICTION, WIDE_TIP_M),
            Pressed::Apart(k, row) => self.apart(k, row),
        }
    }

    fn estimator(&self, map: &Map, case: &Case) -> Result<ContactEstimator> {
        let params = self.params();
        match case.pressed {
            Pressed::RoughDoubles => {
                let ring_m = tip_ring_m(WIDE_TIP_M, self.run.scene.contact.tip_radius_m);
                map.estimator_with_friction(params, FRICTION, ring_m)
            }
            Pressed::Apart(k, _) if case.is_count_given => {
                map.estimator(EstimatorParams { known_count: Some(k), ..params })
            }
            _ => map.estimator(params),
        }
    }
}
