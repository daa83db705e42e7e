//! The rows by superposition: what is pressed, and by what it is found.

use anyhow::Result;
use hapdef_inverse::{ContactEstimate, ContactEstimator, EstimatorParams, tip_ring_m};

use super::cells::{Map, score};
use super::rig::Layout;
use super::score::Score;
use super::setup::{Bench, MORE, N_FEW};
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
    /// The gauges of [`MORE`], all presses.
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

impl Bench<'_> {
    /// Those of the rows whose gauges there are.
    pub(super) fn possible<'a>(&self, cases: &'a [Case]) -> Vec<&'a Case> {
        cases.iter().filter(|case| self.has_more() || !matches!(case.on, On::More)).collect()
    }

    /// Finds the contacts of a row's frames, and shows `also` each frame with its estimate.
    pub(super) fn found(
        &mut self,
        case: &Case,
        also: impl FnMut(&ContactEstimator, &[f64], &Frame, &ContactEstimate) -> Result<()>,
    ) -> Result<Score> {
        self.run.say(case.name);
        let frames = self.pressed(&case.pressed)?;
        let (layout, n_presses) = match case.on {
            On::Many => (Layout::Scene, self.args.presses),
            On::Few => (Layout::Scene, N_FEW),
            On::More => (MORE, self.args.presses),
        };
        let own_tip_m = self.run.scene.contact.tip_radius_m;
        let params = self.params();
        let map = self.map(layout, n_presses)?;
        let estimator = estimator(map, case, params, own_tip_m)?;
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
}

fn estimator(
    map: &Map,
    case: &Case,
    params: EstimatorParams,
    own_tip_m: f64,
) -> Result<ContactEstimator> {
    match case.pressed {
        Pressed::RoughDoubles => {
            map.estimator_with_friction(params, FRICTION, tip_ring_m(WIDE_TIP_M, own_tip_m))
        }
        Pressed::Apart(k, _) if case.is_count_given => {
            map.estimator(EstimatorParams { known_count: Some(k), ..params })
        }
        _ => map.estimator(params),
    }
}
