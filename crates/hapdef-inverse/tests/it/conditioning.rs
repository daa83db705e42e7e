//! What conditioning takes off, and what it leaves.

use hapdef_inverse::{
    Conditioned, Conditioner, ConditionerParams, DriftState, GaugeHealth, OtherLoads, TareEnd,
    TouchPhase,
};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const N: usize = 10;
const PERIOD_S: f64 = 0.001;

/// Gauges with noise of 1, whatever else `signal` says.
struct Rig {
    conditioner: Conditioner,
    out: Conditioned,
    rng: ChaCha8Rng,
    t_s: f64,
}

impl Rig {
    fn new(change: impl Fn(&mut ConditionerParams)) -> Self {
        let mut params = ConditionerParams::new(vec![1.0; N], PERIOD_S);
        change(&mut params);
        let conditioner = Conditioner::new(params).unwrap();
        Self { out: conditioner.output(), conditioner, rng: ChaCha8Rng::seed_from_u64(3), t_s: 0.0 }
    }

    /// Frames for `seconds`; the last one's output stays.
    fn run(
        &mut self,
        seconds: f64,
        temperature_k: impl Fn(f64) -> Option<f64>,
        signal: impl Fn(usize, f64) -> f64,
    ) {
        for _ in 0..(seconds / PERIOD_S).round() as usize {
            let raw: Vec<f64> = (0..N)
                .map(|gauge| {
                    let n: f64 = StandardNormal.sample(&mut self.rng);
                    signal(gauge, self.t_s) + n
                })
                .collect();
            self.step(&raw, temperature_k(self.t_s));
        }
    }

    fn step(&mut self, raw: &[f64], temperature_k: Option<f64>) {
        self.conditioner.step_into(raw, temperature_k, &mut self.out).unwrap();
        self.t_s += PERIOD_S;
    }

    /// Mean readings over `seconds`.
    fn mean(
        &mut self,
        seconds: f64,
        temperature_k: impl Fn(f64) -> Option<f64>,
        signal: impl Fn(usize, f64) -> f64,
    ) -> Vec<f64> {
        let n = (seconds / PERIOD_S).round() as usize;
        let mut sums = vec![0.0; N];
        for _ in 0..n {
            self.run(PERIOD_S, &temperature_k, &signal);
            sums.iter_mut().zip(&self.out.readings).for_each(|(s, r)| *s += r / n as f64);
        }
        sums
    }
}

fn offset(gauge: usize) -> f64 {
    100.0 - 30.0 * gauge as f64
}

/// A contact of some tens of units, on some gauges hardly seen.
fn contact(gauge: usize) -> f64 {
    40.0 * (1.3 * gauge as f64).cos()
}

#[test]
fn a_contact_of_minutes_is_not_eaten() {
    let mut rig = Rig::new(|_| ());
    rig.run(2.0, |_| None, |g, _| offset(g));
    assert_eq!(rig.out.phase, TouchPhase::Untouched);
    rig.run(180.0, |_| None, |g, _| offset(g) + contact(g));
    assert_eq!(rig.out.phase, TouchPhase::Touched);
    let mean = rig.mean(0.5, |_| None, |g, _| offset(g) + contact(g));
    for (gauge, found) in mean.iter().enumerate() {
        // the tare is the mean of 200 frames: 0.07; the frames here add 0.04
        assert!((found - contact(gauge)).abs() < 0.4, "{gauge}: {found}");
    }
    rig.run(1.0, |_| None, |g, _| offset(g));
    assert_eq!(rig.out.phase, TouchPhase::Untouched);
}

#[test]
fn drift_before_a_contact_is_taken_off() {
    let drift = |g: usize, t: f64| offset(g) + 0.05 * t * (g as f64 - 4.5);
    let mut rig = Rig::new(|p| p.drift_sd = 0.1);
    rig.run(60.0, |_| None, drift);
    assert_eq!(rig.out.phase, TouchPhase::Untouched);
    let held = |g: usize, _: f64| drift(g, 60.0) + contact(g);
    let mean = rig.mean(0.5, |_| None, held);
    for (gauge, found) in mean.iter().enumerate() {
        // a ramp of 0.225 per second, and a filter that lags it by half a second
        assert!((found - contact(gauge)).abs() < 0.8, "{gauge}: {found}, {}", contact(gauge));
    }
}

