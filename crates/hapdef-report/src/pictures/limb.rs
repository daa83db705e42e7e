//! Pictures of the limb, coloured by a value, as PNG.

use hapdef_mesh::colour::viridis;
use tiny_skia::{FillRule, IntSize, PathBuilder, Pixmap, PixmapPaint, Rect, Transform};

use super::digits::draw_number;
use super::marker::{INK, Mark, draw_marker, paint};
use super::raster::{Canvas, Vertex};
use super::style::tick;
use super::unrolled::colour_range;
use crate::ReportError;
use crate::error::check_len;

/// Pixels at the right that hold the colour bar and its numbers.
const BAR_PX: u32 = 84;

/// A contact on a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimbMarker {
    /// Position, m.
    pub position: [f64; 3],
    /// What it marks; faint where the limb hides it.
    pub mark: Mark,
}

/// Where there is no value.
const NO_VALUE: [u8; 3] = [205; 3];

/// What to draw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimbPicture<'a> {
    /// Nodes, m, `[n]`.
    pub positions: &'a [[f64; 3]],
    /// Three nodes each; either side may face outwards.
    pub triangles: &'a [[u32; 3]],
    /// One value per node, `[n]`, in the unit printed; a triangle with a NaN is grey.
    pub values: &'a [f64],
    /// Contacts.
    pub markers: &'a [LimbMarker],
}

/// How to look at it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderParams {
    /// Coordinate axis that points up: 0 = x, 1 = y, 2 = z.
    pub up_axis: usize,
    /// Where the viewer stands about the up axis, rad, from the next coordinate axis in cyclic
    /// order towards the one after it: the angle of [`super::unroll`] that faces the viewer.
    pub azimuth_rad: f64,
    /// How far above the horizon the viewer stands, rad.
    pub elevation_rad: f64,
    /// Width, px, 128 to 2048; the last 84 hold the colour bar.
    pub width_px: u32,
    /// Height, px, 128 to 2048.
    pub height_px: u32,
    /// Ends of the colour scale; `None` for 0 (or the least value if below) to the largest.
    pub range: Option<[f64; 2]>,
}

impl Default for RenderParams {
    /// From 30° and 20° above, y up (the authors' deck), 640 × 720 px.
    fn default() -> Self {
        Self {
            up_axis: 1,
            azimuth_rad: 30_f64.to_radians(),
            elevation_rad: 20_f64.to_radians(),
            width_px: 640,
            height_px: 720,
            range: None,
        }
    }
}

/// Draws the limb in parallel projection with hidden surfaces removed and flat shading, the
/// values in viridis with a colour bar, on white. Scaled to fit. Returns PNG bytes.
///
/// # Errors
/// Lengths that differ, an index out of range, a position that is not finite, nothing to draw,
/// or parameters out of range.
pub fn render_limb_png(
    picture: &LimbPicture<'_>,
    params: &RenderParams,
) -> Result<Vec<u8>, ReportError> {
    render_limb_row_png(&[(*picture, *params)])
}

