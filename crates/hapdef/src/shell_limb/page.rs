//! The page of a comparison: verdict, tables, the limb from four sides.

use hapdef_bench::stats::{quantile, sorted};
use hapdef_report::{Block, LimbMap, LimbView, TextTable, text_table};

use super::{GaugeDifference, ShellComparison, ShellVerdict};
use crate::convergence::GOOD_DIFFERENCE;

/// Differences above this have the last colour, unless most are below.
const LEAST_DIFFERENCE_RANGE: f64 = 0.2;

/// What the page says of one solid.
pub(super) fn blocks(comparison: &ShellComparison) -> Vec<Block> {
    vec![
        Block::Heading(format!("Against {}", comparison.solid)),
        Block::Verdict {
            text: comparison.advice(),
            warns: comparison.verdict == ShellVerdict::UseTheSolid,
        },
        Block::Table(text_table(
            ["from the solid", "median %", "worst %", "overall %", "ratio, median"],
            comparison.table(),
        )),
        Block::Note(shares(comparison)),
        Block::Limb(limb(comparison)),
        Block::Heading("Gauges".into()),
        Block::Table(gauges(comparison)),
        Block::Note(format!(
            "Readings are for a newton where the solid's gauge reads most; differences are over all \
             {} places.",
            comparison.n_touches
        )),
    ]
}

fn shares(comparison: &ShellComparison) -> String {
    let above = &comparison.above_good;
    format!(
        "Off by more than {:.0} %: {:.1} % of the compared surface by displacement ({} presses), \
         {:.1} % by gauge strain ({} places). {} FE nodes, {} equations. Each place has a newton of \
         its own; the map shows the answer at the nearest place. Dark grey: not compared, held or \
         not wholly on the shell ({} places). Light grey: the inner side.",
        100.0 * GOOD_DIFFERENCE,
        100.0 * above.tip_share,
        comparison.n_tips,
        100.0 * above.readings_share,
        comparison.n_touches,
        comparison.n_fe_nodes,
        comparison.n_equations,
        comparison.n_touches_left_out
    )
}

fn limb(comparison: &ShellComparison) -> LimbView {
    let skin = &comparison.skin;
    let maps = &comparison.maps;
    let tip = ["displacement under the tip", "displacement"];
    let readings = ["gauge strain, all gauges", "gauge strain"];
    let rows = [(&maps.tip, "µm/N", tip), (&maps.readings, "µε/N", readings)];
    let maps = rows.into_iter().flat_map(|(fields, unit, names)| maps_of(fields, unit, names));
    let gauges = comparison.gauges.iter().map(|g| g.position_m);
    LimbView::new(skin, maps.collect(), gauges.collect())
}

/// Of the solid, the shell and their difference; solid and shell have one scale.
fn maps_of(fields: &[Vec<f64>; 3], unit: &str, [answer, short]: [&str; 2]) -> [LimbMap; 3] {
    let [solid, shell, difference] = fields.each_ref().map(Vec::as_slice);
    let high = |values: &[&[f64]], share: f64| {
        let compared = values.concat().into_iter().filter(|v| !v.is_nan());
        quantile(&sorted(compared), share)
    };
    let most = high(&[solid, shell], 0.99);
    let far = high(&[difference], 0.95).max(LEAST_DIFFERENCE_RANGE);
    let map = |title: String, values: &[f64], unit: &str, factor, high| LimbMap {
        title,
        unit: unit.into(),
        factor,
        values: values.to_vec(),
        range: [0.0, high],
    };
    [
        map(format!("{answer}: solid"), solid, unit, 1.0, most),
        map(format!("{answer}: shell"), shell, unit, 1.0, most),
        map(format!("{short}: shell from solid"), difference, "%", 100.0, far),
    ]
}

/// Each gauge where the solid's reads most; the difference is over all places.
fn gauges(comparison: &ShellComparison) -> TextTable {
    let row = |(i, gauge): (usize, &GaugeDifference)| {
        let [x, y, z] = gauge.position_m.map(|c| 1e3 * c);
        vec![
            i.to_string(),
            format!("{x:.1} {y:.1} {z:.1}"),
            format!("{:.1}", gauge.solid_ue_per_n),
            format!("{:.1}", gauge.shell_ue_per_n),
            format!("{:.1}", 100.0 * gauge.difference),
        ]
    };
    text_table(
        ["gauge", "at, mm", "solid µε/N", "shell µε/N", "difference %"],
        comparison.gauges.iter().enumerate().map(row),
    )
}
