//! What can be varied: the methods, their parameters, and the paper's point among them.

use std::collections::BTreeMap;

use hapdef_nets::{Activation, TrainParams};
use hapdef_report::ArgumentError;

use super::learner::{Learner, NetSettings};
use crate::baselines::{LinearParams, SvrParams};
use crate::error::ReproError;

/// A method whose settings are searched.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum SearchMethod {
    /// F_R, virtual gauges to map.
    #[value(name = "f_r")]
    Reconstruction,
    /// F_T, readings to virtual gauges.
    #[value(name = "f_t")]
    Transfer,
    /// The direct net, readings to place and force.
    Direct,
    /// Linear regression from virtual gauges to map.
    #[value(name = "lr")]
    Linear,
    /// k nearest neighbours from virtual gauges to map.
    Knn,
    /// Support-vector regression from readings to place and force.
    Svr,
}

/// One number that is varied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Its name in files and tables.
    pub name: &'static str,
    /// Least value.
    pub low: f64,
    /// Greatest value.
    pub high: f64,
    /// Whether equal ratios, not equal differences, count alike.
    pub is_log: bool,
    /// Whether only whole numbers make sense.
    pub is_whole: bool,
    /// The paper's value (Sun & Martius 2019, sections 3.4 and 4.1), the nearest one in range where
    /// it has none: 1e-9 for no penalty, 1e-12 for no ridge.
    pub paper: f64,
}

/// What every trial may spend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrialBudget {
    /// Steps of a net's training, 100 samples each.
    pub steps: u64,
    /// Most samples that support vectors are trained on.
    pub n_svr: usize,
    /// Seed of weights, batches and thinning.
    pub seed: u64,
}

/// Values of the parameters by name.
pub type ParameterValues = BTreeMap<String, f64>;

impl SearchMethod {
    /// Every method.
    pub const ALL: [Self; 6] =
        [Self::Reconstruction, Self::Transfer, Self::Direct, Self::Linear, Self::Knn, Self::Svr];

    /// Its name in files and on the command line.
    pub fn name(self) -> &'static str {
        ["f_r", "f_t", "direct", "lr", "knn", "svr"][self as usize]
    }

    /// What is made least, on validation samples.
    pub fn objective(self) -> &'static str {
        match self {
            Self::Reconstruction | Self::Linear | Self::Knn => "mean |error| of the map, µm",
            Self::Transfer => "mean |error| of the virtual gauges, µm",
            Self::Direct | Self::Svr => "mean distance of the contact, mm",
        }
    }

    /// The parameters; `max_patch` is the most virtual gauges per gauge that the samples have.
    pub fn parameters(self, max_patch: usize) -> Vec<Parameter> {
        let patch = whole("patch", 1.0, max_patch as f64, 24.0, false);
        let rate = real("learning_rate", 1e-5, 1e-2, 1e-4);
        match self {
            Self::Reconstruction => vec![
                whole("layers", 1.0, 5.0, 3.0, false),
                whole("first_units", 32.0, 1024.0, 600.0, true),
                whole("last_units", 32.0, 2048.0, 1800.0, true),
                rate,
                real("l2", 1e-9, 1e-2, 1e-4),
                patch,
            ],
            Self::Transfer => vec![
                whole("layers", 1.0, 8.0, 6.0, false),
                whole("units", 16.0, 512.0, 250.0, true),
                rate,
                real("l2", 1e-9, 1e-2, 1e-3),
            ],
            Self::Direct => vec![
                whole("layers", 1.0, 8.0, 5.0, false),
                whole("units", 16.0, 1024.0, 500.0, true),
                rate,
                real("l2", 1e-9, 1e-2, 1e-9),
            ],
            Self::Linear => vec![real("ridge", 1e-12, 10.0, 1e-12), patch],
            Self::Knn => vec![whole("k", 1.0, 30.0, 6.0, false), patch],
            Self::Svr => vec![
                real("c", 0.1, 1e3, 20.0),
                real("epsilon", 1e-6, 0.3, 1e-6),
                real("gamma", 1.0 / 1024.0, 8.0, 0.125),
            ],
        }
    }

    /// The method with these values.
    pub fn learner(
        self,
        values: &ParameterValues,
        budget: &TrialBudget,
    ) -> Result<Learner, ReproError> {
        let value = |name: &'static str| {
            values.get(name).copied().ok_or(ArgumentError::Name {
                what: "parameter",
                name: name.to_owned(),
                expected: "a value for every parameter of the method",
            })
        };
        let count = |name| value(name).map(|v| v as usize);
        let net = |hidden, activation| -> Result<Learner, ReproError> {
            let learning_rate = value("learning_rate")?;
            Ok(Learner::Net(NetSettings {
                hidden,
                activation,
                training: TrainParams {
                    steps: budget.steps,
                    learning_rate,
                    final_learning_rate: Some(learning_rate * 1e-2),
                    l2: value("l2")?,
                    ..TrainParams::paper(budget.seed)
                },
            }))
        };
        match self {
            Self::Reconstruction => {
                let ends = [count("first_units")?, count("last_units")?];
                net(widths(count("layers")?, ends), Activation::Relu)
            }
            Self::Transfer => net(vec![count("units")?; count("layers")?], Activation::Tanh),
            Self::Direct => net(vec![count("units")?; count("layers")?], Activation::Relu),
            Self::Linear => Ok(Learner::Linear(LinearParams {
                ridge: value("ridge")?,
                ..LinearParams::default()
            })),
            Self::Knn => Ok(Learner::Knn { k: count("k")? }),
            Self::Svr => Ok(Learner::Svr(SvrParams {
                c: value("c")?,
                epsilon: value("epsilon")?,
                gamma: value("gamma")?,
                max_samples: budget.n_svr,
                seed: budget.seed,
                ..SvrParams::default()
            })),
        }
    }
}

