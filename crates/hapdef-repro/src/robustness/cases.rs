//! The rows: data and settings at their extremes.

use super::plant::{N_OUT, N_TRAIN, Plant, largest_difference, methods, net};
use super::table::Trials;
use crate::baselines::{LinearParams, SvrParams};
use crate::search::Learner;

/// Every row, in the table's order.
pub(super) fn add(rows: &mut Trials<Plant>, seed: u64) {
    for (method, learner) in methods() {
        rows.of(method).on(Plant::new(seed, learner.clone()));
        channels(rows, &learner);
        outputs(rows);
        outliers(rows);
        not_finite(rows);
        few_samples(rows);
    }
    rates(rows);
    neighbours(rows.of("k-NN").on(Plant::new(seed, Learner::Knn { k: 6 })));
    collinear(rows.of("LR").on(Plant::new(seed, Learner::Linear(LinearParams::default()))));
    support_vectors(rows.of("SVR"));
    for (method, extreme, words, learner) in settings() {
        rows.of(method).on(Plant::new(seed, learner));
        rows.refused(extreme, "refused by name", words, Plant::error);
    }
}

fn channels(rows: &mut Trials<Plant>, learner: &Learner) {
    let holds = ("error at most 1.5 × that without the channel", 1.5);
    rows.accurate("a constant channel", holds, |plant| {
        plant.with_inputs(|x| [x, &[1234.5]].concat()).over(plant)
    });
    let extreme = "a channel constant in training moves later";
    rows.accurate(extreme, ("predictions do not move", 1e-6), |plant| {
        let still = plant.with_inputs(|x| [x, &[100.0]].concat());
        still.apart(&still.changed(|moving| {
            moving.test_x.iter_mut().skip(4).step_by(5).for_each(|x| *x = 150.0);
        }))
    });
    // the mean of six samples is off by as much as χ² with three degrees of freedom, 99.9 %, over 6 · 3
    let holds = match learner {
        Learner::Knn { .. } => {
            ("error at most √(1 + 16.3/18) × that of the mean: six samples' mean", 1.38)
        }
        _ => ("error at most 1.2 × that of the mean", 1.2),
    };
    rows.either("all channels constant", holds, |plant| {
        plant.with_inputs(|_| vec![7.0; 4]).error()
    });
    let holds = ("error at most 1.2 × that without the channel", 1.2);
    rows.accurate("a channel saturated for 80 % of the samples", holds, |plant| {
        let clipped = |x: &[f32]| [&[x[0].clamp(-0.2, 0.2)], &x[1..]].concat();
        plant.with_inputs(clipped).over(&without_first(plant))
    });
    for (words, factors) in [
        ("channels × 1, 1e5, 1e-5, 1", [1.0, 1e5, 1e-5, 1.0]),
        ("channels × 1e-5", [1e-5; 4]),
        ("channels × 1e5", [1e5; 4]),
    ] {
        rows.accurate(words, ("error moves by at most 10 %", 0.1), move |plant| {
            let scaled = |x: &[f32]| x.iter().zip(factors).map(|(x, f)| x * f).collect();
            Ok((plant.with_inputs(scaled).over(plant)? - 1.0).abs())
        });
    }
}

fn without_first(plant: &Plant) -> Plant {
    plant.with_inputs(|x| x[1..].to_vec())
}

fn outputs(rows: &mut Trials<Plant>) {
    for newtons in [1e-6_f32, 1e-3, 1e3, 1e6] {
        let holds = ("error, in forces, moves by at most 10 %", 0.1);
        rows.accurate(format!("forces of {newtons:.0e} N"), holds, move |plant| {
            let scaled = plant.changed(|plant| {
                plant.y.iter_mut().chain(&mut plant.test_y).for_each(|y| *y *= newtons);
            });
            Ok((scaled.over(plant)? - 1.0).abs())
        });
    }
    for value in [0.0_f32, 0.05, -1e6] {
        let holds = ("predictions stay at the constant", 1e-5);
        rows.accurate(format!("outputs constant at {value}"), holds, move |plant| {
            let found = plant.changed(|plant| plant.y.fill(value)).predictions()?;
            let apart = largest_difference(&vec![value; plant.test_y.len()], &found);
            Ok(if value.abs() > 0.0 { apart } else { apart * f64::MIN_POSITIVE })
        });
    }
}

fn outliers(rows: &mut Trials<Plant>) {
    for value in [1e3_f32, 1e6, 1e12, 1e30, f32::MAX] {
        let holds = ("error at most 1.2 × that without the channel", 1.2);
        let extreme = format!("one training sample's channel at {value:.0e}");
        rows.either(extreme, holds, move |plant| {
            plant.changed(|plant| plant.x[4 * 17] = value).over(&without_first(plant))
        });
        let holds = ("the other outputs stay better than their means", 1.0);
        let extreme = format!("one training sample's output at {value:.0e}");
        rows.either(extreme, holds, move |plant| {
            plant.changed(|plant| plant.y[N_OUT * 17] = value).error_from(1)
        });
        let extreme = format!("a test sample's channel at {value:.0e}");
        rows.either(extreme, ("predictions are finite", 0.0), move |plant| {
            let found = plant.changed(|plant| plant.test_x[4 * 17] = value).predictions()?;
            Ok(found.iter().filter(|v| !v.is_finite()).count() as f64)
        });
    }
}

