//! What people and machines read of a run: tables, charts, pictures, pages, metrics.
//!
//! - [`TextTable`]: short texts as Markdown or HTML.
//! - [`lines_svg`], [`bars_svg`], [`unrolled_svg`], [`limb_row_svg`]: charts and pictures as SVG.
//! - [`Page`]: one HTML file without anything from outside; [`LimbView`] is a limb on it, from four sides
//!   and to be turned.
//! - [`Report`] and [`write_report`]: the same results as page, Markdown and JSON.
//! - [`Origin`]: by what and from what results were made, for pages that are no report.
//! - [`MetricLog`]: metrics as `METRIC:name:value:unit` lines and in a JSON file.
//!
//! Knows nothing of how results arise. Values are drawn in the unit that the caller names.

mod argument;
mod error;
mod figure;
mod headline;
mod metrics;
mod named_text;
mod origin;
mod page;
mod pictures;
mod report;
mod text;

pub use argument::{ArgumentError, check_len};
pub use error::ReportError;
pub use headline::Headline;
pub use metrics::{MetricContext, MetricLog, MetricOutcome, MetricRecord, peak_rss_gib};
pub use origin::Origin;
pub use page::{Block, LimbMap, LimbView, Page};
pub use pictures::{
    BarChart, BarPanel, LimbMarker, LimbPicture, LineChart, Mark, RenderParams, Scatter, Series,
    Unrolled, UnrolledArrow, UnrolledMarker, bars_svg, limb_row_svg, lines_svg, scatter_svg,
    unroll, unrolled_row_svg, unrolled_svg,
};
pub use report::{
    Figure, FigureContent, NamedText, Report, ReportTable, SkippedStage, StageTime, Summary,
    seconds_text, write_report, write_text,
};
pub use text::{TextCell, TextTable, cell_text, escape_html, text_table};
