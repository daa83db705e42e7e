//! The paper's tables as data, ours beside them, and what they say.

mod claim;
mod metric;
mod orderings;
mod table1;
mod table1_bars;
mod table2;

pub use claim::{Check, Claim, Fate, MetricVerdict, claims_text};
pub use metric::MapMetric;
pub use orderings::{fnn_over_lr, table1_claims};
pub use table1::{Method, Table1, TestSet, TrainSet, TrainedMethod};
pub use table1_bars::table1_bars;
pub use table2::{
    OwnAccuracy, PAPER_FVU_DOUBLE, PAPER_FVU_SINGLE, PAPER_TABLE2, PaperAccuracy, Table2,
};

/// How many cells of a table there are, hold a number, or hold a NaN or infinity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct CellCount {
    /// Cells the table has.
    pub total: usize,
    /// Cells that were measured, whatever came out.
    pub measured: usize,
    /// Measured cells whose value is not finite.
    pub nan: usize,
}

impl CellCount {
    fn of(cells: impl Iterator<Item = Option<f64>>) -> Self {
        let mut count = Self::default();
        for cell in cells {
            count.total += 1;
            count.measured += usize::from(cell.is_some());
            count.nan += usize::from(cell.is_some_and(|v| !v.is_finite()));
        }
        count
    }
}