fn not_finite(rows: &mut Trials<Plant>) {
    type Spoil = fn(&mut Plant, f32);
    let spoilt: [(&str, &'static str, Spoil); 3] = [
        ("training channel", "row 17, column 2", |plant, v| plant.x[4 * 17 + 2] = v),
        ("training output", "row 17, column 2", |plant, v| plant.y[N_OUT * 17 + 2] = v),
        ("test channel", "row 57, column 2", |plant, v| plant.test_x[4 * 57 + 2] = v),
    ];
    for (place, words, spoil) in spoilt {
        for value in [f32::NAN, f32::INFINITY] {
            let extreme = format!("a {place} is {value}");
            rows.refused(extreme, "refused with row and column", words, move |plant| {
                plant.changed(|plant| spoil(plant, value)).error()
            });
        }
    }
}

fn few_samples(rows: &mut Trials<Plant>) {
    for n in [1, 2] {
        let holds = ("the samples' own outputs, up to 1 %", 1e-2);
        rows.either(format!("{n} training samples"), holds, move |plant| {
            let few = plant.changed(|plant| {
                plant.x.truncate(n * plant.n_in);
                plant.y.truncate(n * N_OUT);
            });
            Ok(largest_difference(&few.y, &few.fitted()?.predictions(&few.x, n)?))
        });
    }
}

fn rates(rows: &mut Trials<Plant>) {
    for rate in [1e-9, 1e-1, 1.0, 1e2, 1e6, 1e30, 1e300] {
        let holds = ("error below that of the mean", 1.0);
        let extreme = format!("learning rate {rate:.0e}");
        rows.either(extreme, holds, move |plant| plant.by(net(rate)).error());
    }
}

fn neighbours(rows: &mut Trials<Plant>) {
    let holds = ("the outputs of the equal points", 1e-6);
    rows.accurate("every point ten times", holds, |plant| {
        let ten = |rows: &[f32], width: usize| {
            rows.chunks_exact(width).flat_map(|r| r.repeat(10)).collect::<Vec<_>>()
        };
        let again = plant.changed(|again| {
            (again.test_x, again.test_y) = (plant.x[..400].to_vec(), plant.y[..300].to_vec());
            (again.x, again.y) = (ten(&plant.x, 4), ten(&plant.y, N_OUT));
        });
        Ok(largest_difference(&again.test_y, &again.predictions()?))
    });
    let holds = ("the mean of the first six", 1e-6);
    rows.accurate("equal points with different outputs", holds, |plant| {
        let mean = |j: usize| (0..6).map(|i| plant.y[i * N_OUT + j]).sum::<f32>() / 6.0;
        let wanted: Vec<f32> = (0..plant.test_y.len()).map(|i| mean(i % N_OUT)).collect();
        let found = plant.with_inputs(|_| vec![0.5; 4]).predictions()?;
        Ok(largest_difference(&wanted, &found))
    });
}

fn collinear(rows: &mut Trials<Plant>) {
    type Widen = fn(&[f32]) -> Vec<f32>;
    let widened: [(&str, Widen); 4] = [
        ("every column twice", |x| [x, x].concat()),
        ("every column fifty times", |x| x.repeat(50)),
        ("a column that is the sum of two", |x| [x, &[x[0] + x[1]]].concat()),
        ("a column and itself × 1e5", |x| [x, &[x[0] * 1e5]].concat()),
    ];
    for (words, widen) in widened {
        let holds = ("predictions as without the extra columns", 1e-5);
        rows.accurate(words, holds, move |plant| plant.apart(&plant.with_inputs(widen)));
    }
}

fn support_vectors(rows: &mut Trials<Plant>) {
    for (c, gamma) in [(20.0, 1e-6), (20.0, 1e6), (1e-6, 0.125), (1e4, 0.125)] {
        let params = SvrParams { c, gamma, epsilon: 1e-3, ..SvrParams::default() };
        let holds = ("error at most 1.2 × that of the mean", 1.2);
        rows.either(format!("C {c:.0e}, γ {gamma:.0e}"), holds, move |plant| {
            plant.by(Learner::Svr(params)).error()
        });
    }
}

/// Settings that are none: method, setting, what the refusal names.
fn settings() -> [(&'static str, &'static str, &'static str, Learner); 8] {
    let svr = |change: fn(&mut SvrParams)| {
        let mut params = SvrParams::default();
        change(&mut params);
        Learner::Svr(params)
    };
    let linear = |ridge| Learner::Linear(LinearParams { ridge, ..LinearParams::default() });
    [
        ("LR", "ridge −1", "ridge", linear(-1.0)),
        ("LR", "ridge NaN", "ridge", linear(f64::NAN)),
        ("k-NN", "k 0", "k = 0", Learner::Knn { k: 0 }),
        ("k-NN", "k beyond the samples", "at least", Learner::Knn { k: N_TRAIN + 1 }),
        ("SVR", "C 0", "SVR c", svr(|p| p.c = 0.0)),
        ("SVR", "γ NaN", "SVR gamma", svr(|p| p.gamma = f64::NAN)),
        ("net", "learning rate 0", "learning_rate", net(0.0)),
        ("net", "learning rate NaN", "learning_rate", net(f64::NAN)),
    ]
}