#[test]
fn temperature_is_learned_and_taken_off_during_a_contact() {
    let slope = |g: usize| 1.5 - 0.3 * g as f64;
    let temperature =
        |t: f64| 20.0 + (0.3 * t).sin() * 2.0 + if t > 60.0 { (t - 60.0) * 0.1 } else { 0.0 };
    let free = |g: usize, t: f64| offset(g) + slope(g) * temperature(t);
    let mut rig = Rig::new(|p| p.temperature_sd = 3.0);
    rig.run(60.0, |t| Some(temperature(t)), free);
    assert_eq!(rig.out.phase, TouchPhase::Untouched);
    let held = |g: usize, t: f64| free(g, t) + contact(g);
    rig.run(40.0, |t| Some(temperature(t)), held);
    let mean = rig.mean(0.5, |t| Some(temperature(t)), held);
    for (gauge, found) in mean.iter().enumerate() {
        assert!((found - contact(gauge)).abs() < 0.8, "{gauge}: {found}");
    }
}

#[test]
fn creep_after_a_contact_is_not_seen_as_one() {
    let part = 0.03;
    // a contact from 5 to 65 s, then its creep recovers
    let creep = |g: usize, t: f64| {
        let grown = |since: f64| if since > 0.0 { (1.0 + since).ln() } else { 0.0 };
        offset(g) + part * contact(g) * (grown(t - 5.0) - grown(t - 65.0))
    };
    let signal = |g: usize, t: f64| {
        let held = (5.0..65.0).contains(&t);
        creep(g, t) + if held { contact(g) } else { 0.0 }
    };
    let mut with = Rig::new(|p| p.creep_sd = 0.05);
    with.run(75.0, |_| None, signal);
    assert_eq!(with.out.phase, TouchPhase::Untouched);
    let mean = with.mean(0.5, |_| None, signal);
    let worst = mean.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    assert!(worst < 0.6, "{worst} left of the creep");
}

#[test]
fn faults_are_masked_and_recover() {
    let mut rig = Rig::new(|p| p.rails = vec![(-500.0, 500.0); N]);
    rig.run(1.0, |_| None, |g, _| offset(g));
    let frame =
        |change: &dyn Fn(usize) -> f64| (0..N).map(|g| offset(g) + change(g)).collect::<Vec<_>>();
    let mut raw = frame(&contact);
    raw[2] = 500.0;
    raw[3] = f64::NAN;
    rig.step(&raw, None);
    assert_eq!(rig.out.health[2], GaugeHealth::Saturated);
    assert_eq!(rig.out.health[3], GaugeHealth::NotFinite);
    assert!(rig.out.is_mask_new && !rig.out.live[2] && rig.out.readings[3] == 0.0);
    rig.run(0.2, |_| None, |g, _| offset(g) + contact(g));
    assert!(rig.out.live.iter().all(|l| *l), "{:?}", rig.out.health);
}

#[test]
fn a_jump_of_one_gauge_is_held_back_and_then_believed() {
    let mut rig = Rig::new(|_| ());
    rig.run(1.0, |_| None, |g, _| offset(g));
    let jump = |g: usize, _: f64| offset(g) + if g == 4 { 200.0 } else { 0.0 };
    rig.run(PERIOD_S, |_| None, jump);
    assert_eq!(rig.out.health[4], GaugeHealth::Spike);
    assert_eq!(rig.out.phase, TouchPhase::Untouched);
    rig.run(5.0 * PERIOD_S, |_| None, jump);
    assert_eq!(rig.out.health[4], GaugeHealth::Good);
    assert_eq!(rig.out.phase, TouchPhase::Touched);
}

#[test]
fn a_gauge_that_repeats_itself_while_others_move_is_dead() {
    let rig = repeating(|_| ());
    assert_eq!(rig.out.health[6], GaugeHealth::Dead);
    assert_eq!(rig.out.live.iter().filter(|l| !**l).count(), 1);
}

/// Steps beyond the noise repeat a value where the contact hardly loads the gauge.
#[test]
fn a_gauge_of_a_coarse_converter_may_repeat_itself() {
    let rig = repeating(|params| params.coarse = (0..N).map(|g| g == 6).collect());
    assert_eq!(rig.out.health[6], GaugeHealth::Good);
}

