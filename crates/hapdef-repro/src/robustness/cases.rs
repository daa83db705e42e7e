//! The rows: data and settings at their extremes.

use super::plant::{N_OUT, N_TRAIN, Plant, largest_difference, methods, net};
use super::table::{Rows, Trial};
use crate::baselines::{LinearParams, SvrParams};
use crate::error::ReproError;
use crate::search::Learner;

/// A method on the problem that every row starts from.
#[derive(Clone)]
struct On {
    plant: Plant,
    learner: Learner,
}

/// Every row, in the table's order.
pub(super) fn trials(seed: u64) -> Vec<Trial> {
    let on = |case, learner| Rows::new(case, On { plant: Plant::new(seed), learner });
    let mut all = Vec::new();
    for (method, learner) in methods() {
        let mut rows = on(method, learner.clone());
        channels(&mut rows, &learner);
        outputs(&mut rows);
        outliers(&mut rows);
        not_finite(&mut rows);
        few_samples(&mut rows);
        all.extend(rows.into_trials());
    }
    all.extend(rates(Rows::new("net", Plant::new(seed))));
    all.extend(neighbours(on("k-NN", Learner::Knn { k: 6 })));
    all.extend(collinear(on("LR", Learner::Linear(LinearParams::default()))));
    all.extend(support_vectors(Rows::new("SVR", Plant::new(seed))));
    for (method, extreme, words, learner) in settings() {
        let mut rows = on(method, learner);
        rows.refused(extreme, "refused by name", words, |on| on.error(&on.plant));
        all.extend(rows.into_trials());
    }
    all
}

impl On {
    fn plant(&self) -> Plant {
        self.plant.clone()
    }

    fn error(&self, plant: &Plant) -> Result<f64, ReproError> {
        plant.error(&self.learner)
    }

    /// Error over the error of another problem.
    fn ratio(&self, a: &Plant, b: &Plant) -> Result<f64, ReproError> {
        Ok(self.error(a)? / self.error(b)?)
    }

    /// How much the error moves when the problem only changes its units.
    fn moved(&self, changed: &Plant) -> Result<f64, ReproError> {
        Ok((self.ratio(changed, &self.plant)? - 1.0).abs())
    }

    fn predictions(&self, plant: &Plant) -> Result<Vec<f32>, ReproError> {
        plant.predictions(&self.learner)
    }
}

fn channels(rows: &mut Rows<On>, learner: &Learner) {
    let holds = ("error at most 1.5 × that without the channel", 1.5);
    rows.accurate("a constant channel", holds, |on| {
        on.ratio(&on.plant().with_inputs(|x| [x, &[1234.5]].concat()), &on.plant)
    });
    let extreme = "a channel constant in training moves later";
    rows.accurate(extreme, ("predictions do not move", 1e-6), |on| {
        let still = on.plant().with_inputs(|x| [x, &[100.0]].concat());
        let mut moving = still.clone();
        moving.test_x.iter_mut().skip(4).step_by(5).for_each(|x| *x = 150.0);
        Ok(largest_difference(&on.predictions(&still)?, &on.predictions(&moving)?))
    });
    // the mean of six samples is off by as much as χ² with three degrees of freedom, 99.9 %, over 6 · 3
    let holds = match learner {
        Learner::Knn { .. } => {
            ("error at most √(1 + 16.3/18) × that of the mean: six samples' mean", 1.38)
        }
        _ => ("error at most 1.2 × that of the mean", 1.2),
    };
    rows.either("all channels constant", holds, |on| {
        on.error(&on.plant().with_inputs(|_| vec![7.0; 4]))
    });
    let holds = ("error at most 1.2 × that without the channel", 1.2);
    rows.accurate("a channel saturated for 80 % of the samples", holds, |on| {
        let clipped = |x: &[f32]| [&[x[0].clamp(-0.2, 0.2)], &x[1..]].concat();
        let without = on.plant().with_inputs(|x| x[1..].to_vec());
        on.ratio(&on.plant().with_inputs(clipped), &without)
    });
    for (words, factors) in [
        ("channels × 1, 1e5, 1e-5, 1", [1.0, 1e5, 1e-5, 1.0]),
        ("channels × 1e-5", [1e-5; 4]),
        ("channels × 1e5", [1e5; 4]),
    ] {
        rows.accurate(words, ("error moves by at most 10 %", 0.1), move |on| {
            let scaled = |x: &[f32]| x.iter().zip(factors).map(|(x, f)| x * f).collect();
            on.moved(&on.plant().with_inputs(scaled))
        });
    }
}

fn outputs(rows: &mut Rows<On>) {
    for newtons in [1e-6_f32, 1e-3, 1e3, 1e6] {
        let holds = ("error, in forces, moves by at most 10 %", 0.1);
        rows.accurate(format!("forces of {newtons:.0e} N"), holds, move |on| {
            on.moved(&on.plant().with_outputs_times(newtons))
        });
    }
    for value in [0.0_f32, 0.05, -1e6] {
        let holds = ("predictions stay at the constant", 1e-5);
        rows.accurate(format!("outputs constant at {value}"), holds, move |on| {
            let mut plant = on.plant();
            plant.y.fill(value);
            let truth = vec![value; plant.test_y.len()];
            let apart = largest_difference(&truth, &on.predictions(&plant)?);
            Ok(if value.abs() > 0.0 { apart } else { apart * f64::MIN_POSITIVE })
        });
    }
}

