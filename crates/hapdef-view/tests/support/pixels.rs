//! Pixels of a page.

use std::collections::BTreeSet;
use std::io::Cursor;

use crate::chrome::{Chrome, Fault};

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

    /// Around that place there are many colours: a shaded limb, not a flat ground.
    #[track_caller]
    pub fn shows_limb_at(&self, (x, y): (f64, f64)) {
        let at = |x: i64| self.colours[y as usize * self.width + x as usize];
        let around: Vec<_> = (-60..60).step_by(3).map(|by| at(x as i64 + by)).collect();
        let differs = |p: &&[u8; 3]| (0..3).any(|k| p[k].abs_diff(at(20)[k]) > 24);
        let n_far = around.iter().filter(differs).count();
        let n_colours = around.iter().collect::<BTreeSet<_>>().len();
        let n = around.len();
        assert!(
            n_far >= 30 && n_colours >= 6,
            "{n_far} of {n} differ from the ground, {n_colours} colours"
        );
    }

    /// How many have the orange of the first contact.
    pub fn n_orange(&self) -> usize {
        let orange = |p: &&[u8; 3]| p[0] > 200 && (70..190).contains(&p[1]) && p[2] < 110;
        self.colours.iter().filter(orange).count()
    }
}