/// The same for several pictures side by side.
///
/// # Errors
/// As [`render_limb_png`], and no picture at all.
pub fn render_limb_row_png(
    pictures: &[(LimbPicture<'_>, RenderParams)],
) -> Result<Vec<u8>, ReportError> {
    let drawn = pictures
        .iter()
        .map(|(picture, params)| render(picture, params));
    let drawn: Vec<Pixmap> = drawn.collect::<Result<_, _>>()?;
    let width = drawn.iter().map(Pixmap::width).sum();
    let height = drawn.iter().map(Pixmap::height).max().unwrap_or(0);
    let refuse = |message: String| ReportError::Draw {
        figure: "limb picture",
        message,
    };
    let mut row = Pixmap::new(width, height)
        .ok_or_else(|| refuse(format!("no picture of {width} x {height} px")))?;
    row.fill(tiny_skia::Color::WHITE);
    let mut left = 0;
    for pixmap in &drawn {
        let plain = PixmapPaint::default();
        row.draw_pixmap(
            left,
            0,
            pixmap.as_ref(),
            &plain,
            Transform::identity(),
            None,
        );
        left += pixmap.width() as i32;
    }
    row.encode_png().map_err(|e| refuse(e.to_string()))
}

fn render(picture: &LimbPicture<'_>, params: &RenderParams) -> Result<Pixmap, ReportError> {
    check(picture, params)?;
    let scale = colour_range(params.range, picture.values)?;
    let view = View::new(picture, params);
    let (w, h) = (params.width_px as usize, params.height_px as usize);
    let mut canvas = Canvas::new(w, h, [255; 3]);
    for nodes in picture.triangles {
        let corners = nodes.map(|n| {
            let n = n as usize;
            view.vertex(picture.positions[n], picture.values[n])
        });
        let light = view.light(nodes.map(|n| picture.positions[n as usize]));
        canvas.fill(&corners, |value| {
            let colour = match value.is_finite() {
                true => viridis((value - scale[0]) / (scale[1] - scale[0])),
                false => NO_VALUE,
            };
            colour.map(|c| (f64::from(c) * light).round() as u8)
        });
    }
    let mut pixmap = IntSize::from_wh(params.width_px, params.height_px)
        .and_then(|size| Pixmap::from_vec(canvas.to_rgba(), size))
        .ok_or_else(|| ReportError::Draw {
            figure: "limb picture",
            message: format!("no picture of {w} x {h} px"),
        })?;
    for marker in picture.markers {
        let at = view.vertex(marker.position, 0.0);
        let hidden = canvas.depth_at(at.x, at.y) > at.depth + 0.02 * view.size_m;
        draw_marker(&mut pixmap, (at.x as f32, at.y as f32), marker.mark, hidden);
    }
    if picture.values.iter().any(|value| value.is_finite()) {
        draw_bar(&mut pixmap, scale);
    }
    Ok(pixmap)
}

fn check(picture: &LimbPicture<'_>, params: &RenderParams) -> Result<(), ReportError> {
    let n = picture.positions.len();
    check_len("values of the limb picture", n, picture.values.len())?;
    let positions = picture.positions.iter();
    check_places("positions of the limb picture", positions)?;
    let markers = picture.markers.iter().map(|m| &m.position);
    check_places("markers of the limb picture", markers)?;
    for (position, index) in picture.triangles.iter().flatten().enumerate() {
        let (what, index) = ("node of a triangle of the limb picture", *index as usize);
        if index >= n {
            return Err(ReportError::Index {
                what,
                index,
                position,
                len: n,
            });
        }
    }
    if picture.triangles.is_empty() {
        let what = "triangles of the limb picture";
        return Err(ReportError::TooFew {
            what,
            needed: 1,
            found: 0,
        });
    }
    check_params(params)
}

fn check_places<'a>(
    what: &'static str,
    places: impl Iterator<Item = &'a [f64; 3]>,
) -> Result<(), ReportError> {
    for (index, place) in places.enumerate() {
        if let Some(&value) = place.iter().find(|v| !v.is_finite()) {
            return Err(ReportError::NotFinite { what, index, value });
        }
    }
    Ok(())
}

fn check_params(params: &RenderParams) -> Result<(), ReportError> {
    let refuse = |what, value, expected| {
        Err(ReportError::Parameter {
            what,
            value,
            expected,
        })
    };
    for (what, px) in [
        ("width_px", params.width_px),
        ("height_px", params.height_px),
    ] {
        if !(128..=2048).contains(&px) {
            return refuse(what, f64::from(px), "128 to 2048");
        }
    }
    for (what, angle) in [
        ("azimuth_rad", params.azimuth_rad),
        ("elevation_rad", params.elevation_rad),
    ] {
        if !angle.is_finite() {
            return refuse(what, angle, "finite");
        }
    }
    if params.up_axis > 2 {
        return refuse("up_axis", params.up_axis as f64, "0, 1 or 2");
    }
    Ok(())
}

/// From limb coordinates, m, to pixels.
struct View {
    right: [f64; 3],
    up: [f64; 3],
    /// Towards the viewer.
    front: [f64; 3],
    /// Screen coordinates, m, of the picture's middle.
    middle: [f64; 2],
    /// Middle of the drawing, px.
    middle_px: [f64; 2],
    px_per_m: f64,
    /// The larger extent on the screen, m.
    size_m: f64,
}

impl View {
    fn new(picture: &LimbPicture<'_>, params: &RenderParams) -> Self {
        let (sin_a, cos_a) = params.azimuth_rad.sin_cos();
        let (sin_e, cos_e) = params.elevation_rad.sin_cos();
        let axes = |u: f64, v: f64, w: f64| {
            let mut axis = [0.0; 3];
            axis[(params.up_axis + 1) % 3] = u;
            axis[(params.up_axis + 2) % 3] = v;
            axis[params.up_axis] = w;
            axis
        };
        let right = axes(-sin_a, cos_a, 0.0);
        let up = axes(-sin_e * cos_a, -sin_e * sin_a, cos_e);
        let front = axes(cos_e * cos_a, cos_e * sin_a, sin_e);
        let drawn = || {
            picture
                .triangles
                .iter()
                .flatten()
                .map(|n| &picture.positions[*n as usize])
        };
        let extent = |axis: &[f64; 3]| {
            drawn()
                .map(|p| dot(p, axis))
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
                    (l.min(v), h.max(v))
                })
        };
        let (x, y) = (extent(&right), extent(&up));
        let (w, h) = (x.1 - x.0, y.1 - y.0);
        let room_px = [params.width_px - BAR_PX, params.height_px].map(|n| f64::from(n) - 24.0);
        let px_per_m = (room_px[0] / w).min(room_px[1] / h);
        Self {
            right,
            up,
            front,
            middle: [0.5 * (x.0 + x.1), 0.5 * (y.0 + y.1)],
            middle_px: room_px.map(|n| 0.5 * n + 12.0),
            px_per_m: if px_per_m.is_finite() { px_per_m } else { 1.0 },
            size_m: w.max(h),
        }
    }

    fn vertex(&self, p: [f64; 3], value: f64) -> Vertex {
        let along = dot(&p, &self.right) - self.middle[0];
        let above = dot(&p, &self.up) - self.middle[1];
        Vertex {
            x: self.middle_px[0] + along * self.px_per_m,
            y: self.middle_px[1] - above * self.px_per_m,
            depth: dot(&p, &self.front),
            value,
        }
    }

    /// Brightness of a facet, 0.5 to 1, both sides alike: lit from the viewer's upper right.
    fn light(&self, [a, b, c]: [[f64; 3]; 3]) -> f64 {
        let (u, v) = (sub(&b, &a), sub(&c, &a));
        let normal = [
            u[1] * v[2] - u[2] * v[1],
            u[2] * v[0] - u[0] * v[2],
            u[0] * v[1] - u[1] * v[0],
        ];
        let length = dot(&normal, &normal).sqrt();
        let sun: [f64; 3] =
            std::array::from_fn(|k| 0.8 * self.front[k] + 0.36 * self.right[k] + 0.48 * self.up[k]);
        if length > 0.0 {
            0.5 + 0.5 * dot(&normal, &sun).abs() / length
        } else {
            1.0
        }
    }
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn sub(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn draw_bar(pixmap: &mut Pixmap, scale: [f64; 2]) {
    let left = (pixmap.width() - BAR_PX) as f32 + 8.0;
    let (top, height) = (24.0, (pixmap.height() as f32 - 48.0).min(320.0));
    let n = 128_u16;
    for k in 0..n {
        let colour = viridis(1.0 - f64::from(k) / f64::from(n - 1));
        let y = top + height * f32::from(k) / f32::from(n);
        if let Some(rect) = Rect::from_xywh(left, y, 16.0, height / f32::from(n) + 0.5) {
            let path = PathBuilder::from_rect(rect);
            let transform = Transform::identity();
            pixmap.fill_path(
                &path,
                &paint(colour, 255),
                FillRule::Winding,
                transform,
                None,
            );
        }
    }
    for k in 0..=4_u8 {
        let value = scale[1] - (scale[1] - scale[0]) * f64::from(k) / 4.0;
        let y = top + height * f32::from(k) / 4.0 - 5.0;
        draw_number(
            pixmap,
            &tick(value),
            (left + 22.0, y),
            10.0,
            &paint(INK, 255),
        );
    }
}

#[cfg(test)]
mod tests;