fn outliers(rows: &mut Rows<On>) {
    for value in [1e3_f32, 1e6, 1e12, 1e30, f32::MAX] {
        let holds = ("error at most 1.2 × that without the channel", 1.2);
        let extreme = format!("one training sample's channel at {value:.0e}");
        rows.either(extreme, holds, move |on| {
            let mut plant = on.plant();
            plant.x[4 * 17] = value;
            on.ratio(&plant, &on.plant().with_inputs(|x| x[1..].to_vec()))
        });
        let holds = ("the other outputs stay better than their means", 1.0);
        let extreme = format!("one training sample's output at {value:.0e}");
        rows.either(extreme, holds, move |on| {
            let mut plant = on.plant();
            plant.y[N_OUT * 17] = value;
            plant.error_from(&on.learner, 1)
        });
        let extreme = format!("a test sample's channel at {value:.0e}");
        rows.either(extreme, ("predictions are finite", 0.0), move |on| {
            let mut plant = on.plant();
            plant.test_x[4 * 17] = value;
            let found = on.predictions(&plant)?;
            Ok(found.iter().filter(|v| !v.is_finite()).count() as f64)
        });
    }
}

fn not_finite(rows: &mut Rows<On>) {
    type Spoil = fn(&mut Plant, f32);
    let spoilt: [(&str, &'static str, Spoil); 3] = [
        ("training channel", "row 17, column 2", |plant, v| plant.x[4 * 17 + 2] = v),
        ("training output", "row 17, column 2", |plant, v| plant.y[N_OUT * 17 + 2] = v),
        ("test channel", "row 57, column 2", |plant, v| plant.test_x[4 * 57 + 2] = v),
    ];
    for (place, words, spoil) in spoilt {
        for value in [f32::NAN, f32::INFINITY] {
            let extreme = format!("a {place} is {value}");
            rows.refused(extreme, "refused with row and column", words, move |on| {
                let mut plant = on.plant();
                spoil(&mut plant, value);
                on.error(&plant)
            });
        }
    }
}

fn few_samples(rows: &mut Rows<On>) {
    for n in [1, 2] {
        let holds = ("the samples' own outputs, up to 1 %", 1e-2);
        rows.either(format!("{n} training samples"), holds, move |on| {
            let mut plant = on.plant();
            plant.x.truncate(n * plant.n_in);
            plant.y.truncate(n * N_OUT);
            let fitted = on.learner.fit(&plant.samples(), &|| false)?;
            Ok(largest_difference(&plant.y, &fitted.predictions(&plant.x, n)?))
        });
    }
}

fn rates(mut rows: Rows<Plant>) -> Vec<Trial> {
    for rate in [1e-9, 1e-1, 1.0, 1e2, 1e6, 1e30, 1e300] {
        let holds = ("error below that of the mean", 1.0);
        let extreme = format!("learning rate {rate:.0e}");
        rows.either(extreme, holds, move |plant| plant.error(&net(rate)));
    }
    rows.into_trials()
}

fn neighbours(mut rows: Rows<On>) -> Vec<Trial> {
    let holds = ("the outputs of the equal points", 1e-6);
    rows.accurate("every point ten times", holds, |on| {
        let mut plant = on.plant();
        let ten = |rows: &[f32], width: usize| {
            rows.chunks_exact(width).flat_map(|r| r.repeat(10)).collect::<Vec<_>>()
        };
        (plant.test_x, plant.test_y) = (plant.x[..400].to_vec(), plant.y[..300].to_vec());
        (plant.x, plant.y) = (ten(&plant.x, 4), ten(&plant.y, N_OUT));
        Ok(largest_difference(&plant.test_y, &on.predictions(&plant)?))
    });
    let holds = ("the mean of the first six", 1e-6);
    rows.accurate("equal points with different outputs", holds, |on| {
        let plant = on.plant().with_inputs(|_| vec![0.5; 4]);
        let mean = |j: usize| (0..6).map(|i| plant.y[i * N_OUT + j]).sum::<f32>() / 6.0;
        let wanted: Vec<f32> = (0..plant.test_y.len()).map(|i| mean(i % N_OUT)).collect();
        Ok(largest_difference(&wanted, &on.predictions(&plant)?))
    });
    rows.into_trials()
}

fn collinear(mut rows: Rows<On>) -> Vec<Trial> {
    type Widen = fn(&[f32]) -> Vec<f32>;
    let widened: [(&str, Widen); 4] = [
        ("every column twice", |x| [x, x].concat()),
        ("every column fifty times", |x| x.repeat(50)),
        ("a column that is the sum of two", |x| [x, &[x[0] + x[1]]].concat()),
        ("a column and itself × 1e5", |x| [x, &[x[0] * 1e5]].concat()),
    ];
    for (words, widen) in widened {
        let holds = ("predictions as without the extra columns", 1e-5);
        rows.accurate(words, holds, move |on| {
            let wide = on.plant().with_inputs(widen);
            Ok(largest_difference(&on.predictions(&on.plant)?, &on.predictions(&wide)?))
        });
    }
    rows.into_trials()
}

fn support_vectors(mut rows: Rows<Plant>) -> Vec<Trial> {
    for (c, gamma) in [(20.0, 1e-6), (20.0, 1e6), (1e-6, 0.125), (1e4, 0.125)] {
        let params = SvrParams { c, gamma, epsilon: 1e-3, ..SvrParams::default() };
        let holds = ("error at most 1.2 × that of the mean", 1.2);
        rows.either(format!("C {c:.0e}, γ {gamma:.0e}"), holds, move |plant| {
            plant.error(&Learner::Svr(params))
        });
    }
    rows.into_trials()
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
