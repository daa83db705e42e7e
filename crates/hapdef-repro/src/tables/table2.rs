//! Table 2: accuracy of position and force.

use hapdef_bench::text_table;
use hapdef_report::{TextTable, cell_text};

use super::CellCount;

/// Fraction of variance unexplained of the map, one contact (Sun & Martius 2019).
pub const PAPER_FVU_SINGLE: f64 = 0.04;
/// Fraction of variance unexplained of the map, two contacts (Sun & Martius 2019).
pub const PAPER_FVU_DOUBLE: f64 = 0.29;

/// A column of the paper's table.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct PaperAccuracy {
    /// The paper's heading.
    pub name: &'static str,
    /// Lowest and highest location error printed, mm; equal where one number is printed.
    pub location_mm: [f64; 2],
    /// Magnitude error, N; `None` where the paper prints none.
    pub magnitude_n: Option<f64>,
}

const fn paper(name: &'static str, low: f64, high: f64, n: Option<f64>) -> PaperAccuracy {
    PaperAccuracy { name, location_mm: [low, high], magnitude_n: n }
}

/// Table 2 of Sun & Martius 2019; the last three are human skin.
pub const PAPER_TABLE2: [PaperAccuracy; 7] = [
    paper("HapDef 2018", 8.0, 8.0, Some(1.6)),
    paper("direct FNN", 3.0, 3.0, Some(1.5)),
    paper("HapDefX single", 5.0, 5.0, Some(3.0)),
    paper("HapDefX double", 10.0, 10.0, Some(6.0)),
    paper("fingertip (human)", 2.0, 8.0, None),
    paper("palm (human)", 8.0, 12.0, None),
    paper("shin (human)", 30.0, 40.0, None),
];

/// What was measured here for one estimator and kind of press; JSON has null for what is not finite, too.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct OwnAccuracy {
    /// Heading; one of [`PAPER_TABLE2`]'s names if it is that column's counterpart.
    pub name: String,
    /// Location error, mm; `None` if not measured.
    pub location_mm: Option<f64>,
    /// Magnitude error, N; `None` if not measured.
    pub magnitude_n: Option<f64>,
}

/// Ours, in the order entered, beside the paper's columns.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Table2 {
    /// Columns measured here.
    pub ours: Vec<OwnAccuracy>,
    paper: [PaperAccuracy; 7],
}

impl Table2 {
    /// With these columns.
    pub fn new(ours: Vec<OwnAccuracy>) -> Self {
        Self { ours, paper: PAPER_TABLE2 }
    }

    /// Two cells per column of ours.
    pub fn cells(&self) -> CellCount {
        CellCount::of(self.ours.iter().flat_map(|c| [c.location_mm, c.magnitude_n]))
    }

    /// One row per column of the paper, then ours without a counterpart there.
    pub fn to_text(&self) -> TextTable {
        let header = ["", "location, mm", "paper", "magnitude, N", "paper"];
        let of = |name: &str| self.ours.iter().find(|c| c.name == name);
        let papers = PAPER_TABLE2.iter().map(|p| row(p.name, of(p.name), Some(p)));
        let extra = |c: &&OwnAccuracy| PAPER_TABLE2.iter().all(|p| p.name != c.name);
        let extras = self.ours.iter().filter(extra).map(|c| row(&c.name, Some(c), None));
        text_table(header, papers.chain(extras))
    }
}

fn row(name: &str, ours: Option<&OwnAccuracy>, paper: Option<&PaperAccuracy>) -> [String; 5] {
    let paper_location = match paper.map(|p| p.location_mm) {
        None => "–".to_owned(),
        Some([low, high]) if low < high => format!("{low}–{high}"),
        Some([low, _]) => low.to_string(),
    };
    let paper_magnitude =
        paper.and_then(|p| p.magnitude_n).map_or("–".to_owned(), |n| n.to_string());
    [
        name.to_owned(),
        cell_text(ours.and_then(|c| c.location_mm)),
        paper_location,
        cell_text(ours.and_then(|c| c.magnitude_n)),
        paper_magnitude,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ours_stand_beside_the_papers() {
        let column = |name: &str, location_mm, magnitude_n| OwnAccuracy {
            name: name.to_owned(),
            location_mm,
            magnitude_n,
        };
        let table = Table2::new(vec![
            column("HapDefX double", Some(12.3), Some(f64::NAN)),
            column("inverse double", Some(1.9), None),
        ]);
        assert_eq!(table.cells(), CellCount { total: 4, measured: 3, nan: 1 });
        let text = table.to_text().to_markdown();
        assert!(text.contains("| HapDefX double | 12.3 | 10 | NaN | 6 |"), "{text}");
        assert!(text.contains("| inverse double | 1.9 | – | – | – |"), "{text}");
        assert!(text.contains("| fingertip (human) | – | 2–8 | – | – |"), "{text}");
        let json = serde_json::to_value(&table).unwrap();
        assert_eq!(json["ours"][0]["magnitude_n"], serde_json::Value::Null);
        assert_eq!(json["paper"][3]["magnitude_n"], 6.0);
    }
}
