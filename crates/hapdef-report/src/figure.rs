//! A figure and the numbers that it draws.

use serde::Serialize;
use serde_json::Value;

use crate::error::ReportError;
use crate::pictures::{
    BarChart, LimbPicture, LineChart, RenderParams, Unrolled, bars_svg, limb_row_svg, lines_svg,
    unrolled_row_svg, unrolled_svg,
};

/// What a figure consists of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FigureContent {
    /// An SVG document.
    Svg(String),
    /// PNG bytes.
    Png(Vec<u8>),
}

/// A figure.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figure {
    /// File name in the report's folder, ending in .svg or .png.
    pub file: String,
    /// What is seen.
    pub caption: String,
    /// The picture.
    #[serde(skip)]
    pub content: FigureContent,
    /// The numbers that are drawn, for a file of the same name that ends in .json; null for none.
    #[serde(skip)]
    pub data: Value,
}

impl Figure {
    /// A line chart.
    ///
    /// # Errors
    /// Those of [`lines_svg`].
    pub fn lines(
        file: impl Into<String>,
        caption: impl Into<String>,
        chart: &LineChart,
    ) -> Result<Self, ReportError> {
        Self::drawn(file, caption, lines_svg(chart)?, chart)
    }

    /// Grouped bars.
    ///
    /// # Errors
    /// Those of [`bars_svg`].
    pub fn bars(
        file: impl Into<String>,
        caption: impl Into<String>,
        chart: &BarChart,
    ) -> Result<Self, ReportError> {
        Self::drawn(file, caption, bars_svg(chart)?, chart)
    }

    /// Unrolled surfaces side by side.
    ///
    /// # Errors
    /// Those of [`unrolled_svg`] and [`unrolled_row_svg`].
    pub fn unrolled(
        file: impl Into<String>,
        caption: impl Into<String>,
        panels: &[Unrolled<'_>],
    ) -> Result<Self, ReportError> {
        let text = match panels {
            [one] => unrolled_svg(one)?,
            row => unrolled_row_svg(row)?,
        };
        Self::drawn(file, caption, text, panels)
    }

    /// Pictures of a limb side by side. Nodes and triangles are no part of the numbers.
    ///
    /// # Errors
    /// Those of [`limb_row_svg`].
    pub fn limbs(
        file: impl Into<String>,
        caption: impl Into<String>,
        pictures: &[(LimbPicture<'_>, RenderParams)],
    ) -> Result<Self, ReportError> {
        let drawn: Vec<&LimbPicture<'_>> = pictures.iter().map(|(picture, _)| picture).collect();
        Self::drawn(file, caption, limb_row_svg(pictures)?, &drawn)
    }

    fn drawn(
        file: impl Into<String>,
        caption: impl Into<String>,
        svg: String,
        numbers: &(impl Serialize + ?Sized),
    ) -> Result<Self, ReportError> {
        let file = file.into();
        let data = serde_json::to_value(numbers).map_err(ReportError::json(file.as_ref()))?;
        Ok(Self { file, caption: caption.into(), content: FigureContent::Svg(svg), data })
    }

    /// Name of the file that holds its numbers, if it has any.
    pub(super) fn data_file(&self) -> Option<String> {
        let (stem, _) = self.file.rsplit_once('.')?;
        (!self.data.is_null()).then(|| format!("{stem}.json"))
    }
}
