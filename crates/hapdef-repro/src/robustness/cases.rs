//! The rows: data and settings at their extremes.

use hapdef_report::robustness::Expected;

use super::plant::{N_OUT, N_TRAIN, Plant, largest_difference, methods, net};
use super::table::{Trial, trial};
use crate::ReproError;
use crate::baselines::{LinearParams, SvrParams};
use crate::search::Learner;

/// Every row, in the table's order.
pub(super) fn trials(seed: u64) -> Vec<Trial> {
    let mut all = Vec::new();
    for (method, learner) in methods() {
        channels(&mut all, seed, method, &learner);
        outputs(&mut all, seed, method, &learner);
        outliers(&mut all, seed, method, &learner);
        not_finite(&mut all, seed, method, &learner);
        few_samples(&mut all, seed, method, &learner);
    }
    rates(&mut all, seed);
    neighbours(&mut all, seed);
    collinear(&mut all, seed);
    support_vectors(&mut all, seed);
    settings(&mut all, seed);
    all
}

/// Error over the error of another problem.
fn ratio(a: &Plant, b: &Plant, learner: &Learner) -> Result<f64, ReproError> {
    Ok(a.error(learner)? / b.error(learner)?)
}

/// How much an error moves when the problem only changes its units.
fn moved(seed: u64, changed: &Plant, learner: &Learner) -> Result<f64, ReproError> {
    Ok((ratio(changed, &Plant::new(seed), learner)? - 1.0).abs())
}

fn channels(all: &mut Vec<Trial>, seed: u64, method: &'static str, learner: &Learner) {
    use Expected::{Either, Result};
    let l = learner.clone();
    let holds = ("error at most 1.5 × that without the channel", 1.5);
    all.push(trial(method, "a constant channel", holds, Result, move || {
        let with = Plant::new(seed).with_inputs(|x| [x, &[1234.5]].concat());
        ratio(&with, &Plant::new(seed), &l)
    }));
    let l = learner.clone();
    let holds = ("predictions do not move", 1e-6);
    all.push(trial(
        method,
        "a channel constant in training moves later",
        holds,
        Result,
        move || {
            let still = Plant::new(seed).with_inputs(|x| [x, &[100.0]].concat());
            let mut moving = still.clone();
            moving.test_x.iter_mut().skip(4).step_by(5).for_each(|x| *x = 150.0);
            Ok(largest_difference(&still.predictions(&l)?, &moving.predictions(&l)?))
        },
    ));
    let l = learner.clone();
    // the mean of six samples is off by as much as χ² with three degrees of freedom, 99.9 %, over 6 · 3
    let holds = match learner {
        Learner::Knn { .. } => {
            ("error at most √(1 + 16.3/18) × that of the mean: six samples' mean", 1.38)
        }
        _ => ("error at most 1.2 × that of the mean", 1.2),
    };
    all.push(trial(method, "all channels constant", holds, Either, move || {
        Plant::new(seed).with_inputs(|_| vec![7.0; 4]).error(&l)
    }));
    let l = learner.clone();
    let holds = ("error at most 1.2 × that without the channel", 1.2);
    all.push(trial(
        method,
        "a channel saturated for 80 % of the samples",
        holds,
        Result,
        move || {
            let clipped = |x: &[f32]| [&[x[0].clamp(-0.2, 0.2)], &x[1..]].concat();
            let without = Plant::new(seed).with_inputs(|x| x[1..].to_vec());
            ratio(&Plant::new(seed).with_inputs(clipped), &without, &l)
        },
    ));
    for (words, factors) in [
        ("channels × 1, 1e5, 1e-5, 1", [1.0, 1e5, 1e-5, 1.0]),
        ("channels × 1e-5", [1e-5; 4]),
        ("channels × 1e5", [1e5; 4]),
    ] {
        let l = learner.clone();
        let holds = ("error moves by at most 10 %", 0.1);
        all.push(trial(method, words, holds, Result, move || {
            let scaled = |x: &[f32]| x.iter().zip(factors).map(|(x, f)| x * f).collect();
            moved(seed, &Plant::new(seed).with_inputs(scaled), &l)
        }));
    }
}

