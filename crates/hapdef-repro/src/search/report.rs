//! A search as a table and figures.

use hapdef_bench::dotted_lines;
use hapdef_report::{LineChart, Series, TextCell, TextTable, lines_svg};

use super::space::{Parameter, ParameterValues};
use super::trials::{Trial, TrialHeader, TrialSource, best_trial};
use crate::error::ReproError;

/// The search in Markdown: what it rests on, the best point beside the paper's, every trial.
pub fn search_markdown(header: &TrialHeader, parameters: &[Parameter], trials: &[Trial]) -> String {
    let failed = trials.iter().filter(|t| t.objective.is_none()).count();
    let mut text = format!(
        "# Search: {}\n\nMade least: {}, on validation samples. {} trials, {failed} of them failed; \
         each: {}; seed {}. Data: {}.\n\n",
        header.method,
        header.objective,
        trials.len(),
        header.budget,
        header.seed,
        header.data
    );
    let paper = trials.iter().find(|t| t.source == TrialSource::Paper);
    if let (Some(best), Some(paper)) = (best_trial(trials), paper) {
        text += &format!(
            "Best: trial {}, {}. The paper's point: {}.\n\n",
            best.index,
            figure(best.objective),
            figure(paper.objective)
        );
    }
    let mut sorted: Vec<&Trial> = trials.iter().collect();
    let worth = |t: &Trial| t.objective.unwrap_or(f64::INFINITY);
    sorted.sort_by(|a, b| worth(a).total_cmp(&worth(b)).then(a.index.cmp(&b.index)));
    text + &table(parameters, &sorted).to_markdown()
}

/// The figures and their file names: the best so far over the trials, and the validation error
/// against each parameter.
pub fn search_figures(
    header: &TrialHeader,
    parameters: &[Parameter],
    trials: &[Trial],
) -> Result<Vec<(String, String)>, ReproError> {
    let mut figures = vec![("best-so-far.svg".to_owned(), best_so_far(header, trials)?)];
    for parameter in parameters {
        let chart = against(header, parameter, trials);
        figures.push((format!("parameter-{}.svg", parameter.name), lines_svg(&chart)?));
    }
    Ok(figures)
}

/// Values in a row, such as `k 6, patch 24`.
pub fn values_in_words(values: &ParameterValues) -> String {
    let words = values.iter().map(|(name, value)| format!("{name} {}", short(*value)));
    words.collect::<Vec<_>>().join(", ")
}

fn table(parameters: &[Parameter], trials: &[&Trial]) -> TextTable {
    let ends = ["error", "samples", "s", "note"];
    let header = ["trial", "from"]
        .into_iter()
        .chain(parameters.iter().map(|parameter| parameter.name))
        .chain(ends);
    let row = |trial: &&Trial| {
        let value = |parameter: &Parameter| {
            trial.values.get(parameter.name).map_or(String::new(), |v| short(*v))
        };
        let mut cells = vec![trial.index.to_string(), source(trial.source).to_owned()];
        cells.extend(parameters.iter().map(value));
        cells.extend([
            figure(trial.objective),
            trial.n_train.to_string(),
            format!("{:.1}", trial.elapsed_s),
            trial.note.clone().unwrap_or_default(),
        ]);
        let is_paper = trial.source == TrialSource::Paper;
        cells
            .into_iter()
            .map(|text| TextCell { strong: is_paper && !text.is_empty(), text })
            .collect()
    };
    TextTable {
        header: header.map(str::to_owned).collect(),
        rows: trials.iter().map(row).collect(),
    }
}

fn best_so_far(header: &TrialHeader, trials: &[Trial]) -> Result<String, ReproError> {
    let mut best = f64::INFINITY;
    let so_far = trials.iter().map(|trial| {
        best = best.min(trial.objective.unwrap_or(f64::INFINITY));
        (trial.index as f64, best)
    });
    let so_far = so_far.collect();
    let each = trials.iter().filter_map(|t| Some((t.index as f64, t.objective?)));
    let series = [
        Series { name: "best so far".into(), points: so_far },
        Series { name: "each trial".into(), points: loose(each) },
    ];
    let title = format!("{}: best so far", header.method);
    Ok(lines_svg(&dotted_lines(title, ["trial", &header.objective], [false, true], series))?)
}

fn against(header: &TrialHeader, parameter: &Parameter, trials: &[Trial]) -> LineChart {
    let of = |kind: TrialSource| {
        let points = trials
            .iter()
            .filter(move |t| t.source == kind)
            .filter_map(|t| Some((*t.values.get(parameter.name)?, t.objective?)));
        Series { name: source(kind).to_owned(), points: loose(points) }
    };
    let series = [TrialSource::Paper, TrialSource::Random, TrialSource::Proposed].map(of);
    let title = format!("{}: {}", header.method, parameter.name);
    dotted_lines(title, [parameter.name, &header.objective], [parameter.is_log, true], series)
}

/// Points that no line joins: what is not finite breaks a line.
fn loose(points: impl Iterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    points.flat_map(|point| [point, (f64::NAN, f64::NAN)]).collect()
}

fn source(source: TrialSource) -> &'static str {
    match source {
        TrialSource::Paper => "paper",
        TrialSource::Random => "random",
        TrialSource::Proposed => "proposed",
    }
}

fn figure(objective: Option<f64>) -> String {
    objective.map_or_else(|| "failed".to_owned(), |value| format!("{value:.4}"))
}

/// A value in few digits.
fn short(value: f64) -> String {
    if value.fract() == 0.0 && value.abs() < 1e6 {
        format!("{value}")
    } else if (1e-2..1e4).contains(&value.abs()) {
        format!("{value:.3}")
    } else {
        format!("{value:.2e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::search::SearchMethod;
    use crate::search::space::paper_values;

    #[test]
    fn a_search_is_shown_with_the_papers_point_and_the_best() {
        let header = TrialHeader {
            method: "knn".into(),
            objective: "error, µm".into(),
            data: "d".into(),
            budget: "b".into(),
            seed: 1,
        };
        let parameters = SearchMethod::Knn.parameters(60);
        let trial = |index, source, objective| Trial {
            index,
            source,
            values: paper_values(&parameters),
            objective,
            note: None,
            n_train: 3,
            elapsed_s: 0.1,
        };
        let trials = [
            trial(0, TrialSource::Paper, Some(2.0)),
            trial(1, TrialSource::Random, None),
            trial(2, TrialSource::Proposed, Some(0.5)),
        ];
        let text = search_markdown(&header, &parameters, &trials);
        assert!(text.contains("Best: trial 2, 0.5000. The paper's point: 2.0000."), "{text}");
        assert!(text.contains("| **0** | **paper** |"), "{text}");
        let figures = search_figures(&header, &parameters, &trials).unwrap();
        assert_eq!(figures.len(), 3);
        for (name, svg) in figures {
            assert!(roxmltree::Document::parse(&svg).is_ok(), "{name}");
        }
        assert_eq!(values_in_words(&trials[0].values), "k 6, patch 24");
    }
}
