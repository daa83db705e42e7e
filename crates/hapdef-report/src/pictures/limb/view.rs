//! How a limb lies on its picture.

use super::super::raster::Vertex;
use super::{LimbPicture, RenderParams, drawing_px};

/// From limb coordinates, m, to pixels.
pub(super) struct View {
    right: [f64; 3],
    up: [f64; 3],
    /// Towards the viewer.
    front: [f64; 3],
    /// Screen coordinates, m, of the picture's middle.
    middle: [f64; 2],
    /// Middle of the drawing, px.
    middle_px: [f64; 2],
    pub(super) px_per_m: f64,
    /// The larger extent on the screen, m.
    pub(super) size_m: f64,
}

impl View {
    pub(super) fn new(picture: &LimbPicture<'_>, params: &RenderParams) -> Self {
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
        let drawn = || picture.triangles.iter().flatten().map(|n| &picture.positions[*n as usize]);
        let extent = |axis: &[f64; 3]| {
            drawn()
                .map(|p| dot(p, axis))
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)))
        };
        let (x, y) = (extent(&right), extent(&up));
        let (w, h) = (x.1 - x.0, y.1 - y.0);
        let room_px = [drawing_px(params), params.height_px].map(|n| f64::from(n) - 24.0);
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

    pub(super) fn vertex(&self, p: [f64; 3], value: f64) -> Vertex {
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
    pub(super) fn light(&self, [a, b, c]: [[f64; 3]; 3]) -> f64 {
        let (u, v) = (sub(&b, &a), sub(&c, &a));
        let normal =
            [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let length = dot(&normal, &normal).sqrt();
        let sun: [f64; 3] =
            std::array::from_fn(|k| 0.8 * self.front[k] + 0.36 * self.right[k] + 0.48 * self.up[k]);
        if length > 0.0 { 0.5 + 0.5 * dot(&normal, &sun).abs() / length } else { 1.0 }
    }
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn sub(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