fn outputs(all: &mut Vec<Trial>, seed: u64, method: &'static str, learner: &Learner) {
    for newtons in [1e-6_f32, 1e-3, 1e3, 1e6] {
        let l = learner.clone();
        let holds = ("error, in forces, moves by at most 10 %", 0.1);
        let extreme = format!("forces of {newtons:.0e} N");
        all.push(trial(method, extreme, holds, Expected::Result, move || {
            moved(seed, &Plant::new(seed).with_outputs_times(newtons), &l)
        }));
    }
    for value in [0.0_f32, 0.05, -1e6] {
        let l = learner.clone();
        let holds = ("predictions stay at the constant", 1e-5);
        let extreme = format!("outputs constant at {value}");
        all.push(trial(method, extreme, holds, Expected::Result, move || {
            let mut plant = Plant::new(seed);
            plant.y.fill(value);
            let truth = vec![value; plant.test_y.len()];
            let found = plant.predictions(&l)?;
            let apart = largest_difference(&truth, &found);
            Ok(if value.abs() > 0.0 { apart } else { apart * f64::MIN_POSITIVE })
        }));
    }
}

fn outliers(all: &mut Vec<Trial>, seed: u64, method: &'static str, learner: &Learner) {
    for value in [1e3_f32, 1e6, 1e12, 1e30, f32::MAX] {
        let l = learner.clone();
        let holds = ("error at most 1.2 × that without the channel", 1.2);
        let extreme = format!("one training sample's channel at {value:.0e}");
        all.push(trial(method, extreme, holds, Expected::Either, move || {
            let mut plant = Plant::new(seed);
            plant.x[4 * 17] = value;
            ratio(&plant, &Plant::new(seed).with_inputs(|x| x[1..].to_vec()), &l)
        }));
        let l = learner.clone();
        let holds = ("the other outputs stay better than their means", 1.0);
        let extreme = format!("one training sample's output at {value:.0e}");
        all.push(trial(method, extreme, holds, Expected::Either, move || {
            let mut plant = Plant::new(seed);
            plant.y[N_OUT * 17] = value;
            plant.error_from(&l, 1)
        }));
        let l = learner.clone();
        let holds = ("predictions are finite", 0.0);
        let extreme = format!("a test sample's channel at {value:.0e}");
        all.push(trial(method, extreme, holds, Expected::Either, move || {
            let mut plant = Plant::new(seed);
            plant.test_x[4 * 17] = value;
            let found = plant.predictions(&l)?;
            Ok(found.iter().filter(|v| !v.is_finite()).count() as f64)
        }));
    }
}

