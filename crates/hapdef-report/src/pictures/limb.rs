//! Pictures of the limb, coloured by a value: shaded triangles, with words and scales around them.

mod legend;
mod view;

use hapdef_mesh::colour::viridis;
use serde::Serialize;
use tiny_skia::{IntSize, Pixmap};

use self::legend::{Legend, row_svg};
use self::view::View;
use super::marker::{Mark, draw_marker};
use super::raster::Canvas;
use super::unrolled::colour_range;
use crate::argument::{ArgumentError, check_len};
use crate::error::ReportError;

/// Pixels at the right that hold the colour bar, its numbers and their unit.
const BAR_PX: u32 = 84;

/// A contact on a picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LimbMarker {
    /// Position, m.
    pub position: [f64; 3],
    /// What it marks; faint where the limb hides it.
    pub mark: Mark,
}

/// Where there is no value.
const NO_VALUE: [u8; 3] = [205; 3];

/// What to draw.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LimbPicture<'a> {
    /// Above the picture.
    pub title: &'a str,
    /// Quantity and unit of the values, above the colour bar; no bar if empty.
    pub value_label: &'a str,
    /// Nodes, m, `[n]`.
    #[serde(skip)]
    pub positions: &'a [[f64; 3]],
    /// Three nodes each; either side may face outwards.
    #[serde(skip)]
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

/// Draws limbs side by side as one SVG: each in parallel projection with hidden surfaces removed and flat
/// shading, the values in viridis, scaled to fit; its title above, a colour bar with the unit at its right,
/// a length bar below.
///
/// # Errors
/// Lengths that differ, an index out of range, a position that is not finite, nothing to draw, parameters
/// out of range, or no picture at all.
pub fn limb_row_svg(pictures: &[(LimbPicture<'_>, RenderParams)]) -> Result<String, ReportError> {
    if pictures.is_empty() {
        let what = "pictures of a row of limbs";
        return Err(ReportError::TooFew { what, needed: 1, found: 0 });
    }
    let panels = pictures.iter().map(|(picture, params)| panel(picture, params));
    let panels: Vec<Legend<'_>> = panels.collect::<Result<_, _>>()?;
    Ok(row_svg(&panels))
}

fn panel<'a>(picture: &LimbPicture<'a>, params: &RenderParams) -> Result<Legend<'a>, ReportError> {
    check(picture, params)?;
    let scale = colour_range(params.range, picture.values)?;
    let view = View::new(picture, params);
    let png = render(picture, params, &view, scale)?.encode_png();
    Ok(Legend {
        picture: png.map_err(|e| refused(e.to_string()))?,
        size_px: [params.width_px, params.height_px],
        title: picture.title,
        value_label: picture.value_label,
        scale,
        px_per_m: view.px_per_m,
    })
}

/// The limb alone, on white, without the room of the colour bar.
fn render(
    picture: &LimbPicture<'_>,
    params: &RenderParams,
    view: &View,
    scale: [f64; 2],
) -> Result<Pixmap, ReportError> {
    let (width, height) = (drawing_px(params), params.height_px);
    let mut canvas = Canvas::new(width as usize, height as usize, [255; 3]);
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
    let mut pixmap = IntSize::from_wh(width, height)
        .and_then(|size| Pixmap::from_vec(canvas.to_rgba(), size))
        .ok_or_else(|| refused(format!("no picture of {width} x {height} px")))?;
    for marker in picture.markers {
        let at = view.vertex(marker.position, 0.0);
        let hidden = canvas.depth_at(at.x, at.y) > at.depth + 0.02 * view.size_m;
        draw_marker(&mut pixmap, (at.x as f32, at.y as f32), marker.mark, hidden);
    }
    Ok(pixmap)
}

/// Width without the room of the colour bar, px.
fn drawing_px(params: &RenderParams) -> u32 {
    params.width_px - BAR_PX
}

fn refused(message: String) -> ReportError {
    ReportError::Draw { figure: "limb picture", message }
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
            return Err(ArgumentError::Index { what, index, position, len: n }.into());
        }
    }
    if picture.triangles.is_empty() {
        let what = "triangles of the limb picture";
        return Err(ReportError::TooFew { what, needed: 1, found: 0 });
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
    let refuse =
        |what, value, expected| Err(ArgumentError::Parameter { what, value, expected }.into());
    for (what, px) in [("width_px", params.width_px), ("height_px", params.height_px)] {
        if !(128..=2048).contains(&px) {
            return refuse(what, f64::from(px), "128 to 2048");
        }
    }
    for (what, angle) in
        [("azimuth_rad", params.azimuth_rad), ("elevation_rad", params.elevation_rad)]
    {
        if !angle.is_finite() {
            return refuse(what, angle, "finite");
        }
    }
    if params.up_axis > 2 {
        return refuse("up_axis", params.up_axis as f64, "0, 1 or 2");
    }
    Ok(())
}

#[cfg(test)]
mod tests;
