//! Pixels of a page.

use std::collections::BTreeSet;
use std::io::Cursor;

use serde::Deserialize;

use crate::chrome::{Chrome, Fault};

/// Where the limb is on a row of pixels.
#[derive(Debug, Deserialize)]
pub struct LimbRow {
    y_px: f64,
    left_px: f64,
    right_px: f64,
}

impl LimbRow {
    /// From the nodes that are drawn within 8 px of that row.
    pub fn of(chrome: &mut Chrome, y_px: f64) -> Result<Self, Fault> {
        let nodes = "Array.from({ length: hapdefView.nodes }, (_, i) => hapdefView.project(i))";
        let near = format!("{nodes}.filter((at) => Math.abs(at[1] - {y_px}) < 8)");
        let row = format!(
            "(() => {{ const x = {near}.map((at) => at[0]); \
             return {{ y_px: {y_px}, left_px: Math.min(...x), right_px: Math.max(...x) }}; }})()"
        );
        Ok(serde_json::from_value(chrome.eval(&row)?)?)
    }
}

/// RGB pixels of a page, row by row.
pub struct Pixels {
    colours: Vec<[u8; 3]>,
    width: usize,
}

impl Pixels {
    pub fn of(chrome: &mut Chrome) -> Result<Self, Fault> {
        let mut decoder = png::Decoder::new(Cursor::new(chrome.screenshot()?));
        decoder.set_transformations(png::Transformations::STRIP_16 | png::Transformations::ALPHA);
        let mut reader = decoder.read_info()?;
        let mut bytes = vec![0; reader.output_buffer_size().ok_or("a picture too large")?];
        let info = reader.next_frame(&mut bytes)?;
        let colours = bytes[..info.buffer_size()]
            .chunks_exact(4)
            .map(|p| [p[0], p[1], p[2]]);
        Ok(Self {
            colours: colours.collect(),
            width: info.width as usize,
        })
    }

    /// On a row of pixels, between the limb's outermost nodes there, are many colours: a shaded limb, not a flat ground.
    #[track_caller]
    pub fn shows_limb_across(&self, row: &LimbRow) {
        let at = |x: usize| self.colours[row.y_px as usize * self.width + x];
        let margin_px = 0.1 * (row.right_px - row.left_px);
        let inner = (row.left_px + margin_px) as usize..(row.right_px - margin_px) as usize;
        let across: Vec<_> = inner.map(at).collect();
        let differs = |p: &&[u8; 3]| (0..3).any(|k| p[k].abs_diff(at(20)[k]) > 24);
        let n_far = across.iter().filter(differs).count();
        let n_colours = across.iter().collect::<BTreeSet<_>>().len();
        let n = across.len();
        assert!(
            n >= 20 && 20 * n_far >= 19 * n && n_colours >= 6,
            "{n_far} of {n} differ from the ground, {n_colours} colours: {row:?}"
        );
    }

    /// How many have the orange of the first contact.
    pub fn n_orange(&self) -> usize {
        let orange = |p: &&[u8; 3]| p[0] > 200 && (70..190).contains(&p[1]) && p[2] < 110;
        self.colours.iter().filter(orange).count()
    }
}