impl Parameter {
    /// The parameter's value at `unit`, 0 for the least, 1 for the greatest.
    pub fn value(&self, unit: f64) -> f64 {
        let value = if self.is_log {
            self.low * (self.high / self.low).powf(unit)
        } else {
            self.low + (self.high - self.low) * unit
        };
        let value = if self.is_whole { value.round() } else { value };
        value.clamp(self.low, self.high)
    }

    /// Where `value` lies between the least, 0, and the greatest, 1.
    pub fn unit(&self, value: f64) -> f64 {
        let unit = if self.is_log {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low).max(f64::MIN_POSITIVE)
        };
        unit.clamp(0.0, 1.0)
    }
}

/// The paper's point.
pub fn paper_values(parameters: &[Parameter]) -> ParameterValues {
    let value = |parameter: &Parameter| {
        (parameter.name.to_owned(), parameter.paper.clamp(parameter.low, parameter.high))
    };
    parameters.iter().map(value).collect()
}

/// Widths that grow evenly from the first to the last hidden layer; a single layer has the last.
fn widths(layers: usize, [first, last]: [usize; 2]) -> Vec<usize> {
    let at = |i: usize| {
        let share = match layers {
            1 => 1.0,
            _ => i as f64 / (layers - 1) as f64,
        };
        (first as f64 + (last as f64 - first as f64) * share).round() as usize
    };
    (0..layers).map(at).collect()
}

fn whole(name: &'static str, low: f64, high: f64, paper: f64, is_log: bool) -> Parameter {
    Parameter { name, low, high, is_log, is_whole: true, paper }
}

fn real(name: &'static str, low: f64, high: f64, paper: f64) -> Parameter {
    Parameter { name, low, high, is_log: true, is_whole: false, paper }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hapdef_nets::MlpSpec;

    const BUDGET: TrialBudget = TrialBudget { steps: 1, n_svr: 2, seed: 0 };

    fn paper_net(method: SearchMethod) -> NetSettings {
        let values = paper_values(&method.parameters(60));
        match method.learner(&values, &BUDGET).unwrap() {
            Learner::Net(net) => net,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn the_papers_point_is_the_papers_nets() {
        let specs = [
            (SearchMethod::Reconstruction, MlpSpec::reconstruction(240, 3211)),
            (SearchMethod::Transfer, MlpSpec::transfer(10, 240)),
            (SearchMethod::Direct, MlpSpec::direct(10)),
        ];
        for (method, spec) in specs {
            let net = paper_net(method);
            assert_eq!((net.hidden, net.activation), (spec.hidden, spec.activation));
        }
    }

    #[test]
    fn a_parameters_value_and_place_are_inverse() {
        for parameter in SearchMethod::ALL.iter().flat_map(|m| m.parameters(60)) {
            for unit in [0.0, 0.3, 0.71, 1.0] {
                let value = parameter.value(unit);
                assert!((parameter.low..=parameter.high).contains(&value), "{parameter:?} {value}");
                assert!((parameter.value(parameter.unit(value)) / value - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn one_layer_has_the_last_width() {
        assert_eq!(widths(1, [100, 300]), [300]);
        assert_eq!(widths(2, [100, 300]), [100, 300]);
        assert_eq!(widths(5, [100, 300]), [100, 150, 200, 250, 300]);
    }
}
