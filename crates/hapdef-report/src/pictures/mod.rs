//! Figures: charts and the unrolled surface as SVG, limb pictures as PNG.

mod bars;
mod digits;
mod limb;
mod lines;
mod marker;
mod raster;
mod style;
mod unrolled;

pub use bars::{BarChart, BarPanel, bars_svg};
pub use limb::{LimbMarker, LimbPicture, RenderParams, render_limb_png, render_limb_row_png};
pub use lines::{LineChart, Scatter, Series, lines_svg, scatter_svg};
pub use marker::Mark;
pub use unrolled::{
    Unrolled, UnrolledArrow, UnrolledMarker, unroll, unrolled_row_svg, unrolled_svg,
};
