//! Pixels of a page.

use std::collections::BTreeSet;
use std::io::Cursor;

use serde::Deserialize;

use super::chrome::{Chrome, Fault};

/// Where the limb is on a row of pixels.
#[derive(Debug, Deserialize)]
pub struct LimbRow {
    y_px: f64,
    left_px: f64,
    right_px: f64,
}

impl LimbRow {
    /// On the row `below_px` under a node, from the nodes that are drawn within 8 px of it.
    pub fn of_node(chrome: &mut Chrome, node: u64, below_px: f64) -> Result<Self, Fault> {
        let at = chrome.eval(&format!("hapdefView.project({node})[1]"))?;
        let y_px = at.as_f64().ok_or("no place of the node")? + below_px;
        let nodes = "Array.from({ length: hapdefView.nodes }, (_, i) => hapdefView.project(i))";
        let near = format!("{nodes}.filter((at) => Math.abs(at[1] - {y_px}) < 8)");
        let row = format!(
            "(() => {{ const x = {near}.map((at) => at[0]); \
             return {{ y_px: {y_px}, left_px: Math.min(...x), right_px: Math.max(...x) }}; }})()"
        );
        Ok(serde_json::from_value(chrome.eval(&row)?)?)
    }
}

/// What stands over the limb.
const OVER: &str = "#labels, #tools, #legend, #ruler, #axes, #say";
/// Distance from the limb's outermost node to what is surely ground.
const GROUND_PX: f64 = 16.0;

/// RGB pixels of a page, row by row.
pub struct Pixels {
    colours: Vec<[u8; 3]>,
    width: usize,
}

impl Pixels {
    /// Of the page with nothing over the limb.
    pub fn of_stage(chrome: &mut Chrome) -> Result<Self, Fault> {
        show_over(chrome, "hidden")?;
        let pixels = Self::of(chrome);
        show_over(chrome, "")?;
        pixels
    }

    fn of(chrome: &mut Chrome) -> Result<Self, Fault> {
        let mut decoder = png::Decoder::new(Cursor::new(chrome.screenshot()?));
        decoder.set_transformations(png::Transformations::STRIP_16 | png::Transformations::ALPHA);
        let mut reader = decoder.read_info()?;
        let mut bytes = vec![0; reader.output_buffer_size().ok_or("a picture too large")?];
        let info = reader.next_frame(&mut bytes)?;
        let colours = bytes[..info.buffer_size()].chunks_exact(4).map(|p| [p[0], p[1], p[2]]);
        Ok(Self { colours: colours.collect(), width: info.width as usize })
    }

    /// On a row of pixels, between the limb's outermost nodes there, are many colours: a shaded limb, not a flat ground.
    #[track_caller]
    pub fn shows_limb_across(&self, row: &LimbRow) {
        let at = |x: usize| self.colours[row.y_px as usize * self.width + x];
        let ground = at((row.left_px - GROUND_PX) as usize);
        let margin_px = 0.1 * (row.right_px - row.left_px);
        let inner = (row.left_px + margin_px) as usize..(row.right_px - margin_px) as usize;
        let across: Vec<_> = inner.map(at).collect();
        let differs = |p: &&[u8; 3]| (0..3).any(|k| p[k].abs_diff(ground[k]) > 24);
        let n_far = across.iter().filter(differs).count();
        let n_colours = across.iter().collect::<BTreeSet<_>>().len();
        let n = across.len();
        assert!(
            n >= 20 && 20 * n_far >= 19 * n && n_colours >= 6,
            "{n_far} of {n} differ from the ground, {n_colours} colours: {row:?}"
        );
    }

    /// Share of a line, from pixel to pixel, that has the orange of the first contact.
    pub fn orange_share(&self, from: [f64; 2], to: [f64; 2]) -> f64 {
        let n = (to[0] - from[0]).hypot(to[1] - from[1]).ceil() as usize;
        assert!(n > 20, "{from:?} to {to:?} is too short to tell");
        let at = |i: usize| {
            let part = i as f64 / n as f64;
            let [x, y] = [0, 1].map(|k| (from[k] + part * (to[k] - from[k])) as usize);
            self.colours[y * self.width + x]
        };
        let is_orange = |p: &[u8; 3]| p[0] > 200 && (70..190).contains(&p[1]) && p[2] < 110;
        (0..n).map(at).filter(is_orange).count() as f64 / n as f64
    }
}

fn show_over(chrome: &mut Chrome, visibility: &str) -> Result<(), Fault> {
    let set = format!("part.style.visibility = '{visibility}'");
    chrome.eval(&format!("document.querySelectorAll('{OVER}').forEach((part) => {{ {set}; }})"))?;
    Ok(())
}
