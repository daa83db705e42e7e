//! Table 1 as a chart.

use hapdef_report::{BarChart, BarPanel};

use super::{Method, Table1, TestSet, TrainSet};

/// Table 1 as bars on a log axis: a panel per training set, a group per test set, the paper's
/// number as a black tick; µm.
pub fn table1_bars(table: &Table1) -> BarChart {
    let paper = Table1::paper();
    let cells = |table: &Table1, train| {
        let row = |m| TestSet::ALL.map(|test| table.test(m, train, test)).to_vec();
        Method::ALL.map(row).to_vec()
    };
    BarChart {
        y_label: "displacement error, µm".to_owned(),
        x_label: "contacts in test".to_owned(),
        log_y: true,
        groups: TestSet::ALL.map(|t| t.name().to_owned()).to_vec(),
        series: Method::ALL.map(|m| m.name().to_owned()).to_vec(),
        panels: TrainSet::ALL
            .map(|train| BarPanel {
                title: format!("trained on {}", train.name()),
                values: cells(table, train),
                paper: cells(&paper, train),
                spread: vec![],
            })
            .to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use hapdef_report::bars_svg;

    use super::*;

    /// 1 background, 3 in the legend, one per finite cell; a tick per cell of the paper.
    #[test]
    fn table1_has_a_bar_per_cell() {
        let mut ours = Table1::default();
        let bars = |table: &Table1| count(&bars_svg(&table1_bars(table)).unwrap(), "rect");
        let none = bars(&ours);
        for (i, train) in TrainSet::ALL.into_iter().enumerate() {
            ours.set_test(Method::Fnn, train, TestSet::II, (i + 1) as f64);
        }
        ours.set_test(Method::Linear, TrainSet::I, TestSet::I, f64::NAN);
        assert_eq!(bars(&ours), none + 4, "the NaN draws no bar");
        let svg = bars_svg(&table1_bars(&ours)).unwrap();
        for text in ["LR", "k-NN", "FNN", "paper", "trained on I–III", "IV", "10", "100"] {
            assert!(svg.contains(&format!("{text}\n")), "{text} is missing in {svg}");
        }
        assert!(count(&svg, "polyline") >= 48);
    }

    fn count(svg: &str, name: &str) -> usize {
        let document = roxmltree::Document::parse(svg).unwrap();
        let is = |node: &roxmltree::Node<'_, '_>| node.tag_name().name() == name;
        document.descendants().filter(is).count()
    }
}
