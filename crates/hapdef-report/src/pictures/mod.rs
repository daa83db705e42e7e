//! Figures: charts, the unrolled surface and limbs as SVG.

mod axes;
mod bars;
mod limb;
mod lines;
mod marker;
mod raster;
mod style;
mod unrolled;

pub use bars::{BarChart, BarPanel, bars_svg};
pub use limb::{LimbMarker, LimbPicture, RenderParams, limb_row_svg};
pub use lines::{LineChart, Scatter, Series, lines_svg, scatter_svg};
pub use marker::Mark;
pub use unrolled::{
    Unrolled, UnrolledArrow, UnrolledMarker, unroll, unrolled_row_svg, unrolled_svg,
};
