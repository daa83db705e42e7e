//! What comes first on the page of a study: how many figures are what was asked for, and three of them.

use hapdef_report::{Figure, Headline, Summary};

use crate::target::Target;

/// Figures in large type.
const N_NUMBERS: usize = 3;

/// Missed figures that the sentence names.
const N_NAMED: usize = 3;

/// Units that end a figure's words.
const UNITS: [&str; 8] = ["mm", "m", "N", "%", "µε", "µs", "ms", "s"];

/// The top of a page over `targets`, the most important first; nothing where none was measured.
pub(crate) fn summary(targets: &[Target], picture: Option<Figure>) -> Option<Summary> {
    let measured: Vec<(&Target, f64)> =
        targets.iter().filter_map(|target| Some((target, target.measured?))).collect();
    if measured.is_empty() {
        return None;
    }
    let numbers = measured.iter().take(N_NUMBERS).map(|(target, value)| headline(target, *value));
    Some(Summary {
        sentence: sentence(&measured, targets.len() - measured.len()),
        numbers: numbers.collect(),
        picture,
        next: Vec::new(),
    })
}

fn sentence(measured: &[(&Target, f64)], n_unmeasured: usize) -> String {
    let missed = measured.iter().filter(|(target, value)| !target.wanted.is_met(*value));
    let missed: Vec<&str> = missed.map(|(target, _)| target.what).collect();
    let (n, n_met) = (measured.len(), measured.len() - missed.len());
    let mut text = format!("{n_met} of {n} figures are what was asked for.");
    if !missed.is_empty() {
        let named = missed[..missed.len().min(N_NAMED)].join("; ");
        let more = if missed.len() > N_NAMED { "; …" } else { "" };
        text.push_str(&format!(" Missed: {named}{more}."));
    }
    if n_unmeasured > 0 {
        text.push_str(&format!(" Not measured: {n_unmeasured}."));
    }
    text
}

fn headline(target: &Target, value: f64) -> Headline {
    let (what, unit) = match target.what.rsplit_once(", ") {
        Some((what, unit)) if UNITS.contains(&unit) => (what, format!(" {unit}")),
        _ => (target.what, String::new()),
    };
    let verdict = if target.wanted.is_met(value) { "met" } else { "missed" };
    Headline {
        value: format!("{value:.2}{unit}"),
        what: what.to_owned(),
        beside: format!("asked: {}; {verdict}", target.wanted.text()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::target::Wanted;

    #[test]
    fn the_first_figures_and_what_was_missed_come_first() {
        let target = |what, most, measured| Target { what, wanted: Wanted::AtMost(most), measured };
        let targets = [
            target("one contact, mean, mm", 0.3, Some(0.264)),
            target("one contact, median, mm", 0.15, Some(0.2)),
            target("the paper's error over ours", 8.0, None),
        ];
        let summary = summary(&targets, None).unwrap();
        assert_eq!(
            summary.sentence,
            "1 of 2 figures are what was asked for. Missed: one contact, median, mm. Not measured: 1."
        );
        let numbers: Vec<[&str; 3]> =
            summary.numbers.iter().map(|n| [&*n.value, &*n.what, &*n.beside]).collect();
        assert_eq!(numbers[0], ["0.26 mm", "one contact, mean", "asked: at most 0.3; met"]);
        assert_eq!(numbers[1][2], "asked: at most 0.15; missed");
        assert!(super::summary(&targets[2..], None).is_none());
    }
}