/// Gauge 6 repeats its value for 300 frames of a contact.
fn repeating(change: impl Fn(&mut ConditionerParams)) -> Rig {
    let mut rig = Rig::new(change);
    rig.run(1.0, |_| None, |g, _| offset(g));
    for i in 0..300 {
        let mut raw: Vec<f64> =
            (0..N).map(|g| offset(g) + contact(g) + f64::from(i % 7) * 0.3).collect();
        raw[6] = offset(6);
        rig.step(&raw, None);
    }
    rig
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// Adding a constant to every raw value changes nothing.
    #[test]
    fn offsets_do_not_matter(shift in -500.0..500.0, force in 0.2..3.0) {
        let play = |shift: f64| {
            let mut rig = Rig::new(|_| ());
            rig.run(0.6, |_| None, |g, _| offset(g) + shift);
            rig.run(0.4, |_| None, |g, _| offset(g) + shift + force * contact(g));
            rig.out
        };
        let (a, b) = (play(0.0), play(shift));
        prop_assert_eq!(a.phase, b.phase);
        for (a, b) in a.readings.iter().zip(&b.readings) {
            prop_assert!((a - b).abs() < 1e-9);
        }
    }

    /// Untouched noise is hardly ever taken for a contact.
    #[test]
    fn noise_is_no_contact(seed in 0_u64..1000) {
        let mut rig = Rig::new(|_| ());
        rig.rng = ChaCha8Rng::seed_from_u64(seed);
        rig.run(3.0, |_| None, |g, _| offset(g));
        prop_assert_eq!(rig.out.phase, TouchPhase::Untouched);
    }
}

/// Frames of `seconds` in which something touches, and the largest mean reading over 64 of them.
fn worst_of(rig: &mut Rig, seconds: f64, signal: impl Fn(usize, f64) -> f64) -> (usize, f64) {
    let (mut n_touched, mut slow, mut worst) = (0, vec![0.0; N], 0.0_f64);
    for _ in 0..(seconds / PERIOD_S).round() as usize {
        rig.run(PERIOD_S, |_| None, &signal);
        n_touched += usize::from(rig.out.phase == TouchPhase::Touched);
        for (slow, reading) in slow.iter_mut().zip(&rig.out.readings) {
            *slow += (reading - *slow) / 64.0;
            worst = worst.max(slow.abs());
        }
    }
    (n_touched, worst)
}

/// A press that grows during the tare, one that begins in it, a tap in it: refused, and the zero before stays.
#[test]
fn a_tare_whose_readings_move_is_refused() {
    let rise = |t: f64| (t / 0.2).clamp(0.0, 1.0);
    let step = |t: f64| f64::from(t > 0.15);
    let tap = |t: f64| f64::from((0.08..0.11).contains(&t));
    let moves: [(&str, &dyn Fn(f64) -> f64); 3] = [("rise", &rise), ("step", &step), ("tap", &tap)];
    for (what, part) in moves {
        let mut rig = Rig::new(|_| ());
        let touched = |g: usize, t: f64| offset(g) + contact(g) * part(t);
        rig.run(0.2, |_| None, touched);
        let Some(TareEnd::Refused(found)) = rig.out.tare_end else { panic!("{what}") };
        assert!(found.by.abs() > 5.0, "{what}: {found:?}");
        assert_eq!(rig.out.phase, TouchPhase::Taring);
        // it began again by itself, and what it began with is remembered
        rig.run(0.2, |_| None, |g, _| offset(g) + contact(g));
        assert_eq!(rig.out.tare_end, Some(TareEnd::Taken));
        let shift = rig.conditioner.tare_shift().unwrap();
        let seen = shift.iter().zip(0..).map(|(s, g)| s * contact(g)).sum::<f64>();
        assert!(seen > 0.0, "{what}: {shift:?}");
        // where there was a zero, it stays
        let mut rig = Rig::new(|_| ());
        rig.run(1.0, |_| None, |g, _| offset(g));
        rig.conditioner.tare();
        let start_s = rig.t_s;
        rig.run(0.2, |_| None, |g, t| touched(g, t - start_s));
        assert!(matches!(rig.out.tare_end, Some(TareEnd::Refused(_))), "{what}");
        let mean = rig.mean(0.2, |_| None, |g, _| offset(g) + contact(g));
        for (gauge, found) in mean.iter().enumerate() {
            assert!((found - contact(gauge)).abs() < 0.4, "{what}, {gauge}: {found}");
        }
    }
}

