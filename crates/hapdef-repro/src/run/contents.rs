//! The report's tables.

use anyhow::Result;
use hapdef::stages::EvalReport;
use hapdef::{ContactStats, MapError};
use hapdef_bench::{page_table, text_table};
use hapdef_report::{ReportTable, TextCell, TextTable};

use super::made::Made;
use super::patches::{METHODS, SizePoint};
use crate::tables::{
    Claim, MapMetric, OwnAccuracy, PAPER_FVU_DOUBLE, PAPER_FVU_SINGLE, Table1, Table2, claims_text,
};

/// Title of the claims' table.
pub(crate) const CLAIMS: &str = "What the paper claims";

/// Table 2: HapDef 2018's support vectors, the direct net, the chain on one and two contacts.
pub(crate) fn table2(made: &Made<'_>) -> Table2 {
    let column = |name: &str, stats: &ContactStats| OwnAccuracy {
        name: name.into(),
        location_mm: (stats.n > 0).then_some(stats.mean_mm),
        magnitude_n: (stats.n > 0).then_some(stats.mean_n),
    };
    let single = &made.scores.single;
    let mut ours = vec![
        column("HapDef 2018", &made.svr.stats),
        column("direct FNN", &single.direct),
        column("HapDefX single", &single.hapdefx),
    ];
    if let Some(double) = &made.scores.double {
        ours.push(column("HapDefX double", &double.lenient_spread));
    }
    Table2::new(ours)
}

/// The tables of the report.
pub(crate) fn tables(
    made: &Made<'_>,
    table2: &Table2,
    claims: &[Claim],
) -> Result<Vec<ReportTable>> {
    let scores = made.scores;
    let mut tables = vec![page_table(CLAIMS, "", claims_text(claims), claims)?];
    for table in &made.table1 {
        tables.push(table1_part(table)?);
    }
    tables.extend([
        page_table(
            "Table 2: accuracy on the simulated rig (ours / paper)",
            "Means over the contacts that were found (the next table says how many). HapDef \
             2018: support-vector regression. Double contacts are scored by the paper's lenient \
             rule with its T + 1 exchange: each of the top two points to the closest true \
             contact. The human figures are the paper's, not measured here.",
            table2.to_text(),
            table2,
        )?,
        page_table(
            "Contacts in detail",
            "Errors are means over the contacts that were found; those that were not have none. \
             One-to-one: every found contact is matched with one true contact.",
            contact_table(scores),
            scores,
        )?,
        made.both.table()?,
        page_table(
            "Map on the rig: fraction of variance unexplained (ours / paper)",
            "From the rig's readings through F_T and F_R, against the simulated map of the same \
             forces.",
            fvu_table(scores),
            scores,
        )?,
    ]);
    if let Some(sizes) = &made.sizes {
        tables.push(page_table(
            "Figure 5A: mean |error| of the map, µm, by virtual gauges around each gauge",
            "F_T by LR, k-NN and a net, then F_R; every net of this table trained briefly.",
            sizes_table(sizes),
            sizes,
        )?);
    }
    if let Some(ridge) = &made.ridge {
        tables.push(ridge.table(&made.table1[0])?);
    }
    if let Some(ablations) = &made.ablations {
        tables.push(ablations.table()?);
    }
    Ok(tables)
}

/// Table 1 by one metric.
fn table1_part(table: &Table1) -> Result<ReportTable> {
    let (what, note) = match table.metric() {
        MapMetric::MeanAbs => (
            "mean |error| of the map, µm (ours / paper)",
            "Over all surface nodes and test samples. LR: linear regression; k-NN: k = 6, weights \
             1/distance, on standardised inputs; FNN: F_R. Training errors are over at most 2,000 \
             training samples; k-NN leaves the sample itself out. The paper does not say whether \
             it averages absolute values or squares.",
        ),
        MapMetric::Rms => {
            ("RMS error of the map, µm (ours / paper)", "The same by the root of the mean square.")
        }
        MapMetric::Fvu => (
            "fraction of variance unexplained, %",
            "The same by the share of each node's variance that is left.",
        ),
    };
    Ok(page_table(format!("Table 1: {what}"), note, table.to_text(), table)?)
}

/// A row per size, single and double presses for each method.
fn sizes_table(sizes: &[SizePoint]) -> TextTable {
    let mut header = vec!["virtual gauges".to_owned()];
    for contacts in ["single", "double"] {
        header.extend(METHODS.map(|method| format!("{contacts}, {method}")));
    }
    let row = |point: &SizePoint| {
        let mut cells = vec![TextCell::plain(point.size.to_string())];
        for contacts in 0..2 {
            let of = |errors: &[MapError; 2]| format!("{:.2}", errors[contacts].mean_abs_um);
            cells.extend(point.errors.iter().map(|e| TextCell::plain(of(e))));
        }
        cells
    };
    TextTable { header, rows: sizes.iter().map(row).collect() }
}

fn contact_table(scores: &EvalReport) -> TextTable {
    let mut rows = vec![
        ("direct FNN, single", &scores.single.direct),
        ("HapDefX, single", &scores.single.hapdefx),
    ];
    if let Some(double) = &scores.double {
        rows.push(("HapDefX, double, lenient", &double.lenient));
        rows.push(("HapDefX, double, lenient, T + 1", &double.lenient_spread));
        rows.push(("HapDefX, double, one-to-one, T + 1", &double.one_to_one));
    }
    let header = ["", "found", "mean, mm", "median, mm", "p90, mm", "beyond 10 mm", "mean, N"];
    let row = |(name, s): (&str, &ContactStats)| {
        [
            name.to_owned(),
            format!("{} of {}", s.n, s.n_expected),
            format!("{:.2}", s.mean_mm),
            format!("{:.2}", s.median_mm),
            format!("{:.2}", s.p90_mm),
            format!("{:.0} %", s.share_beyond_10mm * 100.0),
            format!("{:.2}", s.mean_n),
        ]
    };
    text_table(header, rows.into_iter().map(row))
}

fn fvu_table(scores: &EvalReport) -> TextTable {
    let percent = |value: f64| format!("{:.1} %", value * 100.0);
    let mut rows = vec![("single", scores.single.map, PAPER_FVU_SINGLE)];
    if let Some(double) = &scores.double {
        rows.push(("double", double.map, PAPER_FVU_DOUBLE));
    }
    let row = |(name, map, paper): (&str, MapError, f64)| {
        let [mean, rms] = [map.mean_abs_um, map.rms_um].map(|um| format!("{um:.2}"));
        [name.to_owned(), percent(map.fvu), percent(paper), mean, rms]
    };
    let header = ["contacts", "FVU", "paper", "mean |error|, µm", "RMS error, µm"];
    text_table(header, rows.into_iter().map(row))
}