fn not_finite(all: &mut Vec<Trial>, seed: u64, method: &'static str, learner: &Learner) {
    type Spoil = fn(&mut Plant, f32);
    let spoilt: [(&'static str, Spoil); 3] = [
        ("training channel", |plant, v| plant.x[4 * 17 + 2] = v),
        ("training output", |plant, v| plant.y[N_OUT * 17 + 2] = v),
        ("test channel", |plant, v| plant.test_x[4 * 57 + 2] = v),
    ];
    for (place, spoil) in spoilt {
        for value in [f32::NAN, f32::INFINITY] {
            let l = learner.clone();
            let words = match place {
                "test channel" => "row 57, column 2",
                _ => "row 17, column 2",
            };
            let holds = ("refused with row and column", 0.0);
            let expected = Expected::saying(words);
            all.push(trial(method, format!("a {place} is {value}"), holds, expected, move || {
                let mut plant = Plant::new(seed);
                spoil(&mut plant, value);
                plant.error(&l)
            }));
        }
    }
}

fn few_samples(all: &mut Vec<Trial>, seed: u64, method: &'static str, learner: &Learner) {
    for n in [1, 2] {
        let l = learner.clone();
        let holds = ("the samples' own outputs, up to 1 %", 1e-2);
        let expected = Expected::Either;
        all.push(trial(method, format!("{n} training samples"), holds, expected, move || {
            let mut plant = Plant::new(seed);
            plant.x.truncate(n * plant.n_in);
            plant.y.truncate(n * N_OUT);
            let mut found = vec![0.0; n * N_OUT];
            let fitted = l.fit(&plant.samples(), &|| false)?;
            fitted.predict(&plant.x, &mut found)?;
            Ok(largest_difference(&plant.y, &found))
        }));
    }
}

fn rates(all: &mut Vec<Trial>, seed: u64) {
    for rate in [1e-9, 1e-1, 1.0, 1e2, 1e6, 1e30, 1e300] {
        let holds = ("error below that of the mean", 1.0);
        all.push(trial(
            "net",
            format!("learning rate {rate:.0e}"),
            holds,
            Expected::Either,
            move || Plant::new(seed).error(&net(rate)),
        ));
    }
}

fn neighbours(all: &mut Vec<Trial>, seed: u64) {
    let holds = ("the outputs of the equal points", 1e-6);
    all.push(trial("k-NN", "every point ten times", holds, Expected::Result, move || {
        let mut plant = Plant::new(seed);
        let ten = |rows: &[f32], width: usize| {
            rows.chunks_exact(width).flat_map(|r| r.repeat(10)).collect::<Vec<_>>()
        };
        (plant.test_x, plant.test_y) = (plant.x[..400].to_vec(), plant.y[..300].to_vec());
        (plant.x, plant.y) = (ten(&plant.x, 4), ten(&plant.y, N_OUT));
        Ok(largest_difference(&plant.test_y, &plant.predictions(&Learner::Knn { k: 6 })?))
    }));
    let holds = ("the mean of the first six", 1e-6);
    all.push(trial(
        "k-NN",
        "equal points with different outputs",
        holds,
        Expected::Result,
        move || {
            let plant = Plant::new(seed).with_inputs(|_| vec![0.5; 4]);
            let mean = |j: usize| (0..6).map(|i| plant.y[i * N_OUT + j]).sum::<f32>() / 6.0;
            let wanted: Vec<f32> = (0..plant.test_y.len()).map(|i| mean(i % N_OUT)).collect();
            Ok(largest_difference(&wanted, &plant.predictions(&Learner::Knn { k: 6 })?))
        },
    ));
}

fn collinear(all: &mut Vec<Trial>, seed: u64) {
    type Widen = fn(&[f32]) -> Vec<f32>;
    let widened: [(&'static str, Widen); 4] = [
        ("every column twice", |x| [x, x].concat()),
        ("every column fifty times", |x| x.repeat(50)),
        ("a column that is the sum of two", |x| [x, &[x[0] + x[1]]].concat()),
        ("a column and itself × 1e5", |x| [x, &[x[0] * 1e5]].concat()),
    ];
    for (words, widen) in widened {
        let holds = ("predictions as without the extra columns", 1e-5);
        all.push(trial("LR", words, holds, Expected::Result, move || {
            let linear = Learner::Linear(LinearParams::default());
            let plain = Plant::new(seed).predictions(&linear)?;
            let wide = Plant::new(seed).with_inputs(widen).predictions(&linear)?;
            Ok(largest_difference(&plain, &wide))
        }));
    }
}

fn support_vectors(all: &mut Vec<Trial>, seed: u64) {
    for (c, gamma) in [(20.0, 1e-6), (20.0, 1e6), (1e-6, 0.125), (1e4, 0.125)] {
        let holds = ("error at most 1.2 × that of the mean", 1.2);
        let extreme = format!("C {c:.0e}, γ {gamma:.0e}");
        all.push(trial("SVR", extreme, holds, Expected::Either, move || {
            let params = SvrParams { c, gamma, epsilon: 1e-3, ..SvrParams::default() };
            Plant::new(seed).error(&Learner::Svr(params))
        }));
    }
}

fn settings(all: &mut Vec<Trial>, seed: u64) {
    let refused = ("refused by name", 0.0);
    let svr = |change: fn(&mut SvrParams)| {
        let mut params = SvrParams::default();
        change(&mut params);
        Learner::Svr(params)
    };
    let linear = |ridge| Learner::Linear(LinearParams { ridge, ..LinearParams::default() });
    let bad: [(&'static str, &'static str, &'static str, Learner); 8] = [
        ("LR", "ridge −1", "ridge", linear(-1.0)),
        ("LR", "ridge NaN", "ridge", linear(f64::NAN)),
        ("k-NN", "k 0", "k = 0", Learner::Knn { k: 0 }),
        ("k-NN", "k beyond the samples", "at least", Learner::Knn { k: N_TRAIN + 1 }),
        ("SVR", "C 0", "SVR c", svr(|p| p.c = 0.0)),
        ("SVR", "γ NaN", "SVR gamma", svr(|p| p.gamma = f64::NAN)),
        ("net", "learning rate 0", "learning_rate", net(0.0)),
        ("net", "learning rate NaN", "learning_rate", net(f64::NAN)),
    ];
    for (method, extreme, words, learner) in bad {
        let expected = Expected::saying(words);
        all.push(trial(method, extreme, refused, expected, move || {
            Plant::new(seed).error(&learner)
        }));
    }
}
