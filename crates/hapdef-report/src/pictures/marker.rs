//! Marks on pictures of the limb.

use serde::Serialize;
use tiny_skia::{Color, FillRule, Paint, Path, PathBuilder, Pixmap, Rect, Stroke, Transform};

const INK: [u8; 3] = [34, 34, 34];
const RED: [u8; 3] = [220, 30, 30];
const BLUE: [u8; 3] = [30, 90, 220];
const GOLD: [u8; 3] = [240, 180, 0];

/// What a mark stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Mark {
    /// A true contact: a red ring.
    True,
    /// A contact that was found: a dark cross.
    Found,
    /// A candidate or a node: a blue dot.
    Dot,
    /// A gauge's centre: a yellow square.
    Gauge,
}

fn paint([r, g, b]: [u8; 3], alpha: u8) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color(Color::from_rgba8(r, g, b, alpha));
    paint
}

/// Draws a mark at a pixel, set off by white from any colour.
pub(super) fn draw_marker(pixmap: &mut Pixmap, at: (f32, f32), mark: Mark, hidden: bool) {
    let Some(path) = outline(mark, at) else {
        return;
    };
    let alpha = if hidden { 90 } else { 255 };
    let stroke = |pixmap: &mut Pixmap, colour, width| {
        let stroke = Stroke { width, ..Stroke::default() };
        let paint = paint(colour, alpha);
        pixmap.stroke_path(&path, &paint, &stroke, Transform::identity(), None);
    };
    match mark {
        Mark::True | Mark::Found => {
            stroke(pixmap, [255; 3], 6.0);
            stroke(pixmap, if mark == Mark::True { RED } else { INK }, 3.0);
        }
        Mark::Dot | Mark::Gauge => {
            stroke(pixmap, [255; 3], 1.6);
            let colour = paint(if mark == Mark::Dot { BLUE } else { GOLD }, alpha);
            let whole = FillRule::Winding;
            pixmap.fill_path(&path, &colour, whole, Transform::identity(), None);
        }
    }
}

fn outline(mark: Mark, (x, y): (f32, f32)) -> Option<Path> {
    let mut path = PathBuilder::new();
    match mark {
        Mark::True => path.push_circle(x, y, 10.0),
        Mark::Dot => path.push_circle(x, y, 3.0),
        Mark::Gauge => path.push_rect(Rect::from_xywh(x - 5.0, y - 5.0, 10.0, 10.0)?),
        Mark::Found => {
            for side in [-1.0, 1.0] {
                path.move_to(x - 7.0, y - 7.0 * side);
                path.line_to(x + 7.0, y + 7.0 * side);
            }
        }
    }
    path.finish()
}
