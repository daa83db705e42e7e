//! The report's tables.

use anyhow::Result;
use hapdef::stages::EvalReport;
use hapdef::{ContactStats, MapError};
use hapdef_bench::text_table;
use hapdef_report::{ReportTable, TextCell, TextTable};

use super::patches::{METHODS, SizePoint};
use super::scores::Scores;
use crate::tables::{
    Claim, MapMetric, OwnAccuracy, PAPER_FVU_DOUBLE, PAPER_FVU_SINGLE, Table1, Table2, claims_text,
};

/// Title of the claims' table.
pub(crate) const CLAIMS: &str = "What the paper claims";

/// The paper's claims and how they fared.
pub(crate) fn claims_table(claims: &[Claim]) -> Result<ReportTable> {
    Ok(ReportTable {
        title: CLAIMS.into(),
        note: String::new(),
        text: claims_text(claims),
        data: serde_json::to_value(claims)?,
    })
}

/// Table 2: HapDef 2018's support vectors, the direct net, the chain on one and two contacts.
pub(crate) fn table2(scores: &EvalReport, svr: &ContactStats) -> Table2 {
    let column = |name: &str, stats: &ContactStats| OwnAccuracy {
        name: name.into(),
        location_m: (stats.n > 0).then_some(stats.mean_mm * 1e-3),
        magnitude_n: (stats.n > 0).then_some(stats.mean_n),
    };
    let single = &scores.single;
    let mut ours = vec![
        column("HapDef 2018", svr),
        column("direct FNN", &single.direct),
        column("HapDefX single", &single.hapdefx),
    ];
    if let Some(double) = &scores.double {
        ours.push(column("HapDefX double", &double.lenient_spread));
    }
    Table2 { ours }
}

/// The tables of the report.
pub(crate) fn tables(
    table1: &[Table1],
    table2: &Table2,
    scores: &EvalReport,
    both: &Scores,
    sizes: Option<&[SizePoint]>,
) -> Result<Vec<ReportTable>> {
    let mut tables = table1.iter().map(table1_part).collect::<Result<Vec<_>>>()?;
    tables.push(ReportTable {
        title: "Table 2: accuracy on the simulated rig (ours / paper)".into(),
        note: "Means over the contacts that were found (the next table says how many). HapDef \
               2018: support-vector regression. Double contacts are scored by the paper's lenient \
               rule with its T + 1 exchange: each of the top two points to the closest true \
               contact. The human figures are the paper's, not measured here."
            .into(),
        text: table2.to_text(),
        data: serde_json::to_value(table2)?,
    });
    tables.push(ReportTable {
        title: "Contacts in detail".into(),
        note: "Errors are means over the contacts that were found; those that were not have none. \
               One-to-one: every found contact is matched with one true contact."
            .into(),
        text: contact_table(scores),
        data: serde_json::to_value(scores)?,
    });
    tables.push(both.table()?);
    tables.push(ReportTable {
        title: "Map on the rig: fraction of variance unexplained (ours / paper)".into(),
        note: "From the rig's readings through F_T and F_R, against the simulated map of the same \
               forces."
            .into(),
        text: fvu_table(scores),
        data: serde_json::to_value(scores)?,
    });
    if let Some(sizes) = sizes {
        tables.push(ReportTable {
            title: "Figure 5A: mean |error| of the map, µm, by virtual gauges around each gauge"
                .into(),
            note: "F_T by LR, k-NN and a net, then F_R; every net of this table trained briefly."
                .into(),
            text: sizes_table(sizes),
            data: serde_json::to_value(sizes)?,
        });
    }
    Ok(tables)
}

/// Table 1 by one metric.
fn table1_part(table: &Table1) -> Result<ReportTable> {
    let (what, paper) = match table.metric() {
        MapMetric::MeanAbs => ("mean |error| of the map, µm", " (ours / paper)"),
        MapMetric::Rms => ("RMS error of the map, µm", " (ours / paper)"),
        MapMetric::Fvu => ("fraction of variance unexplained, %", ""),
    };
    let note = match table.metric() {
        MapMetric::MeanAbs => {
            "Over all surface nodes and test samples. LR: linear regression; k-NN: k = 6, weights \
             1/distance, on standardised inputs; FNN: F_R. Training errors are over at most 2,000 \
             training samples; k-NN leaves the sample itself out. The paper does not say whether \
             it averages absolute values or squares."
        }
        MapMetric::Rms => "The same by the root of the mean square.",
        MapMetric::Fvu => "The same by the share of each node's variance that is left.",
    };
    Ok(ReportTable {
        title: format!("Table 1: {what}{paper}"),
        note: note.into(),
        text: table.to_text(),
        data: serde_json::to_value(table)?,
    })
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
