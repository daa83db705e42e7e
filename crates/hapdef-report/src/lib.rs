//! What people and machines read of a run: tables, charts, pictures, pages, metrics.
//!
//! - [`TextTable`]: short texts as Markdown or HTML.
//! - [`lines_svg`], [`bars_svg`], [`unrolled_svg`], [`render_limb_png`]: charts and pictures as text and
//!   bytes.
//! - [`Page`]: one HTML file without anything from outside; [`LimbView`] is a limb on it, from four sides
//!   and to be turned.
//! - [`Report`] and [`write_report`]: the same results as page, Markdown and JSON.
//! - [`MetricLog`]: figures as `METRIC:name:value:unit` lines and in a JSON file.
//!
//! Knows nothing of how results arise. Values are drawn in the unit that the caller names.

mod error;
mod metrics;
mod page;
mod pictures;
mod report;
mod text;

pub use error::ReportError;
pub use metrics::{MetricContext, MetricLog, MetricOutcome, MetricRecord};
pub use page::{Block, LimbMap, LimbView, Page};
pub use pictures::{
    BarChart, BarPanel, LimbMarker, LimbPicture, LineChart, Mark, RenderParams, Scatter, Series,
    Unrolled, UnrolledArrow, UnrolledMarker, bars_svg, lines_svg, render_limb_png,
    render_limb_row_png, scatter_svg, unroll, unrolled_row_svg, unrolled_svg,
};
pub use report::{
    Figure, FigureContent, NamedText, Report, ReportTable, SkippedStage, StageTime, seconds_text,
    write_report, write_text,
};
pub use text::{TextCell, TextTable, cell_text, escape_html};
