//! Numbers as strokes, for pictures that carry no font.

use tiny_skia::{Paint, PathBuilder, Pixmap, Stroke, Transform};

/// Strokes of a glyph on a grid 4 wide and 6 high, y down; each inner list is a polyline.
#[rustfmt::skip] // a glyph a line
fn strokes(glyph: char) -> &'static [&'static [(f32, f32)]] {
    match glyph {
        '0' => &[&[(1., 0.), (3., 0.), (4., 1.), (4., 5.), (3., 6.), (1., 6.), (0., 5.), (0., 1.), (1., 0.)]],
        '1' => &[&[(0.6, 1.4), (2.2, 0.), (2.2, 6.)]],
        '2' => &[&[(0., 1.), (1., 0.), (3., 0.), (4., 1.), (4., 2.2), (0., 6.), (4., 6.)]],
        '3' => &[&[(0., 0.), (4., 0.), (1.8, 2.4), (3., 2.4), (4., 3.4), (4., 5.), (3., 6.), (1., 6.), (0., 5.)]],
        '4' => &[&[(3., 6.), (3., 0.), (0., 4.2), (4., 4.2)]],
        '5' => &[&[(4., 0.), (0.4, 0.), (0.2, 2.6), (1.2, 2.2), (3., 2.2), (4., 3.2), (4., 5.), (3., 6.), (1., 6.), (0., 5.2)]],
        '6' => &[&[(3.6, 0.3), (2.6, 0.), (1.4, 0.), (0., 1.6), (0., 5.), (1., 6.), (3., 6.), (4., 5.), (4., 3.6), (3., 2.6), (1., 2.6), (0., 3.6)]],
        '7' => &[&[(0., 0.), (4., 0.), (1.4, 6.)]],
        '8' => &[&[(1., 2.8), (0.3, 2.), (0.3, 0.8), (1., 0.), (3., 0.), (3.7, 0.8), (3.7, 2.), (3., 2.8), (1., 2.8), (0., 3.8), (0., 5.), (1., 6.), (3., 6.), (4., 5.), (4., 3.8), (3., 2.8)]],
        '9' => &[&[(0.4, 5.7), (1.4, 6.), (2.6, 6.), (4., 4.4), (4., 1.), (3., 0.), (1., 0.), (0., 1.), (0., 2.4), (1., 3.4), (3., 3.4), (4., 2.4)]],
        '-' => &[&[(0.5, 3.), (3.5, 3.)]],
        '.' => &[&[(1.9, 5.9), (2.1, 5.9)]],
        'e' => &[&[(0.2, 4.2), (3.8, 4.2), (3.8, 3.), (3., 2.2), (1., 2.2), (0.2, 3.2), (0.2, 5.), (1., 6.), (3.6, 6.)]],
        _ => &[],
    }
}

/// Draws a number, such as "-1.5e-6", with its upper left corner at (x, y) px.
pub(super) fn draw_number(
    pixmap: &mut Pixmap,
    text: &str,
    (x, y): (f32, f32),
    height_px: f32,
    paint: &Paint<'_>,
) {
    let unit = height_px / 6.0;
    let mut path = PathBuilder::new();
    let mut left = x;
    for glyph in text.chars() {
        for line in strokes(glyph) {
            for (i, (gx, gy)) in line.iter().enumerate() {
                let (px, py) = (left + gx * unit, y + gy * unit);
                if i == 0 {
                    path.move_to(px, py);
                } else {
                    path.line_to(px, py);
                }
            }
        }
        left += if glyph == '.' { 4.0 } else { 5.6 } * unit;
    }
    let stroke = Stroke {
        width: (0.16 * height_px).max(1.0),
        line_cap: tiny_skia::LineCap::Round,
        line_join: tiny_skia::LineJoin::Round,
        ..Stroke::default()
    };
    if let Some(path) = path.finish() {
        pixmap.stroke_path(&path, paint, &stroke, Transform::identity(), None);
    }
}
