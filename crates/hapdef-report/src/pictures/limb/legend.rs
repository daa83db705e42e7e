//! What stands around the picture of a limb: title, colour bar, length bar.

use std::fmt::Write as _;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use hapdef_mesh::colour::viridis;

use super::super::style::tick;
use super::BAR_PX;
use crate::text::escape_html as escape;

/// Room for the title above a picture, px.
const TITLE_PX: u32 = 34;

/// Room for the length bar below a picture, px.
const RULER_PX: u32 = 48;

/// Boxes of the colour bar.
const N_BOXES: u32 = 64;

/// The highest that a colour bar is, px.
const MAX_BAR_PX: u32 = 320;

/// A picture and what is to be read of it.
pub(super) struct Legend<'a> {
    /// PNG bytes, without the room of the colour bar.
    pub(super) picture: Vec<u8>,
    /// Width with the room of the colour bar, and height of the picture.
    pub(super) size_px: [u32; 2],
    pub(super) title: &'a str,
    /// Quantity and unit; empty for no colour bar.
    pub(super) value_label: &'a str,
    /// Values of the first and of the last colour.
    pub(super) scale: [f64; 2],
    /// Of lengths across the line of sight.
    pub(super) px_per_m: f64,
}

/// Pictures side by side as one SVG document.
pub(super) fn row_svg(panels: &[Legend<'_>]) -> String {
    let width: u32 = panels.iter().map(|panel| panel.size_px[0]).sum();
    let tallest = panels.iter().map(|panel| panel.size_px[1]).max();
    let height = tallest.unwrap_or_default() + TITLE_PX + RULER_PX;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"14\" fill=\"#222\">\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>"
    );
    let mut left = 0;
    for panel in panels {
        let _ = write!(svg, "<g transform=\"translate({left},0)\">");
        svg.push_str(&panel.limb());
        if !panel.value_label.is_empty() {
            svg.push_str(&panel.colour_bar());
        }
        svg.push_str(&panel.ruler());
        svg.push_str("</g>");
        left += panel.size_px[0];
    }
    svg.push_str("</svg>\n");
    svg
}

impl Legend<'_> {
    fn limb(&self) -> String {
        let [width, height] = [self.size_px[0] - BAR_PX, self.size_px[1]];
        let data = STANDARD.encode(&self.picture);
        format!(
            "<text x=\"{}\" y=\"23\" font-size=\"17\" text-anchor=\"middle\">{}</text>\
             <image y=\"{TITLE_PX}\" width=\"{width}\" height=\"{height}\" href=\"data:image/png;base64,{data}\"/>",
            width / 2,
            escape(self.title)
        )
    }

    fn colour_bar(&self) -> String {
        let left = self.size_px[0] - BAR_PX + 8;
        let top = TITLE_PX + 24;
        let height = (self.size_px[1] - 48).min(MAX_BAR_PX);
        let box_px = f64::from(height) / f64::from(N_BOXES);
        let mut svg =
            format!("<text x=\"{left}\" y=\"{}\">{}</text>", top - 12, escape(self.value_label));
        for k in 0..N_BOXES {
            let [r, g, b] = viridis(1.0 - f64::from(k) / f64::from(N_BOXES - 1));
            let y = f64::from(top) + f64::from(k) * box_px;
            let _ = write!(
                svg,
                "<rect x=\"{left}\" y=\"{y:.2}\" width=\"16\" height=\"{:.2}\" fill=\"#{r:02x}{g:02x}{b:02x}\"/>",
                box_px + 0.5
            );
        }
        let [low, high] = self.scale;
        for k in 0..=4 {
            let value = tick(high - (high - low) * f64::from(k) / 4.0);
            let (x, y) = (left + 22, top + height * k / 4 + 5);
            let _ = write!(svg, "<text x=\"{x}\" y=\"{y}\">{value}</text>");
        }
        svg
    }

    /// A length bar of 1, 2 or 5 · 10ⁿ mm, at most two fifths of the width.
    fn ruler(&self) -> String {
        let px_per_mm = 1e-3 * self.px_per_m;
        let mm = round_length(0.4 * f64::from(self.size_px[0]) / px_per_mm);
        let y = self.size_px[1] + TITLE_PX + RULER_PX - 12;
        format!(
            "<path d=\"M12 {0}V{y}H{1:.1}V{0}\" fill=\"none\" stroke=\"#222\" stroke-width=\"2\"/>\
             <text x=\"12\" y=\"{2}\">{mm} mm</text>",
            y - 7,
            12.0 + mm * px_per_mm,
            y - 13
        )
    }
}

/// The longest of 1, 2 or 5 · 10ⁿ that is at most `most`.
fn round_length(most: f64) -> f64 {
    let power = 10_f64.powf(most.log10().floor());
    let steps = [5.0, 2.0, 1.0].map(|step| step * power);
    steps.into_iter().find(|step| *step <= most).unwrap_or(power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_round() {
        let found = [1.0, 1.9, 4.9, 73.0, 0.25].map(round_length);
        assert_eq!(found, [1.0, 1.0, 2.0, 50.0, 0.2]);
    }
}