/// At the limit, in the directions that drift has, from the tare on and from later on.
#[test]
fn drift_up_to_the_limit_is_followed() {
    let up = |_: usize| 1.0;
    let alternating = |g: usize| if g.is_multiple_of(2) { 1.0 } else { -1.0 };
    let one = |g: usize| if g == 3 { 2.5 } else { 0.0 };
    let common = |_: usize| -2.5;
    let directions: [(&dyn Fn(usize) -> f64, f64); 6] = [
        (&up, 0.0),
        (&alternating, 0.0),
        (&alternating, 5.0),
        (&one, 0.0),
        (&common, 0.0),
        (&up, 5.0),
    ];
    for (k, (direction, start_s)) in directions.into_iter().enumerate() {
        let mut rig = Rig::new(|_| ());
        let drift = |g: usize, t: f64| offset(g) + direction(g) * (t - start_s).max(0.0);
        rig.run(0.2, |_| None, drift);
        assert_eq!(rig.out.tare_end, Some(TareEnd::Taken), "{k}");
        let (n_touched, worst) = worst_of(&mut rig, 60.0, drift);
        println!("{k}: {n_touched} frames touched, {worst:.2} µε left at most");
        assert_eq!(n_touched, 0, "{k}");
        // what it drifts by until that is seen, with the noise of the mean
        let fastest = (0..N).map(|g| direction(g).abs()).fold(0.0, f64::max);
        assert!(worst < 0.45 + 0.35 * fastest, "{k}: {worst}");
        // what presses then is read as it is
        let pressed = |g: usize, t: f64| drift(g, t) + contact(g);
        rig.run(2.0, |_| None, pressed);
        let mean = rig.mean(0.5, |_| None, pressed);
        for (gauge, found) in mean.iter().enumerate() {
            assert!((found - contact(gauge)).abs() < 0.5, "{k}, {gauge}: {found}");
        }
        rig.run(0.5, |_| None, drift);
        assert_eq!(rig.out.phase, TouchPhase::Untouched, "{k}");
    }
}

#[test]
fn drift_beyond_the_limit_is_said() {
    for (rate, is_too_fast) in [(1.0, false), (2.5, true), (20.0, true)] {
        let mut rig = Rig::new(|_| ());
        rig.run(1.0, |_| None, |g, _| offset(g));
        let drift = |g: usize, t: f64| {
            let sign = if g.is_multiple_of(3) { -1.0 } else { 1.0 };
            offset(g) + sign * rate * (t - 1.0)
        };
        rig.run(6.0, |_| None, drift);
        let found = match rig.out.drift {
            DriftState::TooFast { rate: found, .. } => (found.abs() / rate - 1.0).abs() < 0.1,
            _ => false,
        };
        assert_eq!(found, is_too_fast, "{rate}: {:?}", rig.out.drift);
        assert_eq!(rig.out.phase == TouchPhase::Touched, is_too_fast, "{rate}");
    }
}

/// Two loads of hundreds of microstrains that swing for a minute are no touch, and when they go the zero is where it
/// was; a contact beside them is a touch, and its readings are whole.
#[test]
fn loads_are_no_touch_and_move_no_zero() {
    let load = |k: usize, gauge: usize| 10.0 * ((k + 2) as f64 * gauge as f64 + k as f64).sin();
    let response = (0..2).flat_map(|k| (0..N).map(move |gauge| load(k, gauge))).collect();
    let loads = OtherLoads { response, sd: vec![30.0; 2] };
    let mut rig = Rig::new(|params| params.loads = loads.clone());
    rig.run(1.0, |_| None, |gauge, _| offset(gauge));
    let swing = |gauge: usize, t_s: f64| {
        offset(gauge)
            + 30.0 * (load(0, gauge) * (2.0 * t_s).sin() + load(1, gauge) * (0.7 * t_s).sin())
    };
    for _ in 0..60 {
        rig.run(1.0, |_| None, swing);
        assert_eq!(rig.out.phase, TouchPhase::Untouched);
    }
    for (gauge, left) in rig.mean(1.0, |_| None, |gauge, _| offset(gauge)).iter().enumerate() {
        assert!(left.abs() < 0.5, "gauge {gauge}: {left}");
    }
    let beside = |gauge: usize, t_s: f64| swing(gauge, t_s) + contact(gauge);
    rig.run(0.5, |_| None, beside);
    assert_eq!(rig.out.phase, TouchPhase::Touched);
    let whole =
        rig.mean(1.0, |_| None, |gauge, _| offset(gauge) + 30.0 * load(0, gauge) + contact(gauge));
    for (gauge, found) in whole.iter().enumerate() {
        let expected = 30.0 * load(0, gauge) + contact(gauge);
        assert!((found - expected).abs() < 0.5, "gauge {gauge}: {found}, {expected}");
    }
}
